"""Values at parameters that no certified set has, by mpmath (1.4) at 60 digits, from the
definitions of the cases alone.

    python -m tests.properties.held_out.by_mpmath > tests/properties/held_out/values.txt

Motions by mpmath's Taylor integrator, elliptic and beta functions by quadrature or its own, statics
by integrals and matrices. Nothing of refdem is imported: each equation is written here once more. A
line: case, parameters, time, quantity, 48 digits.
"""

import json

from mpmath import beta, cos, cosh, exp, findroot, lu_solve, matrix, mp, mpf, pi, quad, sin, sqrt

from tests.properties.held_out.mpmath_impacts import impacts
from tests.properties.held_out.mpmath_motions import (
    bodies,
    cluster,
    oscillators,
    pendulums,
    torqued,
    undamped,
)
from tests.properties.held_out.mpmath_sections import sections
from tests.properties.held_out.mpmath_tools import FOUND, case, f

POINTS = "0,0,0,2,1/2,-1,1,3,1/4,-1,5/4,3,2,-3/2,1/2"


def points():
    """Single points in the plane and on a line."""
    e = f("1/3")
    a = f("3/2")
    gm = mpf(2)
    t = f("11/4")
    n = sqrt(gm / a**3)
    big = findroot(lambda x: x - e * sin(x) - n * t, n * t)
    speed = n / (1 - e * cos(big))
    case(
        "two-body-orbit",
        {"gm": "2", "semi_major": "3/2", "eccentricity": "1/3"},
        "11/4",
        x=a * (cos(big) - e),
        y=a * sqrt(1 - e * e) * sin(big),
        vx=-a * speed * sin(big),
        vy=a * sqrt(1 - e * e) * speed * cos(big),
    )
    angle = (f("5") - 2 * f("3/2") / 2) * 2 / f("3/2")
    case(
        "captured-mass",
        {"speed": "2", "radius": "3/2"},
        "5",
        x=f("3/2") * sin(angle),
        y=-f("3/2") * cos(angle),
        vx=2 * cos(angle),
        vy=2 * sin(angle),
    )
    pull = f("9.8125") * (f("3/5") - f("4/5") / 3)
    case(
        "block-on-slope",
        {"friction": "1/3", "mass": "2"},
        "3/2",
        s=pull * f("9/8"),
        v=pull * f("3/2"),
    )
    # x1 = -1 is reached at 1/8, then x'' = 3 (x + 1)
    w = sqrt(mpf(3))
    case(
        "asymmetric-field",
        {"k1": "3", "v0": "2"},
        "1/4",
        x=-1 + 2 / w * mp.sinh(w / 8),
        v=2 * cosh(w / 8),
    )
    x = f("2/7")
    for _ in range(9):
        x = f("7/2") * x * (1 - x)
    case("logistic", {"eta": "7/2", "x0": "2/7"}, "9", x_n=x)


def billiards():
    """Nine bounces in the stadium: straight walls y = +-1 for |x| <= 1, half circles about (+-1, 0)
    of radius 1 (size 4, 2).
    """
    x = f("1/3")
    y = f("1/7")
    dx = f("5/13")
    dy = f("12/13")
    for _ in range(5):
        ways = []
        if dy:
            s = ((1 if dy > 0 else -1) - y) / dy
            if abs(x + s * dx) <= 1:
                ways.append((s, 0, 1 if dy > 0 else -1))
        for side in (1, -1):
            b = (x - side) * dx + y * dy
            c = (x - side) ** 2 + y * y - 1
            s = -b + sqrt(max(b * b - c, mpf(0)))
            if b * b > c and s > mpf(10) ** -30 and side * (x + s * dx) >= 1:
                ways.append((s, x + s * dx - side, y + s * dy))
        s, nx, ny = min((way for way in ways if way[0] > mpf(10) ** -30), key=lambda way: way[0])
        x = x + s * dx
        y = y + s * dy
        along = dx * nx + dy * ny
        dx = dx - 2 * along * nx
        dy = dy - 2 * along * ny
    case(
        "billiards",
        {"start": "1/3,1/7", "direction": "5,12"},
        "5",
        position_o_x=x,
        position_o_y=y,
        direction_o_x=dx,
        direction_o_y=dy,
    )


