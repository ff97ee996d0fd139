"""Witnesses of masses with constraints: pendulums, coupled pendulums, a captured mass, a pendulum
over a wheel, and rigid clusters.

A witness integrates the motion in other coordinates than the truth: Cartesian ones with the forces
of the rods where the truth has angles, arbitrary axes of a body where the truth has principal ones.
A field is a function (t, state) -> state' for taylor.Solution; the state is a list of Arb balls or
power series.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb, arb_mat, fmpq, fmpq_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = "Taylor integration at 58 digits, unproven (refdem/truth/witnesses/linked.py)"


def captured(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The captured mass: a straight line from (-2 R, -R) to (0, -R), then a circle of radius R.

    The circle is integrated from r'' = -(v^2/r^2) r. The scalars are omega = v/R and J = m R^2.
    """
    e = numbers(p, "mass", "speed", "radius")
    speed = arb_of(e["speed"])
    radius = arb_of(e["radius"])
    capture_time = 2 * e["radius"] / e["speed"]
    circle = Solution(held, [arb(0), -radius, speed, arb(0)], begin=arb_of(capture_time))
    for t in times:
        if t <= capture_time:
            state = [speed * arb_of(t) - 2 * radius, -radius, speed, arb(0)]
        else:
            state = circle.at(t)
        yield t, dict(zip(("x", "y", "vx", "vy"), state, strict=True))
    yield None, {"omega": speed / radius, "inertia": arb_of(e["mass"]) * radius * radius}


