"""Witnesses of the oscillators: Newton's law x'' = f(t, x, v) by Taylor integration; a period is
the time at which the state returns to the initial one.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from math import floor
from typing import Any

from flint import acb, arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

Force = Callable[[Any, Any, Any], Any]
"""x'' of (t, x, v)."""
METHOD = "Taylor integration of x'' at 58 digits, unproven (refdem/truth/witnesses/oscillators.py)"


def motion(
    acceleration: Force, x0: Fraction, v0: Fraction, times: Sequence[Fraction], claimed: Claimed
) -> Results:
    """x and v at the times, and the period if one is claimed.

    The period is the zero near the claimed value of v if v0 = 0, otherwise of x - x0.
    """
    start = [arb_of(x0), arb_of(v0)]
    solution = Solution(lambda t, y: [y[1], acceleration(t, y[0], y[1])], start)
    for t in times:
        x, v = solution.at(t)
        yield t, {"x": x, "v": v}
    if "period" in claimed and (x0 or v0):
        period = float(claimed["period"])
        if v0 == 0:
            component = 1
            level = v0
        else:
            component = 0
            level = x0

        def change(y: Sequence[arb]) -> arb:
            return y[component] - arb_of(level)

        yield None, {"period": solution.crossing(change, period, period / 64)}


def of(
    acceleration: Callable[[dict[str, arb]], Force],
    *names: str,
    start: tuple[str, str] = ("x0", "v0"),
) -> Witness:
    """The witness of an oscillator with this acceleration, a function of the parameters `names`.

    `start` names the parameters of x0 and v0; an empty name stands for 0.
    """

    def values(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
        x0, v0 = (number(p, name) if name else Fraction(0) for name in start)
        # In a damped motion only turning points, v = 0, repeat after a period.
        if "delta" in names and v0:
            claimed = {}
        force = acceleration({name: arb_of(number(p, name)) for name in names})
        return motion(force, x0, v0, times, claimed)

    return Witness(METHOD, values)


def hanging(p: dict[str, arb]) -> Force:
    """x'' = g - (k/m) x: a spring, and gravity along +x."""
    return lambda t, x, v: p["gravity"] - p["stiffness"] / p["mass"] * x


def viscous(p: dict[str, arb]) -> Force:
    """x'' = g - (k/m) x - 2 delta v: the same with viscous damping."""
    return lambda t, x, v: p["gravity"] - p["stiffness"] / p["mass"] * x - 2 * p["delta"] * v


def driven(p: dict[str, arb]) -> Force:
    """x'' = f0 cos(drive t) - (k/m) x - 2 delta v + g: the same, driven by a force f0 per mass."""
    return lambda t, x, v: (
        (t * p["drive"]).cos() * p["f0"]
        - p["stiffness"] / p["mass"] * x
        - 2 * p["delta"] * v
        + p["gravity"]
    )


def duffing(p: dict[str, arb]) -> Force:
    """x'' = -alpha x - beta x^3."""
    return lambda t, x, v: -p["alpha"] * x - p["beta"] * x * x * x


def driven_duffing(p: dict[str, arb]) -> Force:
    """x'' = f0 cos(drive t) - alpha x - beta x^3 - 2 delta v."""
    return lambda t, x, v: (
        (t * p["drive"]).cos() * p["f0"]
        - p["alpha"] * x
        - p["beta"] * x * x * x
        - 2 * p["delta"] * v
    )


def van_der_pol(p: dict[str, arb]) -> Force:
    """x'' = mu (1 - x^2) x' - x + p sin(drive t)."""
    return lambda t, x, v: (1 - x * x) * v * p["mu"] - x + (t * p["drive"]).sin() * p["p"]