def collisions():
    """With contact laws."""
    m = f("3/4")
    k = mpf(700)
    v = f("3/2")
    deep = (f("5/4") * m * v * v / k) ** f("2/5")
    case(
        "hertz-spheres",
        {"effective_mass": "3/4", "stiffness": "700", "closing_speed": "3/2"},
        None,
        max_overlap=deep,
        duration=f("4/5") * beta(f("2/5"), f("1/2")) * deep / v,
        max_force=k * deep ** f("3/2"),
    )
    case(
        "hertz-spheres",
        {"effective_mass": "3/4", "stiffness": "700", "closing_speed": "3/2"},
        "1/64",
        overlap=findroot(
            lambda d: (
                deep / v * quad(lambda u: 2 * u / sqrt(1 - u**5), [0, sqrt(d / deep)]) - f("1/64")
            ),
            f("0.02"),
        ),
    )
    m = mpf(2)
    k1 = mpf(3)
    k2 = mpf(7)
    v = f("5/4")
    deep = (f("3/2") * m * v * v / k2) ** f("1/3")
    case(
        "wedge-collision",
        {"mass": "2", "k1": "3", "k2": "7", "closing_speed": "5/4"},
        None,
        max_overlap=deep,
        duration=beta(f("1/3"), f("1/2")) / 3 * deep / v + pi / 2 * sqrt(m / k1),
        energy_change=k1 * deep**2 / 2 - m * v * v / 2,
    )
    corner()
    meff = f("3/4")
    k = mpf(200)
    c = mpf(2)
    b = c / (2 * meff)
    w = sqrt(k / meff - (c / (2 * meff)) ** 2)
    t = f("1/8")
    d = exp(-b * t) * sin(w * t) / w
    rate = exp(-b * t) * (cos(w * t) - b / w * sin(w * t))
    case(
        "two-spheres",
        {"masses": "1,3", "stiffness": "200", "damping": "2"},
        "1/8",
        r1_o_x=-f("3/4") * (1 - d),
        v1_o_x=f("3/4") * rate,
        r2_o_x=(1 - d) / 4,
        v2_o_x=-rate / 4,
    )
    case(
        "two-spheres",
        {"masses": "1,3", "stiffness": "200", "damping": "2"},
        None,
        duration=pi / w,
        restitution=exp(-b * pi / w),
    )
    g = f("9.80665")
    friction = f("1/4")
    u = f("3/4")
    stop = f("2/7") * u / (friction * g)
    case(
        "impact-benchmarks",
        {"member": "dem-04", "friction": "1/4", "speed": "3/4"},
        "1/5",
        v_o_x=f("5/7") * u,
        r_o_x=u * stop - friction * g * stop**2 / 2 + f("5/7") * u * (f("1/5") - stop),
        omega_o_z=-f("5/7") * u / f("0.05"),
    )


def corner():
    """A corner of a box on a plane: J from v' = v + J/m, w' = x J/I and v' + w' x = -e v, x being
    the arm of the lowest corner along the plane.
    """
    m = mpf(3)
    a = f("6/5")
    b = f("1/2")
    e = f("2/3")
    first = f("2/5")
    corners = [
        (cos(first) * p - sin(first) * q, sin(first) * p + cos(first) * q)
        for p in (-a / 2, a / 2)
        for q in (-b / 2, b / 2)
    ]
    x, below = min(corners, key=lambda place: place[1])
    v = -f("3/2")
    moment = m * (a * a + b * b) / 12
    equations = matrix([[1, 0, -1 / m], [0, 1, -x / moment], [1, x, 0]])
    rise, turning, _ = lu_solve(equations, matrix([v, 0, -e * v]))
    met = (2 + below) / -v
    t = f("9/8")
    case(
        "corner-impact",
        {
            "mass": "3",
            "sides": "6/5,1/2",
            "angle": "2/5",
            "height": "2",
            "velocity": "1/3,-3/2",
            "restitution": "2/3",
        },
        "9/8",
        x=t / 3,
        y=-below + rise * (t - met),
        vx=f("1/3"),
        vy=rise,
        theta=first + turning * (t - met),
        omega=turning,
    )


def statics():
    """Integrals, matrices, products."""
    e = f("3/4")
    n = f("1/25")
    s = f("3/2")
    t0 = f("5/4")
    phi = pi * n * s**3 / 6
    rate = 4 * sqrt(pi) * n * s * s * sqrt(t0) * (1 - phi / 2) / (1 - phi) ** 3
    case(
        "granular-gas",
        {"restitution": "3/4", "density": "1/25", "diameter": "3/2", "t0": "5/4"},
        None,
        collision_frequency=rate,
        haff_time=6 / ((1 - e * e) * rate),
    )
    case(
        "degrees-of-freedom",
        {"points": POINTS},
        None,
        **{f"{d}d__{k}": mpf(d * k - mp_rank(k, d)) for d in (2, 3) for k in range(1, 6)},
    )
    p = (mpf(2), mpf(-1), f("1/3"), mpf(1))
    q = (mpf(1), mpf(3), f("-1/2"), f("1/4"))
    product = of(p) * of(q)
    case(
        "quaternions",
        {"p": "2,-1,1/3,1", "q": "1,3,-1/2,1/4"},
        None,
        **{f"p__q_o_{i}": product[i, 0] for i in range(4)},
    )


