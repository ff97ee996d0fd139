"""Witnesses of motions in phases: each phase by Taylor integration; the end of a phase is a zero of
a function of the state, found by the secant method or bisection.
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration phase by phase at 58 digits, unproven (refdem/truth/witnesses/contacts.py)"
)
SCAN = 1 / 64
"""Step [s] in which a phase is searched for its end."""


def coulomb(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The Coulomb oscillator m x'' = -k x - f sgn(v), from turning point to turning point.

    The mass stops at the first turning point with k|x| <= f. If v0 is not 0, the phase up to the
    first turning point comes first.
    """
    exact = numbers(p, "mass", "stiffness", "friction_force", "x0", "v0")
    m, k, f = (arb_of(exact[name]) for name in ("mass", "stiffness", "friction_force"))
    half_period = math.pi * math.sqrt(exact["mass"] / exact["stiffness"])
    begin = arb(0)
    x = arb_of(exact["x0"])
    waiting = list(times)
    if exact["v0"]:
        if exact["v0"] > 0:
            friction = -f
        else:
            friction = f
        phase = Solution(partial(rubbing, friction, k, m), [x, arb_of(exact["v0"])])
        steps = (half_period * n / 16 for n in range(1, 64))
        turned = next(t for t in steps if (phase.at(arb(t))[1] > 0) != (exact["v0"] > 0))
        begin = phase.crossing(lambda y: y[1], turned - half_period / 32, half_period / 32)
        while waiting and arb_of(waiting[0]) < begin:
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        x = phase.at(begin)[0]
    while f < k * abs(x) and waiting:
        # From a turning point the mass moves towards x = 0, so that the friction is f sgn(x). The
        # next turning point is half a period pi sqrt(m/k) later.
        if x > 0:
            friction = f
        else:
            friction = -f
        phase = Solution(partial(rubbing, friction, k, m), [x, arb(0)], begin=begin)
        end = phase.crossing(lambda y: y[1], float(begin) + half_period, half_period / 16)
        while waiting and arb_of(waiting[0]) < end:
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        begin = end
        x = phase.at(end)[0]
    if not f < k * abs(x):
        if exact["friction_force"]:
            yield None, {"stop_time": begin, "stop_position": x}
        for t in waiting:
            yield t, {"x": x, "v": arb(0)}


def rubbing(friction: arb, k: arb, m: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) for m x'' = friction - k x with a constant friction force."""
    return [y[1], (friction - k * y[0]) / m]


def slope(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A block on a slope of angle a: s'' = g (sin a - mu cos a) if that is positive, else s'' = 0.

    The slope is given by `angle` = a [rad], or by `slope` = tan a.
    """
    gravity = arb_of(number(p, "gravity"))
    friction = arb_of(number(p, "friction"))
    if p["angle"] is not None:
        sine, cosine = arb_of(number(p, "angle")).sin_cos()
    else:
        # cos a = 1/sqrt(1 + tan^2 a),  sin a = tan a cos a
        tangent = arb_of(number(p, "slope"))
        cosine = 1 / (1 + tangent * tangent).sqrt()
        sine = tangent * cosine
    # s'' = g (sin a - mu cos a), or 0 where friction holds the block.
    acceleration = gravity * (sine - friction * cosine)
    if not acceleration > 0:
        acceleration = arb(0)
    solution = Solution(partial(falling, acceleration), [arb(0), arb(0)])
    for t in times:
        yield t, dict(zip(("s", "v"), solution.at(t), strict=True))


def falling(acceleration: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) under a constant acceleration."""
    return [y[1], acceleration]


def hertz(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Hertz's spheres, d'' = -(k/m) d^(3/2), as a curve (w, v, t) in s; free flight afterwards.

    The substitution d = w^2, dt = w ds makes the equations analytic at d = 0: dw/ds = v/2, dv/ds =
    -(k/m) w^4, dt/ds = w. The contact ends where w = 0 again; the overlap is largest where v = 0.
    """
    mass, stiffness, speed = (
        arb_of(p[name]) for name in ("effective_mass", "stiffness", "closing_speed")
    )
    k_over_m = stiffness / mass
    curve = Solution(partial(pressed, k_over_m), [arb(0), speed, arb(0)])
    # The contact lasts over a range of s of the size w_max/v0: w_max = (5 m v0^2/(4 k))^(1/5), as
    # m v0^2/2 = (2/5) k d_max^(5/2). The end, w < 0, is searched in eighths of 2 v0^(-3/5) (5 m/(4
    # k))^(1/5).
    scale = float(speed) ** -0.2 * (1.25 / float(k_over_m)) ** 0.2 * 2 / float(speed) ** 0.4
    last = next(n for n in range(1, 400) if curve.at(Fraction(scale * n / 8))[0] < 0)
    end = curve.bisected(lambda y: y[0], scale * (last - 1) / 8, scale * last / 8)
    _, end_speed, duration = curve.at(end)
    turn = curve.bisected(lambda y: y[1], scale / 64, float(end))
    max_w = curve.at(turn)[0]
    max_force = stiffness * max_w * max_w * max_w
    yield None, {"duration": duration, "max_overlap": max_w * max_w, "max_force": max_force}
    for t in times:
        if arb_of(t) < duration:
            s = curve.bisected(partial(beyond, 2, arb_of(t)), 0.0, float(end))
            w, v, _ = curve.at(s)
            yield t, {"overlap": w * w, "v": v}
        else:
            yield t, {"overlap": end_speed * (arb_of(t) - duration), "v": end_speed}