def held(t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of a point at a constant distance from the origin: acceleration -(v^2/r^2) r."""
    x, y, vx, vy = s
    pull = (vx * vx + vy * vy) / (x * x + y * y)
    return [vx, vy, -x * pull, -y * pull]


def standing(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A pendulum released at rest, `delta` [rad] from its upper or lower equilibrium.

    It is integrated in Cartesian coordinates with the force of the rod (`swinging`).
    """
    e = numbers(p, "length", "gravity", "delta")
    length = arb_of(e["length"])
    gravity = arb_of(e["gravity"])
    sine, cosine = arb_of(e["delta"]).sin_cos()
    if p["position"] == "top":
        up = 1
    else:
        up = -1
    start = [length * sine, up * length * cosine, arb(0), arb(0)]
    solution = Solution(partial(swinging, length, gravity), start)
    for t in times:
        yield t, dict(zip(("x", "y", "vx", "vy"), solution.at(t), strict=True))


def swinging(length: arb, gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of a pendulum: x'' = -T x, y'' = -g - T y with T = (v^2 - g y)/l^2.

    T is the force of the rod per mass and length. It follows from r . r'' = -v^2, the second
    derivative of r . r = l^2.
    """
    x, y, vx, vy = s
    rod = (vx * vx + vy * vy - y * gravity) / (length * length)
    return [vx, vy, -rod * x, -rod * y - gravity]


def kapitza(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The Kapitza pendulum with its drive as a function of time, and its Floquet multipliers.

    l theta'' = (g + y'') sin theta for a pivot at y = a cos(w t), with theta = 0 at the top. The
    multipliers mu of the equation linearised at the top are the roots of mu^2 - D mu + 1 = 0, where
    D is the trace of its fundamental matrix after one period. For |D| <= 2 they have the modulus 1,
    which is then given for both.
    """
    names = ("length", "gravity", "drive_amplitude", "drive", "theta0", "thetadot0")
    e = {name: arb_of(number(p, name)) for name in names}
    solution = Solution(partial(lifted, e), [e["theta0"], e["thetadot0"]])
    for t in times:
        yield t, dict(zip(("theta", "thetadot"), solution.at(t), strict=True))
    identity = [arb(1), arb(0), arb(0), arb(1)]
    period = 2 * arb.pi() / e["drive"]
    at_period = Solution(partial(near_the_top, e), identity).at(period)
    trace = at_period[0] + at_period[3]
    # mu = (D +- sqrt(D^2 - 4))/2, the one of larger modulus first.
    if trace * trace > 4:
        root = (trace * trace - 4).sqrt()
        larger = (abs(trace) + root) / 2 * trace.sgn()
        smaller = (abs(trace) - root) / 2 * trace.sgn()
    else:
        larger = arb(1)
        smaller = arb(1)
    yield None, {"floquet_1": larger, "floquet_2": smaller}


def near_the_top(e: Mapping[str, arb], t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of two solutions (x, x') of l x'' = (g + y'') x, y'' = -a w^2 cos(w t)."""
    pivot = (t * e["drive"]).cos() * (e["drive_amplitude"] * e["drive"] * e["drive"])
    stiffness = (e["gravity"] - pivot) / e["length"]
    return [s[1], stiffness * s[0], s[3], stiffness * s[2]]


def lifted(e: Mapping[str, arb], t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of (theta, thetadot): l theta'' = (g - a w^2 cos(w t)) sin theta."""
    theta, thetadot = s
    pivot = (t * e["drive"]).cos() * (e["drive_amplitude"] * e["drive"] * e["drive"])
    return [thetadot, (e["gravity"] - pivot) * theta.sin() / e["length"]]


def double(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The double pendulum in Cartesian coordinates, each bob relative to its point of suspension.

    The state is d1, d1', d2, d2' (2 components each) and the two angles. An angle is integrated
    from theta' = (d x d')/d^2, so that it is continuous.
    """
    m1, m2 = (arb_of(m) for m in vector(p, "masses"))
    lengths = [arb_of(x) for x in vector(p, "lengths")]
    angles = [arb_of(x) for x in vector(p, "theta0")]
    rates = [arb_of(x) for x in vector(p, "thetadot0")]
    start = []
    for length, angle, rate in zip(lengths, angles, rates, strict=True):
        sine, cosine = angle.sin_cos()
        start += [length * sine, -length * cosine, length * rate * cosine, length * rate * sine]
    field = partial(hung, m1, m2, arb_of(number(p, "gravity")))
    solution = Solution(field, [*start, *angles])
    for t in times:
        *_, theta1, theta2 = solution.at(t)
        *_, thetadot1, thetadot2 = field(t, solution.at(t))
        yield (
            t,
            {"theta1": theta1, "theta2": theta2, "thetadot1": thetadot1, "thetadot2": thetadot2},
        )


def hung(m1: arb, m2: arb, gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of a double pendulum: d1 = r1 and d2 = r2 - r1 with their rates, and the angles.

    With the forces L1 and L2 of the rods per length:

        m1 r1'' = -L1 d1 + L2 d2 + m1 g,    m2 r2'' = -L2 d2 + m2 g,
        d1 . d1'' = -|d1'|^2,    d2 . d2'' = -|d2'|^2    (constant lengths)

    The accelerations put into the last two give linear equations for L1 and L2:

        L1 d1.d1/m1 - L2 d1.d2/m1 = |d1'|^2 + d1 . g,
        -L1 d1.d2/m1 + L2 d2.d2 (1/m1 + 1/m2) = |d2'|^2.
    """
    x1, y1, vx1, vy1, x2, y2, vx2, vy2 = s[:8]
    square1 = x1 * x1 + y1 * y1
    square2 = x2 * x2 + y2 * y2
    product = x1 * x2 + y1 * y2
    right1 = vx1 * vx1 + vy1 * vy1 - gravity * y1
    right2 = vx2 * vx2 + vy2 * vy2
    k11 = square1 / m1
    k12 = -product / m1
    k22 = square2 * (1 / m1 + 1 / m2)
    # k11 L1 + k12 L2 = right1,  k12 L1 + k22 L2 = right2, by Cramer's rule.
    determinant = k11 * k22 - k12 * k12
    l1 = (right1 * k22 - right2 * k12) / determinant
    l2 = (right2 * k11 - right1 * k12) / determinant
    # d1'' = (L2 d2 - L1 d1)/m1 + g,  d2'' = r2'' - r1'' = -L2 d2/m2 + g - d1''
    ax1 = (l2 * x2 - l1 * x1) / m1
    ay1 = (l2 * y2 - l1 * y1) / m1 - gravity
    ax2 = -l2 * x2 / m2 - ax1
    ay2 = -l2 * y2 / m2 - gravity - ay1
    # theta' = (d x d')/d^2
    thetadot1 = (x1 * vy1 - y1 * vx1) / square1
    thetadot2 = (x2 * vy2 - y2 * vx2) / square2
    return [vx1, vy1, ax1, ay1, vx2, vy2, ax2, ay2, thetadot1, thetadot2]


def coupled(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two pendulums joined by a spring, in Cartesian coordinates, each bob relative to its pivot.

    The state is d1, d1', d2, d2' (2 components each) and the two angles. An angle is integrated
    from theta' = (d x d')/d^2, so that it is continuous.
    """
    lengths = [arb_of(x) for x in vector(p, "lengths")]
    angles = [arb_of(x) for x in vector(p, "theta0")]
    rates = [arb_of(x) for x in vector(p, "thetadot0")]
    start = []
    for length, angle, rate in zip(lengths, angles, rates, strict=True):
        sine, cosine = angle.sin_cos()
        start += [length * sine, -length * cosine, length * rate * cosine, length * rate * sine]
    constants = numbers(p, "distance", "gravity", "stiffness", "spring_length")
    field = partial(joined, [arb_of(m) for m in vector(p, "masses")], constants)
    solution = Solution(field, [*start, *angles])
    for t in times:
        state = solution.at(t)
        *_, theta1, theta2 = state
        *_, thetadot1, thetadot2 = field(t, state)
        yield (
            t,
            {"theta1": theta1, "theta2": theta2, "thetadot1": thetadot1, "thetadot2": thetadot2},
        )


def joined(masses: Sequence[arb], e: Mapping[str, Fraction], t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of two pendulums on a spring: d1, d2 with their rates, and the angles.

    With D = (distance, 0) + d2 - d1 and its length s, the spring exerts f = k (1 - s0/s) D on bob 1
    and -f on bob 2. The rod of each bob adds -L d:

        m d'' = m g +- f - L d,    d . d'' = -|d'|^2    (constant length)
        L |d|^2/m = |d'|^2 + d . (g +- f/m)
    """
    x1, y1, _, _, x2, y2, _, _ = s[:8]
    # D = (distance, 0) + d2 - d1, and f = k (1 - s0/|D|) D = force D.
    spring_x = x2 - x1 + arb_of(e["distance"])
    spring_y = y2 - y1
    force = arb_of(e["stiffness"])
    if e["spring_length"]:
        length = (spring_x * spring_x + spring_y * spring_y).sqrt()
        force = force - arb_of(e["stiffness"] * e["spring_length"]) / length
    rates: list[Any] = []
    turning: list[Any] = []
    for bob, sign in ((0, 1), (1, -1)):
        x, y, vx, vy = s[4 * bob : 4 * bob + 4]
        mass = masses[bob]
        # a = g +- f/m, and the rod has L/m = (|d'|^2 + d . a)/|d|^2 and d'' = a - (L/m) d.
        ax = force * spring_x * sign / mass
        ay = force * spring_y * sign / mass - arb_of(e["gravity"])
        square = x * x + y * y
        rod = (vx * vx + vy * vy + x * ax + y * ay) / square
        rates += [vx, vy, ax - rod * x, ay - rod * y]
        turning.append((x * vy - y * vx) / square)
    return rates + turning


def over_wheel(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A pendulum on a string over a wheel, with a counter mass at the other end of the string.

    The state is (r, theta, u, m r^2 theta') with the speed u = r' - R theta' of the string.
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
    # A = M + m + J/R^2, the coefficient of u^2/2 in the kinetic energy; A = M + m for R = 0.
    string_mass = e["mass"] + e["counter_mass"]
    if number(p, "wheel_radius"):
        string_mass = string_mass + e["wheel_inertia"] / (e["wheel_radius"] * e["wheel_radius"])
    start = [
        e["r0"],
        e["theta0"],
        e["rdot0"] - e["wheel_radius"] * e["thetadot0"],
        e["mass"] * e["r0"] * e["r0"] * e["thetadot0"],
    ]
    solution = Solution(partial(wound, e, string_mass), start)
    for t in times:
        r, theta, u, momentum = solution.at(t)
        thetadot = momentum / (e["mass"] * r * r)
        rdot = u + e["wheel_radius"] * thetadot
        yield t, {"r": r, "theta": theta, "rdot": rdot, "thetadot": thetadot}


def wound(e: Mapping[str, arb], string_mass: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The field of (r, theta, u, p) with p = m r^2 theta' and `string_mass` A, by Lagrange.

    A u' = m r theta'^2 - M g + m g cos theta
    d/dt (p - A R u) = M g R - m g (R cos theta + r sin theta)
    """
    r, theta, u, momentum = s
    m = e["mass"]
    counter = e["counter_mass"]
    radius = e["wheel_radius"]
    gravity = e["gravity"]
    thetadot = momentum / (r * r * m)
    # A u' = m r theta'^2 - M g + m g cos theta
    string_force = r * thetadot * thetadot * m - counter * gravity + theta.cos() * (m * gravity)
    u_rate = string_force / string_mass
    # p' = A R u' + M g R - m g (R cos theta + r sin theta)
    momentum_rate = (
        u_rate * (string_mass * radius)
        + counter * gravity * radius
        - (theta.cos() * radius + r * theta.sin()) * (m * gravity)
    )
    return [u + thetadot * radius, thetadot, u_rate, momentum_rate]


def cluster(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The rigid cluster in the axes in which it is given, which need not be principal axes.

    The attitude q starts at 1, and q' = q omega_body/2 with omega_body = J^-1 R(q)^T L and the
    angular momentum L, which is constant in space. r_i = c + R(q) (r_i(0) - c).
    """
    masses = vector(p, "masses")
    flat = vector(p, "positions")
    total = sum(masses)
    points = [flat[3 * i : 3 * i + 3] for i in range(4)]
    # c = sum m r/M
    centre = []
    for k in range(3):
        moment = sum((m * r[k] for m, r in zip(masses, points, strict=True)), Fraction(0))
        centre.append(moment / total)
    arms = [[r[k] - centre[k] for k in range(3)] for r in points]
    tensor = [[_moment(masses, arms, i, j) for j in range(3)] for i in range(3)]
    omega = vector(p, "omega")
    # L = J omega at the start, where the axes of the body are those of space.
    momentum = []
    for row in tensor:
        momentum.append(arb_of(sum((row[j] * omega[j] for j in range(3)), Fraction(0))))
    exact_tensor = fmpq_mat([[fmpq(x.numerator, x.denominator) for x in row] for row in tensor])
    inverse = arb_mat(exact_tensor.inv())
    field = partial(spun, momentum, inverse.table())
    solution = Solution(field, [arb(1), arb(0), arb(0), arb(0)])
    for t in times:
        # r_i = c + R(q) (r_i(0) - c)
        r = rotation(solution.at(t))
        positions = {}
        for i, arm in enumerate(arms, 1):
            for k, axis in enumerate("xyz"):
                turned_arm = sum((r[k][j] * arb_of(arm[j]) for j in range(3)), arb(0))
                positions[f"r{i}.{axis}"] = arb_of(centre[k]) + turned_arm
        yield t, positions


def _moment(
    masses: Sequence[Fraction], arms: Sequence[Sequence[Fraction]], i: int, j: int
) -> Fraction:
    """The entry J_ij = sum m (r^2 delta_ij - r_i r_j) of the inertia tensor [kg m^2]."""
    entry = Fraction(0)
    for m, r in zip(masses, arms, strict=True):
        if i == j:
            entry += m * sum(x * x for x in r)
        entry -= m * r[i] * r[j]
    return entry


def rotation(q: Sequence[Any]) -> list[list[Any]]:
    """The rotation matrix of q, from body to space axes."""
    w, x, y, z = q
    row_x = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    row_y = [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    row_z = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    return [row_x, row_y, row_z]


def spun(
    momentum: Sequence[arb], inverse: Sequence[Sequence[arb]], t: Any, q: Sequence[Any]
) -> list[Any]:
    """The field of the attitude q (4): q' = q omega_body/2 with omega_body = J^-1 R^T L."""
    r = rotation(q)
    # R^T L, the angular momentum in body axes.
    body = [sum((r[k][i] * momentum[k] for k in range(3)), arb(0)) for i in range(3)]
    # (a, b, c) is omega_body/2.
    a, b, c = (sum((inverse[i][j] * body[j] for j in range(3)), arb(0)) / 2 for i in range(3))
    w, x, y, z = q
    # q' = q (0, a, b, c)
    w_rate = -x * a - y * b - z * c
    x_rate = w * a + y * c - z * b
    y_rate = w * b + z * a - x * c
    z_rate = w * c + x * b - y * a
    return [w_rate, x_rate, y_rate, z_rate]


WITNESSES = {
    "captured-mass": Witness(METHOD, captured),
    "pendulum-equilibria": Witness(METHOD, standing),
    "kapitza-pendulum": Witness(METHOD, kapitza),
    "double-pendulum": Witness(METHOD, double),
    "coupled-pendulums": Witness(METHOD, coupled),
    "pendulum-wheel-mass": Witness(METHOD, over_wheel),
    "rigid-cluster": Witness(METHOD, cluster),
}
