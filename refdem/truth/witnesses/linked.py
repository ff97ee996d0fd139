"""Witnesses of linked masses: rigid clusters, pendulums of two rods or on a moving pivot, captured
and standing masses.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb, arb_mat, fmpq, fmpq_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = "Taylor integration at 58 digits, unproven (refdem/truth/witnesses/linked.py)"


def captured(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Straight from (-2 r, -r) to (0, -r), then held by the force -m v^2 r/r^2 alone."""
    e = numbers(p, "mass", "speed", "radius")
    speed = arb_of(e["speed"])
    radius = arb_of(e["radius"])
    caught = 2 * e["radius"] / e["speed"]
    circle = Solution(held, [arb(0), -radius, speed, arb(0)], begin=arb_of(caught))
    for t in times:
        straight = [speed * arb_of(t) - 2 * radius, -radius, speed, arb(0)]
        yield (
            t,
            dict(
                zip(("x", "y", "vx", "vy"), straight if t <= caught else circle.at(t), strict=True)
            ),
        )
    yield None, {"omega": speed / radius, "inertia": arb_of(e["mass"]) * radius * radius}


def held(t: Any, s: Sequence[Any]) -> list[Any]:
    """A point whose distance from the origin stays: acceleration -v^2 r/r^2."""
    x, y, vx, vy = s
    pull = (vx * vx + vy * vy) / (x * x + y * y)
    return [vx, vy, -x * pull, -y * pull]