def power(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The power oscillator m x'' = -k |x|^n sgn x; where n is not an integer, by `rooted`.

    For an integer n it is integrated in phases that end at x = 0, since the force is smooth on
    either side. The first phase, from rest, is a quarter of a period, each later one a half.
    """
    exact = numbers(p, "mass", "stiffness", "exponent", "amplitude")
    if exact["exponent"].denominator != 1 and exact["amplitude"]:
        yield from rooted(exact, times)
    if exact["exponent"].denominator != 1 or not exact["amplitude"]:
        return
    n = int(exact["exponent"])
    ratio = arb_of(exact["stiffness"] / exact["mass"])
    quarter = float(claimed["period"]) / 4
    waiting = list(times)
    state = [arb_of(exact["amplitude"]), arb(0)]
    begin = arb(0)
    if exact["amplitude"] > 0:
        sign = 1
    else:
        sign = -1
    phase_number = 1
    while waiting or phase_number <= 3:
        # |x|^n sgn x = sign^(n + 1) x^n, as x has this sign in the whole phase.
        phase = Solution(partial(pulled, n, ratio * sign ** (n + 1)), state, begin=begin)
        if phase_number == 1:
            near = float(begin) + quarter
        else:
            near = float(begin) + 2 * quarter
        end = phase.crossing(lambda y: y[0], near, quarter / 64)
        while waiting and arb_of(waiting[0]) < end:
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if phase_number == 2:
            # The second phase, between two zeros of x, lasts half a period.
            yield None, {"period": 2 * (end - begin)}
        begin = end
        state = phase.at(end)
        sign = -sign
        phase_number += 1


def rooted(exact: Mapping[str, Fraction], times: Sequence[Fraction]) -> Results:
    """The power oscillator with the exponent n = a/b: a quarter of a period, and its reflections.

    The substitution x = s^b, dt = b s^(b-1) dz makes the equations smooth at x = 0: ds/dz = v,
    dv/dz = -(k/m) s^a b s^(b-1), dt/dz = b s^(b-1). The state is (s, v, t).
    """
    a, b = exact["exponent"].as_integer_ratio()
    ratio = arb_of(exact["stiffness"] / exact["mass"])
    amplitude = arb_of(abs(exact["amplitude"]))

    def field(z: Any, y: Sequence[Any]) -> list[Any]:
        time_rate = y[0] ** (b - 1) * b
        return [y[1], -ratio * y[0] ** a * time_rate, time_rate]

    curve = Solution(field, [amplitude.root(b), arb(0), arb(0)])
    # The step of the scan: for b = 2 a 16th of A^(1/b)/sqrt((k/m) A^(n + 1)), which is about the z
    # of a quarter period (ds/dz = v).
    acceleration = ratio * amplitude ** arb_of(Fraction(a + 2 * b - 2, b))
    step = float(1 / acceleration.sqrt() * amplitude.root(b)) / b / 8
    high = step
    while curve.at(arb(high))[0] > 0:
        high += step
    end = curve.crossing(lambda y: y[0], high - step / 2, step / 2)
    quarter = curve.at(end)[2]
    yield None, {"period": 4 * quarter}
    if exact["amplitude"] > 0:
        sign = 1
    else:
        sign = -1
    for t in times:
        quarters = floor(float(arb_of(t) / quarter))
        # With the quarter Q of a period, and x even about t = 0: x(Q + t) = -x(Q - t),
        # x(2 Q + t) = -x(t), x(3 Q + t) = x(Q - t).
        in_quarter = arb_of(t) - quarters * quarter
        # The second quarter is the time reversal of the first one, and so on.
        if quarters % 2 == 0:
            mirrored_time = in_quarter
        else:
            mirrored_time = quarter - in_quarter
        z = curve.bisected(partial(later, mirrored_time), 0.0, float(end))
        s, v, _ = curve.at(z)
        x_sign = (1, -1, -1, 1)[quarters % 4]
        v_sign = (1, 1, -1, -1)[quarters % 4]
        yield t, {"x": sign * x_sign * s**b, "v": sign * v_sign * v}


def later(time: arb, y: Sequence[arb]) -> arb:
    """The time t of a state (s, v, t) minus a given one [s]."""
    return y[2] - time


def pulled(n: int, strength: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates v and -strength x^n of (x, v).

    The strength has the sign that makes the force point to the centre.
    """
    x_power = y[0]
    for _ in range(n - 1):
        x_power = x_power * y[0]
    return [y[1], -strength * x_power]


def steadily_driven(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The motion, and the steady amplitude |f0/(w0^2 - w^2 + 2 i delta w)|, w0^2 = k/m."""
    yield from MOVING.values(p, times, claimed)
    e = {name: arb_of(number(p, name)) for name in ("mass", "stiffness", "delta", "f0", "drive")}
    # w0^2 - w^2 + 2 i delta w
    response = acb(
        e["stiffness"] / e["mass"] - e["drive"] * e["drive"], 2 * e["delta"] * e["drive"]
    )
    if number(p, "drive") and not response.contains(0):
        yield None, {"steady_amplitude": abs(acb(e["f0"]) / response)}


def quadratic(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """x'' = -2 delta x' - w0^2 x - eps x^2 + sum of f0 cos(drive t)."""
    w0, eps, delta = (arb_of(number(p, name)) for name in ("w0", "eps", "delta"))
    drives = [
        (arb_of(f), arb_of(w)) for f, w in zip(vector(p, "f0"), vector(p, "drive"), strict=True)
    ]

    def acceleration(t: Any, x: Any, v: Any) -> Any:
        forced = sum(((t * w).cos() * f for f, w in drives), arb(0))
        return forced - 2 * delta * v - w0 * w0 * x - eps * x * x

    return motion(acceleration, number(p, "x0"), number(p, "v0"), times, claimed)


MOVING = of(driven, "mass", "stiffness", "gravity", "delta", "f0", "drive")
WITNESSES = {
    "harmonic-oscillator": of(hanging, "mass", "stiffness", "gravity"),
    "viscous-oscillator": of(viscous, "mass", "stiffness", "gravity", "delta"),
    "driven-oscillator": Witness(METHOD, steadily_driven),
    "power-oscillator": Witness(METHOD, power),
    "duffing": of(duffing, "alpha", "beta", start=("amplitude", "")),
    "driven-duffing": of(driven_duffing, "alpha", "beta", "delta", "f0", "drive"),
    "van-der-pol": of(van_der_pol, "mu", "p", "drive"),
    "quadratic-response": Witness(METHOD, quadratic),
}
