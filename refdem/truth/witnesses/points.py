"""Witnesses of point masses: Newton's law in Cartesian coordinates by Taylor integration,
constraint forces from their definition.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration in Cartesian coordinates at 58 digits, unproven"
    " (refdem/truth/witnesses/points.py)"
)


def pendulum(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """x'' = -T x/(m l), y'' = -g - T y/(m l), T = m (v^2 - g y)/l; theta from its rate (x vy - y
    vx)/l^2.
    """
    length, gravity, mass, theta0, rate0 = (
        arb_of(number(p, name)) for name in ("length", "gravity", "mass", "theta0", "thetadot0")
    )
    sine, cosine = theta0.sin_cos()

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        x, y, vx, vy, _ = s
        pull = (vx * vx + vy * vy - y * gravity) / (length * length)
        return [vx, vy, -pull * x, -pull * y - gravity, (x * vy - y * vx) / (length * length)]

    start = [
        length * sine,
        -length * cosine,
        length * rate0 * cosine,
        length * rate0 * sine,
        theta0,
    ]
    found = Solution(field, start)
    for t in times:
        x, y, vx, vy, theta = found.at(t)
        force = mass * (vx * vx + vy * vy - gravity * y) / length
        yield (
            t,
            {
                "theta": theta,
                "thetadot": (x * vy - y * vx) / (length * length),
                "x": x,
                "y": y,
                "rod_force": force,
            },
        )
    if "period" in claimed:
        near = float(claimed["period"])
        if rate0 == 0:
            turns = 0
        else:
            turns = round((float(found.at(Fraction(near))[4]) - float(theta0)) / 6.283185307179586)

        def goal(s: Sequence[arb], rate0: Any = rate0, turns: int = turns) -> arb:
            if rate0 == 0:
                return s[0] * s[3] - s[1] * s[2]
            return s[4] - theta0 - 2 * arb.pi() * turns

        yield None, {"period": found.crossing(goal, near, near / 64)}


def orbit(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Kepler's law or a spring to the centre, from the apse on +x."""
    spring = p["stiffness"] is not None
    exact = numbers(p, "gm", "semi_major", "eccentricity")
    a = exact["semi_major"]
    e = exact["eccentricity"]
    strength = arb_of(number(p, "stiffness") / _mass(p) if spring else exact["gm"])
    if spring:
        start = [arb_of(a), arb(0), arb(0), arb_of(a) * arb_of(1 - e * e).sqrt() * strength.sqrt()]
    else:
        start = [
            arb_of(a * (1 - e)),
            arb(0),
            arb(0),
            (strength * arb_of((1 + e) / (a * (1 - e)))).sqrt(),
        ]

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        x, y, vx, vy = s
        if spring:
            pull = strength
        else:
            pull = strength / ((x * x + y * y) * (x * x + y * y).sqrt())
        return [vx, vy, -x * pull, -y * pull]

    found = Solution(field, start)
    for t in times:
        yield t, dict(zip(("x", "y", "vx", "vy"), found.at(t), strict=True))
    if "period" in claimed:
        near = float(claimed["period"])
        yield None, {"period": found.crossing(lambda s: s[1], near, near / 256)}


def _mass(p: Mapping[str, Exact]) -> Fraction:
    if "mass" in p:
        return number(p, "mass")
    return Fraction(1)


def free(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """A body that nothing acts on: r' = v, v' = 0, qdot = omega q/2; bodies in balance."""
    if p["member"] != "free":
        yield from balanced(p, times)
        return
    velocity = [arb_of(x) for x in vector(p, "velocity")]
    spin = arb_of(number(p, "spin"))

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        w, x, y, z = s[3:]
        return [*velocity, -spin * z / 2, -spin * y / 2, spin * x / 2, spin * w / 2]

    found = Solution(field, [arb(0)] * 3 + [arb(1), arb(0), arb(0), arb(0)])
    for t in times:
        s = found.at(t)
        seen = {axis: s[i] for i, axis in enumerate("xyz")} | {
            f"v{axis}": velocity[i] for i, axis in enumerate("xyz")
        }
        seen |= {f"attitude.{axis}": s[3 + i] for i, axis in enumerate("wxyz")}
        yield t, seen | {"omega.x": arb(0), "omega.y": arb(0), "omega.z": spin}


def balanced(p: Mapping[str, Any], times: Sequence[Fraction]) -> Said:
    """Bodies of one weight on each other over the ground: nothing moves if the forces between them,
    which may only push, add up to zero.

    With a stiffness the overlaps make them; without, touching exactly (no gap, no overlap) is what
    lets them be the weight above.
    """
    weight = p["weight"]
    stiffness = p["stiffness"]
    sizes = p["sizes"]
    gaps = [
        high - low - size
        for low, high, size in zip((0, *p["heights"]), p["heights"], sizes, strict=False)
    ]
    above = [weight * (len(gaps) - i) for i in range(len(gaps))]
    if stiffness:
        pushes = [-gap * stiffness for gap in gaps]
    else:
        pushes = [load if gap == 0 else None for gap, load in zip(gaps, above, strict=True)]
    if pushes == above:
        for t in times:
            yield (
                t,
                {
                    f"{kind}{i + 1}.{axis}": arb(0)
                    for i in range(len(gaps))
                    for kind in "rv"
                    for axis in "xyz"
                },
            )


WITNESSES = {
    "pendulum": Witness(METHOD, pendulum),
    "two-body-orbit": Witness(METHOD, orbit),
    "newtons-first-law": Witness(METHOD, free),
}
