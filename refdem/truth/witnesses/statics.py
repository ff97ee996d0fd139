"""Witnesses of cases without time: counts by ranks modulo a prime, solids by cubature, rotations by
products of turns.

A cubature `Rule` yields pairs (weight, point): the sums of weight, weight r_i and weight r_i r_j
are the volume and the first and second moments of a solid, exactly, because each rule is exact for
polynomials of the degree that these integrals have. Quaternions are (w, x, y, z), Euler's angles
z-x-z, matrices lead from the body to space.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import Any

from flint import arb, arb_mat, nmod_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.koenig import of_points
from refdem.truth.witnesses.quaternion_rules import rules
from refdem.truth.witnesses.turned_body import of_body, of_triangle
from refdem.truth.witnesses.turns import (
    about,
    commuting,
    euler_by_turns,
    hamilton,
    of_a_step,
    of_multiples,
    rate_matrices,
    row_by_row,
    swept,
)

PRIME = 2**61 - 1
"""Modulus of the elimination, a Mersenne prime: a rank is too low by chance in 1 of 10^18 matrices.
"""
PLACE = "(refdem/truth/witnesses/statics.py)"
BOOLE = [(Fraction(weight, 90), Fraction(k, 4)) for k, weight in enumerate((7, 32, 12, 32, 7))]
"""Boole's rule: weights and points of a rule on [0, 1] that is exact to the fifth degree."""
Point = Sequence[Any]
Rule = Iterator[tuple[Any, Point]]
"""Weights (volumes) and points whose sums are the integrals of polynomials of second degree over a
solid.
"""


def rank(rows: Sequence[Sequence[Fraction]]) -> int:
    """The rank of a matrix of exact numbers, computed modulo a prime.

    The rank modulo a prime is at most the true rank. It is smaller only if the prime divides all
    minors of that size, which is improbable for a prime far above the numbers here.
    """
    if not rows:
        return 0
    entries = []
    for row in rows:
        entries += [x.numerator * pow(x.denominator, -1, PRIME) % PRIME for x in row]
    return int(nmod_mat(len(rows), len(rows[0]), entries, PRIME).rank())


def freedom(points: Sequence[Sequence[Fraction]]) -> tuple[int, int]:
    """Degrees of freedom of points with a rod between every two: to first order, and as a rigid
    body.

    To first order: the dimension of the velocities v with (r_a - r_b) . (v_a - v_b) = 0 for every
    rod. As a rigid body: the dimension of the velocities by translations e_i and by turns, v =
    x_j e_i - x_i e_j in the plane of the axes i and j.
    """
    dimension = len(points[0])
    count = len(points)
    # One row a rod, a column for every coordinate of every point.
    rods = []
    for a, b in combinations(range(count), 2):
        row = [Fraction(0)] * (dimension * count)
        for i in range(dimension):
            difference = points[a][i] - points[b][i]
            row[a * dimension + i] = difference
            row[b * dimension + i] = -difference
        rods.append(row)
    rigid = []
    for axis in range(dimension):
        direction = [Fraction(int(i == axis)) for i in range(dimension)]
        rigid.append(direction * count)
    for i, j in combinations(range(dimension), 2):
        row = []
        for point in points:
            velocity = [Fraction(0)] * dimension
            velocity[i] = point[j]
            velocity[j] = -point[i]
            row += velocity
        rigid.append(row)
    return dimension * count - rank(rods), rank(rigid)


