"""Witnesses of motions in phases: each phase by Taylor integration, its end where a function of the
state vanishes, by the secant.
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
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration phase by phase at 58 digits, unproven (refdem/truth/witnesses/contacts.py)"
)
SCAN = 1 / 64
"""Seconds between the looks for the end of a phase."""


def coulomb(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """m x'' = -k x - f sgn(v), from turning point to turning point, until k|x| <= f holds the
    mass.
    """
    exact = numbers(p, "mass", "stiffness", "friction_force", "x0", "v0")
    m, k, f = (arb_of(exact[name]) for name in ("mass", "stiffness", "friction_force"))
    half = math.pi * math.sqrt(exact["mass"] / exact["stiffness"])
    begin = arb(0)
    x = arb_of(exact["x0"])
    waiting = list(times)
    if exact["v0"]:
        phase = Solution(
            partial(rubbing, -f if exact["v0"] > 0 else f, k, m), [x, arb_of(exact["v0"])]
        )
        steps = (half * n / 16 for n in range(1, 64))
        near = next(t for t in steps if (phase.at(arb(t))[1] > 0) != (exact["v0"] > 0))
        begin = phase.crossing(lambda y: y[1], near - half / 32, half / 32)
        while waiting and arb_of(waiting[0]) < begin:
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        x = phase.at(begin)[0]
    while f < k * abs(x) and waiting:
        if x > 0:
            push = f
        else:
            push = -f
        phase = Solution(partial(rubbing, push, k, m), [x, arb(0)], begin=begin)
        end = phase.crossing(lambda y: y[1], float(begin) + half, half / 16)
        while waiting and arb_of(waiting[0]) < end:
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        begin = end
        x = phase.at(end)[0]
    if not f < k * abs(x):
        yield None, {"stop_time": begin, "stop_position": x} if exact["friction_force"] else {}
        for t in waiting:
            yield t, {"x": x, "v": arb(0)}


def rubbing(push: arb, k: arb, m: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """A spring and a constant force."""
    return [y[1], (push - k * y[0]) / m]


def slope(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Down a slope whose tangent exceeds mu: s'' = g (sin - mu cos) by Taylor integration; else it
    stays.
    """
    gravity = arb_of(number(p, "gravity"))
    friction = arb_of(number(p, "friction"))
    if p["angle"] is not None:
        sine, cosine = arb_of(number(p, "angle")).sin_cos()
    else:
        tangent = arb_of(number(p, "slope"))
        cosine = 1 / (1 + tangent * tangent).sqrt()
        sine = tangent * cosine
    pull = gravity * (sine - friction * cosine)
    found = Solution(partial(falling, pull if pull > 0 else arb(0)), [arb(0), arb(0)])
    for t in times:
        yield t, dict(zip(("s", "v"), found.at(t), strict=True))


def falling(pull: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) under a constant acceleration."""
    return [y[1], pull]


def hertz(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """d'' = -(k/m) d^(3/2) with d = w^2 and dt = w ds: dw/ds = v/2, dv/ds = -(k/m) w^4 are smooth
    at touch; free flight afterwards.
    """
    mass, stiffness, speed = (
        arb_of(p[name]) for name in ("effective_mass", "stiffness", "closing_speed")
    )
    ratio = stiffness / mass
    found = Solution(partial(pressed, ratio), [arb(0), speed, arb(0)])
    scale = float(speed) ** -0.2 * (1.25 / float(ratio)) ** 0.2 * 2 / float(speed) ** 0.4
    last = next(n for n in range(1, 400) if found.at(Fraction(scale * n / 8))[0] < 0)
    end = found.bisected(lambda y: y[0], scale * (last - 1) / 8, scale * last / 8)
    deepest = found.at(found.bisected(lambda y: y[1], scale / 64, float(end)))[0]
    hardest = stiffness * deepest * deepest * deepest
    yield (
        None,
        {
            "duration": found.at(end)[2],
            "max_overlap": deepest * deepest,
            "max_force": hardest,
        },
    )
    for t in times:
        if arb_of(t) < found.at(end)[2]:
            w, v, _ = found.at(found.bisected(partial(beyond, 2, arb_of(t)), 0.0, float(end)))
            yield t, {"overlap": w * w, "v": v}
        else:
            v = found.at(end)[1]
            yield t, {"overlap": v * (arb_of(t) - found.at(end)[2]), "v": v}


def pressed(ratio: arb, s: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of w, v and t by the variable s."""
    w, v, _ = y
    squared = w * w
    return [v / 2, -ratio * squared * squared, w]


def beyond(index: int, mark: arb, y: Sequence[arb]) -> arb:
    """How far a component is beyond a mark."""
    return y[index] - mark


def asymmetric(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The force k1 (x - x1), then k1 |x1| (x2 - x)/x2, nothing outside: phase by phase, ends by a
    scan and bisection.
    """
    e = numbers(p, "mass", "k1", "x1", "x2", "x0", "v0")
    x1, x2, k1, m = (arb_of(e[name]) for name in ("x1", "x2", "k1", "mass"))
    walls = [arb(-(10**9)), x1, arb(0), x2, arb(10**9)]
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
    yield None, {"work": k1 * abs(x1) * (x2 - x1) / 2}
    while waiting:
        phase = Solution(partial(flank, *slopes[region]), state, begin=begin)
        low = walls[region]
        high = walls[region + 1]
        left = _left(phase, low, high, float(begin), float(waiting[-1]))
        while waiting and (left is None or arb_of(waiting[0]) < left[0]):
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if left is not None:
            begin = left[0]
            state = [walls[region + (left[1] > 0)], phase.at(left[0])[1]]
            region = region + left[1]


def wedge(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The collision with a wedge: in with -k2 d^2 to the deepest point, out with -k1 d to touch,
    then free; Newton's law for each.
    """
    e = {name: arb_of(number(p, name)) for name in ("mass", "k1", "k2", "closing_speed")}
    m = e["mass"]
    speed = e["closing_speed"]
    inward = Solution(lambda t, y: [y[1], y[0] * y[0] * (-e["k2"] / m)], [arb(0), speed])
    turn = inward.bisected(lambda y: y[1], 0.0, float(claimed["duration"]))
    deepest = inward.at(turn)[0]
    outward = Solution(lambda t, y: [y[1], y[0] * (-e["k1"] / m)], [deepest, arb(0)], begin=turn)
    near = float(claimed["duration"])
    end = outward.bisected(lambda y: y[0], float(turn), near * 1.05)
    change = (outward.at(end)[1] * outward.at(end)[1] - speed * speed) * m / 2
    yield None, {"duration": end, "max_overlap": deepest, "energy_change": change}
    for t in times:
        if arb_of(t) < end:
            found = (inward if arb_of(t) < turn else outward).at(t)
        else:
            found = [outward.at(end)[1] * (arb_of(t) - end), outward.at(end)[1]]
        yield t, dict(zip(("overlap", "v"), found, strict=True))


def flank(slope: arb, constant: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """A force that is linear in x."""
    return [y[1], slope * y[0] + constant]


def _left(
    phase: Solution, low: arb, high: arb, begin: float, last: float
) -> tuple[arb, int] | None:
    """When and to which side the motion leaves a region, if before the last time."""
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