def standing(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """A pendulum let go `delta` from the top or the bottom, in Cartesian coordinates with the rod's
    force.
    """
    e = numbers(p, "length", "gravity", "delta")
    length = arb_of(e["length"])
    gravity = arb_of(e["gravity"])
    sine, cosine = arb_of(e["delta"]).sin_cos()
    if p["position"] == "top":
        up = 1
    else:
        up = -1
    found = Solution(
        partial(swinging, length, gravity), [length * sine, up * length * cosine, arb(0), arb(0)]
    )
    for t in times:
        yield t, dict(zip(("x", "y", "vx", "vy"), found.at(t), strict=True))


def swinging(length: arb, gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """x'' = -T x, y'' = -g - T y with T = (v^2 - g y)/l^2."""
    x, y, vx, vy = s
    pull = (vx * vx + vy * vy - y * gravity) / (length * length)
    return [vx, vy, -pull * x, -pull * y - gravity]


def kapitza(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """l theta'' = (g + y'') sin theta for a pivot at y = a cos(w t), theta from the top."""
    e = {
        name: arb_of(number(p, name))
        for name in ("length", "gravity", "drive_amplitude", "drive", "theta0", "thetadot0")
    }
    found = Solution(partial(lifted, e), [e["theta0"], e["thetadot0"]])
    for t in times:
        yield t, dict(zip(("theta", "thetadot"), found.at(t), strict=True))
    whole = Solution(partial(near_the_top, e), [arb(1), arb(0), arb(0), arb(1)]).at(
        2 * arb.pi() / e["drive"]
    )
    trace = whole[0] + whole[3]
    if trace * trace > 4:
        root = (trace * trace - 4).sqrt()
    else:
        root = arb(0)
    far = (abs(trace) + root) / 2
    near = (abs(trace) - root) / 2
    yield (
        None,
        dict.fromkeys(("floquet_1", "floquet_2"), arb(1))
        if root == 0
        else {
            "floquet_1": far * trace.sgn(),
            "floquet_2": near * trace.sgn(),
        },
    )


def near_the_top(e: Mapping[str, arb], t: Any, s: Sequence[Any]) -> list[Any]:
    """Two solutions of l x'' = (g + y'') x."""
    stiffness = (
        e["gravity"] - (t * e["drive"]).cos() * (e["drive_amplitude"] * e["drive"] * e["drive"])
    ) / e["length"]
    return [s[1], stiffness * s[0], s[3], stiffness * s[2]]


def lifted(e: Mapping[str, arb], t: Any, s: Sequence[Any]) -> list[Any]:
    """Rates of theta and thetadot."""
    lift = (t * e["drive"]).cos() * (e["drive_amplitude"] * e["drive"] * e["drive"])
    return [s[1], (e["gravity"] - lift) * s[0].sin() / e["length"]]


def double(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The two bobs in Cartesian coordinates relative to what they hang from; the rods' forces from
    |r1'|^2 + r1.r1'' = 0 and the like.
    """
    (m1, m2), lengths = (
        (arb_of(m) for m in vector(p, "masses")),
        [arb_of(x) for x in vector(p, "lengths")],
    )
    angles = [arb_of(x) for x in vector(p, "theta0")]
    rates = [arb_of(x) for x in vector(p, "thetadot0")]
    start = []
    for length, angle, rate in zip(lengths, angles, rates, strict=True):
        sine, cosine = angle.sin_cos()
        start += [length * sine, -length * cosine, length * rate * cosine, length * rate * sine]
    found = Solution(partial(hung, m1, m2, arb_of(number(p, "gravity"))), [*start, *angles])
    for t in times:
        s = found.at(t)
        turning = [
            (s[k] * s[k + 3] - s[k + 1] * s[k + 2]) / (s[k] * s[k] + s[k + 1] * s[k + 1])
            for k in (0, 4)
        ]
        yield t, {"theta1": s[8], "theta2": s[9], "thetadot1": turning[0], "thetadot2": turning[1]}


def hung(m1: arb, m2: arb, gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """d1 = r1, d2 = r2 - r1: m1 r1'' = -L1 d1 + L2 d2 + m1 g, m2 r2'' = -L2 d2 + m2 g, with d.d'' =
    -|d'|^2 for both.
    """
    x, y, u, v, a, b, c, d = s[:8]
    squares = (x * x + y * y, a * a + b * b)
    across = x * a + y * b
    # d1.d1'' = -|d1'|^2 and d2.d2'' = -|d2'|^2 in the unknown L1, L2
    first = u * u + v * v - gravity * y
    second = c * c + d * d
    k11 = squares[0] / m1
    k12 = -across / m1
    k21 = -across / m1
    k22 = squares[1] * (1 / m1 + 1 / m2)
    whole = k11 * k22 - k12 * k21
    l1 = (first * k22 - second * k12) / whole
    l2 = (second * k11 - first * k21) / whole
    ax = (l2 * a - l1 * x) / m1
    ay = (l2 * b - l1 * y) / m1 - gravity
    bx = -l2 * a / m2 - ax
    by = -l2 * b / m2 - gravity - ay
    return [u, v, ax, ay, c, d, bx, by, (x * v - y * u) / squares[0], (a * d - b * c) / squares[1]]


def over_wheel(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Lagrange's equations for u = r' - R theta' and m r^2 theta', A = M + m + J/R^2: A u' and d/dt
    (m r^2 theta' - A R u).
    """
    names = (
        "mass",
        "counter_mass",
        "wheel_radius",
        "wheel_inertia",
        "gravity",
        "r0",
        "theta0",
        "rdot0",
        "thetadot0",
    )
    e = {name: arb_of(number(p, name)) for name in names}
    radius = number(p, "wheel_radius")
    whole = (
        e["mass"]
        + e["counter_mass"]
        + (e["wheel_inertia"] / (e["wheel_radius"] * e["wheel_radius"]) if radius else 0)
    )
    start = [
        e["r0"],
        e["theta0"],
        e["rdot0"] - e["wheel_radius"] * e["thetadot0"],
        e["mass"] * e["r0"] * e["r0"] * e["thetadot0"],
    ]
    found = Solution(partial(wound, e, whole), start)
    for t in times:
        r, theta, u, spin = found.at(t)
        turning = spin / (e["mass"] * r * r)
        yield (
            t,
            {
                "r": r,
                "theta": theta,
                "rdot": u + e["wheel_radius"] * turning,
                "thetadot": turning,
            },
        )


def wound(e: Mapping[str, arb], whole: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """Rates of r, theta, u and m r^2 theta'."""
    r, theta, u, spin = s
    m = e["mass"]
    counter = e["counter_mass"]
    radius = e["wheel_radius"]
    gravity = e["gravity"]
    turning = spin / (r * r * m)
    slower = (r * turning * turning * m - counter * gravity + theta.cos() * (m * gravity)) / whole
    torque = (
        slower * (whole * radius)
        + counter * gravity * radius
        - (theta.cos() * radius + r * theta.sin()) * (m * gravity)
    )
    return [u + turning * radius, turning, slower, torque]


def cluster(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """A rigid body in any axes: L stays in space, omega_body = J^-1 R^T L, qdot = q omega_body/2;
    no principal axis is looked for.
    """
    masses = vector(p, "masses")
    flat = vector(p, "positions")
    total = sum(masses)
    points = [flat[3 * i : 3 * i + 3] for i in range(4)]
    centre = [
        sum((m * r[k] for m, r in zip(masses, points, strict=True)), Fraction(0)) / total
        for k in range(3)
    ]
    arms = [[r[k] - centre[k] for k in range(3)] for r in points]
    tensor = [[_moment(masses, arms, i, j) for j in range(3)] for i in range(3)]
    omega = vector(p, "omega")
    momentum = [
        arb_of(sum((tensor[i][j] * omega[j] for j in range(3)), Fraction(0))) for i in range(3)
    ]
    inverse = arb_mat(
        fmpq_mat([[fmpq(x.numerator, x.denominator) for x in row] for row in tensor]).inv()
    )
    found = Solution(partial(spun, momentum, inverse.table()), [arb(1), arb(0), arb(0), arb(0)])
    for t in times:
        turned = rotation(found.at(t))
        places = {}
        for i, arm in enumerate(arms, 1):
            for k, axis in enumerate("xyz"):
                places[f"r{i}.{axis}"] = arb_of(centre[k]) + sum(
                    (turned[k][j] * arb_of(arm[j]) for j in range(3)), arb(0)
                )
        yield t, places


def _moment(
    masses: Sequence[Fraction], arms: Sequence[Sequence[Fraction]], i: int, j: int
) -> Fraction:
    """J_ij = sum m (r^2 delta_ij - r_i r_j)."""
    return sum(
        (
            m * ((sum(x * x for x in r) if i == j else 0) - r[i] * r[j])
            for m, r in zip(masses, arms, strict=True)
        ),
        Fraction(0),
    )


def rotation(q: Sequence[Any]) -> list[list[Any]]:
    """The rotation matrix of q, from body to space axes."""
    w, x, y, z = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def spun(
    momentum: Sequence[arb], inverse: Sequence[Sequence[arb]], t: Any, q: Sequence[Any]
) -> list[Any]:
    """The rate of change of the attitude q (4)."""
    turned = rotation(q)
    body = [sum((turned[k][i] * momentum[k] for k in range(3)), arb(0)) for i in range(3)]
    a, b, c = (sum((inverse[i][j] * body[j] for j in range(3)), arb(0)) / 2 for i in range(3))
    w, x, y, z = q
    return [
        -x * a - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    ]


WITNESSES = {
    "captured-mass": Witness(METHOD, captured),
    "pendulum-equilibria": Witness(METHOD, standing),
    "kapitza-pendulum": Witness(METHOD, kapitza),
    "double-pendulum": Witness(METHOD, double),
    "pendulum-wheel-mass": Witness(METHOD, over_wheel),
    "rigid-cluster": Witness(METHOD, cluster),
}