def pressed(k_over_m: arb, s: Any, y: Sequence[Any]) -> list[Any]:
    """The derivatives of (w, v, t) by s: v/2, -(k/m) w^4 and w."""
    w, v, _ = y
    squared = w * w
    return [v / 2, -k_over_m * squared * squared, w]


def beyond(index: int, mark: arb, y: Sequence[arb]) -> arb:
    """The component `index` of the state minus `mark`."""
    return y[index] - mark


def asymmetric(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The asymmetric field: a force that is linear in x between the edges x1 < 0, 0 and x2 > 0.

    It is k1 (x - x1) for x1 < x < 0, k1 |x1| (x2 - x)/x2 for 0 < x < x2, and 0 elsewhere. A phase
    ends at an edge of its region, found by a scan and bisection.
    """
    e = numbers(p, "mass", "k1", "x1", "x2", "x0", "v0")
    x1, x2, k1, m = (arb_of(e[name]) for name in ("x1", "x2", "k1", "mass"))
    walls = [arb(-(10**9)), x1, arb(0), x2, arb(10**9)]
    # x'' = slope x + constant in the four regions, as pairs (slope, constant). On the right of 0,
    # k1 |x1| (x2 - x)/x2 = (k1 x1/x2) x - k1 x1.
    slopes = [
        (arb(0), arb(0)),
        (k1 / m, -k1 * x1 / m),
        (k1 * x1 / x2 / m, -k1 * x1 / m),
        (arb(0), arb(0)),
    ]
    begin = arb(0)
    state = [arb_of(e["x0"]), arb_of(e["v0"])]
    waiting = list(times)
    region = sum(
        e["x0"] > wall or (e["x0"] == wall and e["v0"] > 0) for wall in (e["x1"], 0, e["x2"])
    )
    # The work from x1 to x2 is the area of a triangle of height k1 |x1| on the base x2 - x1.
    yield None, {"work": k1 * abs(x1) * (x2 - x1) / 2}
    while waiting:
        phase = Solution(partial(flank, *slopes[region]), state, begin=begin)
        low = walls[region]
        high = walls[region + 1]
        departure = _left(phase, low, high, float(begin), float(waiting[-1]))
        while waiting and (departure is None or arb_of(waiting[0]) < departure[0]):
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if departure is not None:
            begin, side = departure
            if side > 0:
                edge = high
            else:
                edge = low
            state = [edge, phase.at(begin)[1]]
            region = region + side


def wedge(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The collision with a wedge: m d'' = -k2 d^2 up to the largest overlap, then m d'' = -k1 d.

    The contact ends where d = 0 again.
    """
    e = {name: arb_of(number(p, name)) for name in ("mass", "k1", "k2", "closing_speed")}
    m = e["mass"]
    speed = e["closing_speed"]
    inward = Solution(lambda t, y: [y[1], y[0] * y[0] * (-e["k2"] / m)], [arb(0), speed])
    turn = inward.bisected(lambda y: y[1], 0.0, float(claimed["duration"]))
    max_overlap = inward.at(turn)[0]
    start_out = [max_overlap, arb(0)]
    outward = Solution(lambda t, y: [y[1], y[0] * (-e["k1"] / m)], start_out, begin=turn)
    duration = float(claimed["duration"])
    end = outward.bisected(lambda y: y[0], float(turn), duration * 1.05)
    end_speed = outward.at(end)[1]
    # Delta E = m/2 (v_out^2 - v_in^2)
    energy_change = (end_speed * end_speed - speed * speed) * m / 2
    yield None, {"duration": end, "max_overlap": max_overlap, "energy_change": energy_change}
    for t in times:
        time = arb_of(t)
        if time < end and time < turn:
            overlap, v = inward.at(t)
        elif time < end:
            overlap, v = outward.at(t)
        else:
            overlap = end_speed * (time - end)
            v = end_speed
        yield t, {"overlap": overlap, "v": v}


def flank(slope: arb, constant: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) for x'' = slope x + constant."""
    return [y[1], slope * y[0] + constant]


def _left(
    phase: Solution, low: arb, high: arb, begin: float, last: float
) -> tuple[arb, int] | None:
    """The time at which x leaves the interval from low to high, and the side: -1 or 1.

    None if x stays in it up to the time `last` [s].
    """
    t = begin
    while t <= last:
        t += SCAN
        x = phase.at(Fraction(t))[0]
        for wall, side in ((low, -1), (high, 1)):
            if (x - wall) * side > 0:
                return phase.bisected(partial(beyond, 0, wall), t - SCAN, t), side
    return None


WITNESSES = {
    "coulomb-oscillator": Witness(METHOD, coulomb),
    "block-on-slope": Witness(METHOD, slope),
    "hertz-spheres": Witness(METHOD, hertz),
    "wedge-collision": Witness(METHOD, wedge),
    "asymmetric-field": Witness(METHOD, asymmetric),
}
