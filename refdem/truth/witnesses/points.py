"""Witnesses of point masses: Newton's law in Cartesian coordinates by Taylor integration, with the
constraint force of a rod from its constant length.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration in Cartesian coordinates at 58 digits, unproven"
    " (refdem/truth/witnesses/points.py)"
)


def pendulum(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The pendulum in Cartesian coordinates, with theta integrated from its rate.

        x'' = -T x/(m l),    y'' = -g - T y/(m l),    theta' = (x vy - y vx)/l^2

    with the force of the rod T = m (v^2 - g y)/l, which follows from r . r'' = -v^2. The state is
    (x, y, vx, vy, theta).
    """
    length, gravity, mass, theta0, rate0 = (
        arb_of(number(p, name)) for name in ("length", "gravity", "mass", "theta0", "thetadot0")
    )
    sine, cosine = theta0.sin_cos()

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        x, y, vx, vy, _ = s
        # T/(m l) = (v^2 - g y)/l^2, theta' = (x vy - y vx)/l^2
        rod = (vx * vx + vy * vy - y * gravity) / (length * length)
        thetadot = (x * vy - y * vx) / (length * length)
        return [vx, vy, -rod * x, -rod * y - gravity, thetadot]

    start = [
        length * sine,
        -length * cosine,
        length * rate0 * cosine,
        length * rate0 * sine,
        theta0,
    ]
    solution = Solution(field, start)
    for t in times:
        x, y, vx, vy, theta = solution.at(t)
        # T = m (v^2 - g y)/l, and theta' = (x vy - y vx)/l^2.
        force = mass * (vx * vx + vy * vy - gravity * y) / length
        thetadot = (x * vy - y * vx) / (length * length)
        yield t, {"theta": theta, "thetadot": thetadot, "x": x, "y": y, "rod_force": force}
    if "period" in claimed:
        period = float(claimed["period"])
        if rate0 == 0:
            turns = 0
        else:
            gain = solution.at(Fraction(period))[4] - theta0
            turns = round(float(gain / (2 * arb.pi())))

        def from_return(s: Sequence[arb]) -> arb:
            """A function that is 0 after a period.

            It is l^2 theta' if the start is at rest, otherwise theta - theta0 - 2 pi turns.
            """
            if rate0 == 0:
                return s[0] * s[3] - s[1] * s[2]
            return s[4] - theta0 - 2 * arb.pi() * turns

        yield None, {"period": solution.crossing(from_return, period, period / 64)}


def orbit(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """An orbit in Kepler's field or on a central spring, from the apse on the +x axis.

    r'' = -gm r/|r|^3 from x = a (1 - e) with v_y^2 = gm (1 + e)/(a (1 - e)); or r'' = -w^2 r from
    x = a with v_y = w a sqrt(1 - e^2), w^2 = k/m. The period is the zero of y near the claimed one.
    """
    is_spring = p["stiffness"] is not None
    exact = numbers(p, "gm", "semi_major", "eccentricity")
    a = exact["semi_major"]
    e = exact["eccentricity"]
    if is_spring:
        strength = arb_of(number(p, "stiffness") / _mass(p))
        x0 = arb_of(a)
        # v_y = w a sqrt(1 - e^2), w^2 = k/m
        v0 = arb_of(a) * arb_of(1 - e * e).sqrt() * strength.sqrt()
    else:
        strength = arb_of(exact["gm"])
        x0 = arb_of(a * (1 - e))
        # v_y^2 = gm (1 + e)/(a (1 - e))
        v0 = (strength * arb_of((1 + e) / (a * (1 - e)))).sqrt()

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        x, y, vx, vy = s
        # r'' = -factor r: the factor is w^2 of the spring, or gm/|r|^3.
        if is_spring:
            factor = strength
        else:
            factor = strength / ((x * x + y * y) * (x * x + y * y).sqrt())
        return [vx, vy, -x * factor, -y * factor]

    solution = Solution(field, [x0, arb(0), arb(0), v0])
    for t in times:
        yield t, dict(zip(("x", "y", "vx", "vy"), solution.at(t), strict=True))
    if "period" in claimed:
        period = float(claimed["period"])
        yield None, {"period": solution.crossing(lambda s: s[1], period, period / 256)}


def _mass(p: Mapping[str, Exact]) -> Fraction:
    """The mass [kg] of the body, or 1 if the case has no such parameter."""
    if "mass" in p:
        return number(p, "mass")
    return Fraction(1)


def free(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A free body, r' = v and q' = omega q/2 with constant v and omega along z; or bodies at rest.

    The state is (x, y, z, q); members other than "free" are those of `balanced`.
    """
    if p["member"] != "free":
        yield from balanced(p, times)
        return
    velocity = [arb_of(x) for x in vector(p, "velocity")]
    spin = arb_of(number(p, "spin"))

    def field(t: Any, s: Sequence[Any]) -> list[Any]:
        # q' = (0, 0, 0, omega_z) q/2
        w, x, y, z = s[3:]
        return [*velocity, -spin * z / 2, -spin * y / 2, spin * x / 2, spin * w / 2]

    solution = Solution(field, [arb(0)] * 3 + [arb(1), arb(0), arb(0), arb(0)])
    for t in times:
        s = solution.at(t)
        quantities = {"omega.x": arb(0), "omega.y": arb(0), "omega.z": spin}
        for i, axis in enumerate("xyz"):
            quantities[axis] = s[i]
            quantities[f"v{axis}"] = velocity[i]
        for i, axis in enumerate("wxyz"):
            quantities[f"attitude.{axis}"] = s[3 + i]
        yield t, quantities


def balanced(p: Mapping[str, Any], times: Sequence[Fraction]) -> Results:
    """Bodies of equal weight stacked on the ground, at rest if each contact bears the weight above.

    With a stiffness k the force of a contact is -k gap, where the gap is negative. Without one, a
    contact with the gap 0 can have any compressive force. No values are given for bodies that are
    not in equilibrium.
    """
    weight = p["weight"]
    stiffness = p["stiffness"]
    heights = p["heights"]
    gaps = [
        high - low - size
        for low, high, size in zip((0, *heights), heights, p["sizes"], strict=False)
    ]
    count = len(gaps)
    # Contact i bears the bodies i, i + 1, ...: -k gap_i = weight (count - i).
    weights_above = [weight * (count - i) for i in range(count)]
    if stiffness:
        is_balanced = [-gap * stiffness for gap in gaps] == weights_above
    else:
        is_balanced = all(gap == 0 for gap in gaps)
    if not is_balanced:
        return
    at_rest = {}
    for i in range(count):
        for axis in "xyz":
            at_rest[f"r{i + 1}.{axis}"] = arb(0)
            at_rest[f"v{i + 1}.{axis}"] = arb(0)
    for t in times:
        yield t, dict(at_rest)


WITNESSES = {
    "pendulum": Witness(METHOD, pendulum),
    "two-body-orbit": Witness(METHOD, orbit),
    "newtons-first-law": Witness(METHOD, free),
}