def bifurcations():
    """Folds as extrema of the force at a fixed drive, doublings as cycles of multiplier -1."""
    alpha, beta, delta, f0 = f("5/4"), f("1/3"), f("1/8"), f("7/5")

    def square(s, q):
        return s * ((alpha + 3 * beta * s / 4 - q) ** 2 + 4 * delta**2 * q)

    found = {}
    for name, s, q in (("lower", "2", "3"), ("upper", "9", "7/2")):
        fold = findroot(
            [lambda s, q: square(s, q) - f0**2, lambda s, q: mp.diff(square, (s, q), (1, 0))],
            (f(s), f(q)),
        )
        found |= {f"{name}__fold_o_0": sqrt(fold[1]), f"{name}__fold_o_1": sqrt(fold[0])}
    amplitude = f("9/5")
    for i, q in enumerate(("1", "3")):
        drive = findroot(lambda q: square(amplitude**2, q) - f0**2, mpf(q))
        found[f"drives_o_{i}"] = sqrt(drive)
        found[f"forces_o_{i}"] = sqrt(square(amplitude**2, drive))
    for period, x, eta in ((1, "0.66", "2.99"), (2, "0.85", "3.44"), (4, "0.883", "3.544")):
        found[f"doubling__of__{period}"] = findroot(
            [
                lambda x, eta, n=period: cycled(x, eta, n)[0] - x,
                lambda x, eta, n=period: cycled(x, eta, n)[1] + 1,
            ],
            (mpf(x), mpf(eta)),
        )[1]
    eta = f("10/3")
    for i, x in enumerate(("0.83", "0.47")):
        found[f"two__cycle_o_{i}"] = findroot(lambda x: cycled(x, eta, 2)[0] - x, mpf(x))
    given = {
        "alpha": "5/4",
        "beta": "1/3",
        "delta": "1/8",
        "f0": "7/5",
        "amplitude": "9/5",
        "eta": "10/3",
    }
    case("bifurcations", given, None, **found)


def cycled(x, eta, count):
    """The iterate of the logistic map after so many, and its derivative by x."""
    slope = mpf(1)
    for _ in range(count):
        slope *= eta * (1 - 2 * x)
        x = eta * x * (1 - x)
    return x, slope


def solids():
    """By slices, and turns by exponentials."""
    a, b, c = f("3/2"), f("2/3"), mpf(2)  # half-axes; density 1/2
    slice_ = lambda x: pi * b * c * (1 - (x / a) ** 2)  # noqa: E731
    mean = lambda x: slice_(x) * (b * b * (1 - (x / a) ** 2)) / 4  # noqa: E731
    squares = quad(lambda x: x * x * slice_(x), [-a, a]), quad(mean, [-a, a])
    corner = quad(lambda x: x * (1 - x / a) ** 2, [0, a]) * b * c / 2
    case(
        "moments-of-inertia",
        {"a": "3/2", "b": "2/3", "c": "2", "attitude": "1,0,0,0"},
        None,
        ellipsoid_o_mass=quad(slice_, [-a, a]) / 2,
        ellipsoid_o_inertia_o_zz=(squares[0] + squares[1]) / 2,
        tetrahedron_o_mass=a * b * c / 12,
        tetrahedron_o_centre_o_x=corner / (a * b * c / 6),
    )
    phi = f("1/3")
    theta = f("5/4")
    psi = f("-2/3")
    whole = turned(2, phi) * turned(0, theta) * turned(2, psi)
    case(
        "rotations",
        {"euler": "1/3,5/4,-2/3", "angle": "2/5"},
        None,
        **{f"euler__matrix_o_{i}": whole[i // 3, i % 3] for i in range(9)},
        plane__turn_o_0=f("3/5") * cos(f("2/5")) + f("4/5") * sin(f("2/5")),
    )


def turned(axis, angle):
    """exp of the generator of turns about an axis."""
    i = (axis + 1) % 3
    k = (axis + 2) % 3
    generator = matrix(3, 3)
    generator[k, i] = angle
    generator[i, k] = -angle
    return mp.expm(generator, method="taylor")


def of(q):
    """Left multiplication by a quaternion as a real matrix."""
    w, x, y, z = q
    return matrix([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def mp_rank(count, dimensions):
    """Rank of the rods' Jacobian of the first points."""
    text = POINTS.split(",")
    places = [[f(x) for x in text[3 * i : 3 * i + dimensions]] for i in range(count)]
    rows = []
    for i in range(count):
        for j in range(i):
            row = [mpf(0)] * (dimensions * count)
            for k in range(dimensions):
                row[dimensions * i + k], row[dimensions * j + k] = (
                    places[i][k] - places[j][k],
                    places[j][k] - places[i][k],
                )
            rows.append(row)
    if rows:
        return sum(
            int(value > mpf(10) ** -40) for value in mp.svd_r(matrix(rows), compute_uv=False)
        )
    return 0


if __name__ == "__main__":
    for family in (
        oscillators,
        undamped,
        pendulums,
        bodies,
        torqued,
        cluster,
        points,
        billiards,
        collisions,
        impacts,
        statics,
        bifurcations,
        sections,
        solids,
    ):
        family()
    print(*sorted(map(json.dumps, FOUND)), sep="\n")