def counted(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Every row of degrees-of-freedom: for points in general and in degenerate places."""
    flat = vector(p, "points")
    space = [flat[3 * i : 3 * i + 3] for i in range(5)]
    plane = [point[:2] for point in space]
    general = {"rods-6-on-4-in-2d": plane[:4], "rods-10-on-5-in-3d": space, "rod-twice": space[:2]}
    for n in range(1, 6):
        general[f"2d-{n}"] = plane[:n]
        general[f"3d-{n}"] = space[:n]
    counts = {name: freedom(points)[0] for name, points in general.items()}
    coplanar = [[x, y, Fraction(0)] for x, y, _ in space]
    factors = (Fraction(0), Fraction(1), Fraction(5, 2))
    collinear = [[x * factor for x in space[1]] for factor in factors]
    degenerate = {
        "coplanar-4": coplanar[:4],
        "coplanar-5": coplanar,
        "collinear-3": collinear,
        "2d-collinear-3": [point[:2] for point in collinear],
    }
    for name, points in degenerate.items():
        first_order, rigid = freedom(points)
        counts[f"{name}-first-order"] = first_order
        counts[f"{name}-rigid"] = rigid
    yield None, {name: arb(n) for name, n in counts.items()}


def brick(
    low: Point, high: Point, mapped: Callable[[Any, Any, Any], tuple[Point, Any]] | None = None
) -> Rule:
    """The rule of the cuboid between two corners, or of its image under a map.

    `mapped` returns the image of a point and the Jacobian's determinant, by which volumes grow.
    """
    sides = [h - x for x, h in zip(low, high, strict=True)]
    for x_rule, y_rule, z_rule in product(BOOLE, repeat=3):
        weight = x_rule[0] * y_rule[0] * z_rule[0] * sides[0] * sides[1] * sides[2]
        x = low[0] + sides[0] * x_rule[1]
        y = low[1] + sides[1] * y_rule[1]
        z = low[2] + sides[2] * z_rule[1]
        if mapped is None:
            yield weight, (x, y, z)
        else:
            point, determinant = mapped(x, y, z)
            yield weight * determinant, point


CIRCLE = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""Four points of the unit circle: their mean is exact to the third degree."""


def cylinder(a: Any, b: Any, c: Any) -> Rule:
    """The rule of the elliptical cylinder with half-axes a, b and height c, about the origin.

    x = a rho cos f, y = b rho sin f, z = c (h - 1/2) for rho and h in [0, 1]: dV = a b c rho drho
    dh df, the mean over f times 2 pi being pi/2 for each of the four points.
    """
    for (w_rho, rho), (w_h, h), (cosine, sine) in product(BOOLE, BOOLE, CIRCLE):
        weight = arb.pi() / 2 * arb_of(w_rho * rho * w_h * a * b * c)
        yield weight, (a * rho * cosine, b * rho * sine, c * (h - Fraction(1, 2)))


def ellipsoid(a: Any, b: Any, c: Any) -> Rule:
    """The rule of the ellipsoid with half-axes a, b, c about the origin, as shells of circles.

    x = a rho sqrt(1 - s^2) cos f, y = b rho sqrt(1 - s^2) sin f, z = c rho s for rho in [0, 1] and
    s in [-1, 1]: dV = a b c rho^2 drho ds df, with ds = 2 d(half) and pi/2 for each of four points.
    """
    for (w_rho, rho), (w_s, half), (cosine, sine) in product(BOOLE, BOOLE, CIRCLE):
        s = 2 * half - 1
        radius = arb_of(1 - s * s).sqrt() * arb_of(rho)
        point = (arb_of(a * cosine) * radius, arb_of(b * sine) * radius, arb_of(c * rho * s))
        yield arb.pi() * arb_of(w_rho * rho * rho * w_s * a * b * c), point


def without(whole: Rule, part: Rule) -> Rule:
    """The rule of the solid `whole` with the solid `part` removed: weights subtract."""
    yield from whole
    yield from ((-weight, point) for weight, point in part)


def angled(a: Fraction, b: Fraction, thick: Fraction) -> Rule:
    """The angle: a cuboid [0, a] [0, b] [0, thick] without the quarter x > a/2, y > b/2."""
    low = [Fraction(0)] * 3
    return without(brick(low, [a, b, thick]), brick([a / 2, b / 2, Fraction(0)], [a, b, thick]))


def boxed(x: Fraction, y: Fraction, z: Fraction) -> Rule:
    """A cuboid about the origin."""
    return brick([-x / 2, -y / 2, -z / 2], [x / 2, y / 2, z / 2])


def solids(p: Mapping[str, Exact]) -> dict[str, Rule]:
    """The rule of every solid of moments-of-inertia, by name.

    `hollow` f is the size of the cavity relative to the solid. A plate is a solid of thickness 1
    with all points projected to z = 0.
    """
    a, b, c, f = numbers(p, "a", "b", "c", "hollow").values()
    zero = Fraction(0)
    plate = ((weight, (x, y, zero)) for weight, (x, y, _) in angled(a, b, Fraction(1)))
    places = [(zero, zero, zero), (a, zero, zero), (a, b, zero), (a, b, c)]
    masses = ((Fraction(mass), place) for mass, place in enumerate(places, start=1))
    plain = {
        "cuboid": boxed(a, b, c),
        "ellipsoid": ellipsoid(a, b, c),
        "elliptical-cylinder": cylinder(a, b, c),
        "cuboid-at-corner": boxed(a, b, c),
        "angle": angled(a, b, c),
        "angle-plate": plate,
        "points": masses,
    }
    # The cavity has f times the lengths of the solid; that of the cylinder goes through.
    a_inside = a * f
    b_inside = b * f
    c_inside = c * f
    hollow = {
        "hollow-cuboid": without(boxed(a, b, c), boxed(a_inside, b_inside, c_inside)),
        "hollow-cylinder": without(cylinder(a, a, c), cylinder(a_inside, a_inside, c)),
        "hollow-sphere": without(ellipsoid(a, a, a), ellipsoid(a_inside, a_inside, a_inside)),
    }
    # The radius of the stick, and that inside the hoop.
    thin = number(p, "thin")
    radius = thin * c
    inside = a - thin * a
    limits = {
        "sphere": ellipsoid(a, a, a),
        "stick": cylinder(radius, radius, c),
        "stick-at-end": cylinder(radius, radius, c),
        "hoop": without(cylinder(a, a, c), cylinder(inside, inside, c)),
    }
    tetrahedron = images(a, b, c)["tetrahedron"]
    turns = {"turned-tetrahedron": turned(tetrahedron, vector(p, "attitude"))}
    return plain | hollow | limits | images(a, b, c) | turns


def images(a: Fraction, b: Fraction, c: Fraction) -> dict[str, Rule]:
    """The rules of solids that taper: images of cuboids of size 1.

    Each map returns a point and the determinant of its Jacobian.
    """
    half = Fraction(1, 2)
    zero = Fraction(0)
    one = Fraction(1)

    # The Jacobian of every map is triangular: its determinant is the product of its diagonal.
    def tetrahedron(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        determinant = a * b * c * (1 - y) * (1 - z) * (1 - z)
        return (a * x * (1 - y) * (1 - z), b * y * (1 - z), c * z), determinant

    def pyramid(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (a * x * (1 - z), b * y * (1 - z), c * z), a * b * c * (1 - z) ** 2

    def right_angle_wedge(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (a * x * (1 - z), b * y, c * z), a * b * c * (1 - z)

    def isosceles_wedge(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (b * x * (1 - z), a * y, c * z), a * b * c * (1 - z)

    def triangle(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (b * x * (1 - y) + a * y, c * y, zero), b * c * (1 - y)

    origin = [zero, zero, zero]
    opposite = [one, one, one]
    # The unit cube about the z axis.
    centred_low = [-half, -half, zero]
    centred_high = [half, half, one]
    return {
        "tetrahedron": brick(origin, opposite, tetrahedron),
        "rectangular-pyramid": brick(centred_low, centred_high, pyramid),
        "right-angle-wedge": brick([zero, -half, zero], [one, half, one], right_angle_wedge),
        "isosceles-wedge": brick(centred_low, centred_high, isosceles_wedge),
        "triangle": brick(origin, opposite, triangle),
    }


def turned(rule: Rule, q: Sequence[Fraction]) -> Rule:
    """The rule with every point r turned: q r q*/|q|^2."""
    back = (q[0], *(-x for x in q[1:]))
    norm_square = sum(x * x for x in q)
    for weight, point in rule:
        image = hamilton(hamilton(q, (Fraction(0), *point)), back)[1:]
        yield weight, [x / norm_square for x in image]


def weighed(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Mass, centre of mass and inertia tensor of every solid, as sums over the points of its rule.

    The tensor is about the centre of mass; that of cuboid-at-corner about its corner, that of
    stick-at-end about its end.
    """
    corner = [arb_of(x / 2) for x in numbers(p, "a", "b", "c").values()]
    points_of_reference = {"cuboid-at-corner": corner, "stick-at-end": [arb(0), arb(0), corner[2]]}
    quantities: dict[str, arb] = {}
    for name, rule in solids(p).items():
        # The rule of the point masses has their masses as weights.
        if name == "points":
            density = arb(1)
        else:
            density = arb_of(number(p, "density"))
        points = [(density * arb_of(weight), [arb_of(x) for x in point]) for weight, point in rule]
        mass = sum((m for m, _ in points), arb(0))
        centre = [sum((m * r[i] for m, r in points), arb(0)) / mass for i in range(3)]
        origin = points_of_reference.get(name, centre)
        arms = [(m, [x - y for x, y in zip(r, origin, strict=True)]) for m, r in points]
        quantities[f"{name}.mass"] = mass
        for axis, x in zip("xyz", centre, strict=True):
            quantities[f"{name}.centre.{axis}"] = x
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
            quantities[f"{name}.inertia.{'xyz'[i]}{'xyz'[j]}"] = _inertia(arms, i, j)
    yield None, quantities


def _inertia(arms: Sequence[tuple[arb, Sequence[arb]]], i: int, j: int) -> arb:
    """The entry J_ij = sum m (r^2 delta_ij - r_i r_j) of points (m, r)."""
    entry = arb(0)
    for m, r in arms:
        square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
        entry += m * (square * int(i == j) - r[i] * r[j])
    return entry


def matrix_of(q: Point) -> list[list[Any]]:
    """The rotation matrix 1 + 2 w [v] + 2 [v]^2 of a unit quaternion, [v] r = v x r."""
    w = q[0]
    (x, y, z) = q[1:]
    skew = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    square = [[sum(skew[i][k] * skew[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[int(i == j) + 2 * (w * skew[i][j] + square[i][j]) for j in range(3)] for i in range(3)]


def euler_of(r: Sequence[Sequence[arb]]) -> list[arb]:
    """Euler's angles phi, theta, psi (z-x-z) of a matrix from body to space.

    Its last column is (sin phi sin theta, -cos phi sin theta, cos theta), its last row (sin theta
    sin psi, sin theta cos psi, cos theta).
    """
    # phi = atan2(R_xz, -R_yz), theta = acos(R_zz), psi = atan2(R_zx, R_zy)
    return [arb.atan2(r[0][2], -r[1][2]), r[2][2].acos(), arb.atan2(r[2][0], r[2][1])]


def listed(rows: Mapping[str, Sequence[Any]]) -> dict[str, arb]:
    """Rows as quantities: `name` for a row of one number, else `name.0`, `name.1` and so on."""
    quantities = {}
    for name, row in rows.items():
        if len(row) == 1:
            quantities[name] = arb_of(row[0])
        else:
            for i, x in enumerate(row):
                quantities[f"{name}.{i}"] = arb_of(x)
    return quantities


def conjugate(q: Point) -> list[Any]:
    """The conjugate (w, -x, -y, -z) of a quaternion."""
    return [q[0], -q[1], -q[2], -q[3]]


def applied(rows: Sequence[Sequence[Any]], v: Sequence[Fraction]) -> list[arb]:
    """A matrix times an exact vector."""
    return [sum((m * arb_of(x) for m, x in zip(row, v, strict=True)), arb(0)) for row in rows]


def added(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The sum a + b, entry by entry."""
    return [x + y for x, y in zip(a, b, strict=True)]


def quaternions(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Every row of the case quaternions, by Hamilton's products and matrices 1 + 2 w [v] + 2 [v]^2.

    Products are exact rationals as long as nothing is divided by |q|; u = q/|q|.
    """
    q = vector(p, "q")
    length = arb_of(sum((x * x for x in q), Fraction(0))).sqrt()
    u = [arb_of(x) / length for x in q]
    yield None, listed(products(p, length) | turns_by(p, u) | rates_of(p, u) | rules(p, u))


def products(p: Mapping[str, Exact], length: arb) -> dict[str, Sequence[Any]]:
    """The rows of products, sums, conjugates and the inverse of p, q, r; `length` is |q|."""
    a, b, c = (vector(p, name) for name in ("p", "q", "r"))
    pq = hamilton(a, b)
    qp = hamilton(b, a)
    both = added(a, b)
    # q^-1 = q*/|q|^2
    inverse = [x / sum(y * y for y in b) for x in conjugate(b)]
    # The eigenvalues of the complex matrix of q are w +- i |(x, y, z)|.
    imaginary = (length * length - arb_of(b[0] * b[0])).sqrt()
    of_product: dict[str, Sequence[Any]] = {
        "p-q": pq,
        "q-p": qp,
        "commutator": [x - y for x, y in zip(pq, qp, strict=True)],
        "q-r": hamilton(b, c),
        "left": hamilton(pq, c),
        "right": hamilton(a, hamilton(b, c)),
        "conjugate-of-product": conjugate(pq),
        "real-product": pq,
        "complex-product": pq,
    }
    # The eigenvalues of x s1 + y s2 + z s3, s_i being Pauli's matrices, are +-|(x, y, z)|; those of
    # the matrices of i, j, k are +-i.
    v = vector(p, "vector")
    size = arb_of(sum((x * x for x in v), Fraction(0))).sqrt()
    of_pauli: dict[str, Sequence[Any]] = {
        **{f"pauli-{axis}": [Fraction(1), Fraction(-1)] for axis in "xyz"},
        **{f"element-{axis}": [Fraction(0), Fraction(1)] for axis in "ijk"},
        "pauli-vector": [size, -size],
    }
    return (
        of_product
        | of_pauli
        | {
            "sum": both,
            "conjugate-of-sum": conjugate(both),
            "inverse": inverse,
            "one": hamilton(b, inverse),
            "absolute": [length],
            "complex-eigenvalue": [b[0], imaginary],
        }
    )


def turns_by(p: Mapping[str, Exact], u: Sequence[arb]) -> dict[str, Sequence[Any]]:
    """The rows of the unit quaternion u: its matrix, Euler's angles, and a vector that it turns."""
    v = vector(p, "vector")
    matrix = matrix_of(u)
    entries = [x for row in matrix for x in row]
    twice = hamilton(u, u)
    first = vector(p, "p")
    first_length = arb_of(sum((x * x for x in first), Fraction(0))).sqrt()
    u1 = [arb_of(x) / first_length for x in first]
    u2_u1 = hamilton(u, u1)
    u1_u2 = hamilton(u1, u)
    rotated = applied(matrix, v)
    in_turn = applied(matrix_of(u2_u1), v)
    in_other_order = applied(matrix_of(u1_u2), v)
    minus_u = [-x for x in u]
    # The quaternion that is computed from a matrix has w >= 0.
    if u[0] > 0:
        back = u
    else:
        back = minus_u
    return {
        "u": u,
        "-u": minus_u,
        "u-conjugate": conjugate(u),
        "back": back,
        "rotated": rotated,
        "rotated-by-minus-u": rotated,
        "matrix": entries,
        "euler": euler_of(matrix),
        "turned-twice": twice,
        "rotated-twice": applied(matrix_of(twice), v),
        "u1": u1,
        "u2-u1": u2_u1,
        "u1-u2": u1_u2,
        "rotated-by-u1": applied(matrix_of(u1), v),
        "rotated-in-turn": in_turn,
        "rotated-at-once": in_turn,
        "rotated-in-other-order": in_other_order,
    }


def rates_of(p: Mapping[str, Exact], u: Sequence[arb]) -> dict[str, Sequence[Any]]:
    """The rows of u' = omega u/2 and of its consequences; omega and omega' (`rise`) in space."""
    omega = vector(p, "omega")
    omega_quaternion = [arb(0), *map(arb_of, omega)]
    omega_rate = [arb(0), *map(arb_of, vector(p, "rise"))]
    rate = [x / 2 for x in hamilton(omega_quaternion, u)]
    # u'' = (omega' u + omega u')/2
    second = [x / 2 for x in added(hamilton(omega_rate, u), hamilton(omega_quaternion, rate))]
    # omega_body = R^T omega
    matrix = matrix_of(u)
    body = [sum((matrix[k][i] * arb_of(omega[k]) for k in range(3)), arb(0)) for i in range(3)]
    u_rate = hamilton(u, conjugate(rate))
    rate_u = hamilton(rate, conjugate(u))
    return {
        "rate": rate,
        "second-rate": second,
        "orthogonal": [sum((x * y for x, y in zip(u, rate, strict=True)), arb(0))],
        "rate-conjugate": conjugate(rate),
        "u-rate": u_rate,
        "rate-u": rate_u,
        "anticommute": added(u_rate, rate_u),
        # omega = 2 u' u*
        "omega-back": [2 * x for x in rate_u][1:],
        "omega-body": body,
    }


PRODUCTS = (
    ("z-then-x", "x+90", "z+90"),
    ("x-then-z", "z+90", "x+90"),
    ("globe", "x-90", "y-90"),
    ("two-halves", "x+180", "y+180"),
    ("x-y", "x+90", "y+90"),
    ("x-y-back", "x-y", "x-90"),
)
"""Products of turns: name, first and second factor."""


def rotations(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Every row of the case rotations, by products of turns about coordinate axes."""
    frequency = arb_of(number(p, "frequency"))
    # Energy per moment of inertia: omega^2/2 with omega = 2 pi f, and f^2/2 for comparison.
    energy = (2 * arb.pi() * frequency) ** 2 / 2
    of_frequency = frequency * frequency / 2
    energies: dict[str, Sequence[Any]] = {
        "energy": [energy],
        "frequency-energy": [of_frequency],
        "energy-ratio": [energy / of_frequency],
    }
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    matrix = about("z", phi) * about("x", theta) * about("z", psi)
    stepped = of_a_step(p, matrix, attitude(phi, theta, psi))
    stepped["nine-entries-freedom"] = [freedom_of_nine_entries()]
    angles = in_the_plane(p) | of_multiples(p) | by_euler(p) | rate_matrices(p) | swept(p)
    angles |= euler_by_turns(p)
    energies_of_all = energies | of_points(p) | of_body(p) | of_triangle(p)
    yield None, listed(quarter_turns() | commuting(p) | angles | stepped | energies_of_all)


def quarter_turns() -> dict[str, Sequence[Any]]:
    """Turns by 90 and 180 degrees, and products of them."""
    turns = {}
    for axis in "xyz":
        for degrees in (90, -90, 180):
            turns[f"{axis}{degrees:+d}"] = about(axis, arb.pi() * degrees / 180)
    for name, first, second in PRODUCTS:
        turns[name] = turns[first] * turns[second]
    rows: dict[str, Sequence[Any]] = {name: row_by_row(m) for name, m in turns.items()}
    globe = turns["globe"]
    trace = globe[0, 0] + globe[1, 1] + globe[2, 2]
    return rows | {
        "globe-x": [globe[i, 0] for i in range(3)],
        "globe-determinant": [globe.det()],
        # The trace is 1 + 2 cos(angle).
        "globe-angle": [((trace - 1) / 2).acos()],
    }


def in_the_plane(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """A turn of the plane, and the mirror at the line along e = (cos angle, sin angle).

    e is the first column of the matrix of the turn; the mirror image of v is 2 (v . e) e - v.
    """
    v = [arb_of(x) for x in vector(p, "vector")]
    turn = about("z", arb_of(number(p, "angle")))
    # R v, the mirror image 2 (v . e) e - v, and, in `plane-clockwise`, R^T v.
    turned_v = [turn[i, 0] * v[0] + turn[i, 1] * v[1] for i in (0, 1)]
    along_line = turn[0, 0] * v[0] + turn[1, 0] * v[1]
    mirrored_v = [2 * along_line * turn[i, 0] - v[i] for i in (0, 1)]
    # The eigenvalues are cos +- i |sin| of the angle.
    absolute_sine = (turn[0, 1] * turn[0, 1]).sqrt()
    return {
        "plane-turn": turned_v,
        "complex-turn": turned_v,
        "plane-clockwise": [turn[0, i] * v[0] + turn[1, i] * v[1] for i in (0, 1)],
        "plane-turned-back": v,
        "plane-determinant": [turn.det()],
        "mirror-determinant": [-turn.det()],
        "plane-eigenvalue": [turn[0, 0], absolute_sine],
        "mirror": mirrored_v,
    }


def freedom_of_nine_entries() -> int:
    """The number of rates X of the entries of the matrix 1 that keep it orthogonal: X + X^T = 0.

    Those of any other rotation R are X R.
    """
    conditions = []
    for i, j in combinations(range(4), 2):
        # The pairs i < j of 0 .. 3 stand for the pairs i <= j - 1 of axes.
        row = [Fraction(0)] * 9
        row[3 * i + j - 1] += 1
        row[3 * (j - 1) + i] += 1
        conditions.append(row)
    return 9 - rank(conditions)


def by_euler(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """Euler's angles z-x-z with their matrix, quaternion and rates.

    The rows `near-...` have the small angle `near` in the place of theta, next to the singularity.
    """
    near = arb_of(number(p, "near"))
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    omega = [arb_of(x) for x in vector(p, "omega")]
    matrix = about("z", phi) * about("x", theta) * about("z", psi)
    near_quaternion = attitude(phi, near, psi)
    omega_q = hamilton([arb(0), *omega], near_quaternion)
    return {
        "euler-matrix": row_by_row(matrix),
        "euler-back": euler_of(matrix.table()),
        "euler-quaternion": attitude(phi, theta, psi),
        "euler-rates": turning(phi, theta, omega),
        "near-rates": turning(phi, near, omega),
        "near-quaternion": near_quaternion,
        # q' = omega q/2
        "near-quaternion-rate": [x / 2 for x in omega_q],
    }


def attitude(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The quaternion of the turns by psi about z, theta about x and phi about z, in this order."""
    sin_phi, cos_phi = (phi / 2).sin_cos()
    sin_theta, cos_theta = (theta / 2).sin_cos()
    sin_psi, cos_psi = (psi / 2).sin_cos()
    zero = arb(0)
    about_z = [cos_phi, zero, zero, sin_phi]
    about_x = [cos_theta, sin_theta, zero, zero]
    about_body_z = [cos_psi, zero, zero, sin_psi]
    return hamilton(hamilton(about_z, about_x), about_body_z)


def turning(phi: arb, theta: arb, omega: Sequence[arb]) -> list[arb]:
    """The rates phi', theta', psi' from omega in space axes, by linear equations.

    omega = phi' e_z + theta' n + psi' b, with the line of nodes n = (cos phi, sin phi, 0) and the
    axis of the body b = (sin phi sin theta, -cos phi sin theta, cos theta).
    """
    sin_phi, cos_phi = phi.sin_cos()
    sin_theta, cos_theta = theta.sin_cos()
    # Columns: e_z, n and b.
    axes = arb_mat(
        [[0, cos_phi, sin_phi * sin_theta], [0, sin_phi, -cos_phi * sin_theta], [1, 0, cos_theta]]
    )
    solved = axes.solve(arb_mat([[x] for x in omega]))
    return [row[0] for row in solved.table()]


WITNESSES = {
    "degrees-of-freedom": Witness(
        f"ranks modulo 2^61 - 1 of rods, and of translations and turns {PLACE}", counted
    ),
    "moments-of-inertia": Witness(
        f"cubature of every solid as the image of a cube or of discs {PLACE}", weighed
    ),
    "quaternions": Witness(
        f"Hamilton's products; matrices by 1 + 2 w [v] + 2 [v]^2 {PLACE}", quaternions
    ),
    "rotations": Witness(f"products of turns about coordinate axes {PLACE}", rotations),
}
