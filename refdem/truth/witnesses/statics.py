"""Witnesses of what has no time: counts by ranks modulo a prime, solids by cubature, rotations by
products of turns.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import Any

from flint import arb, arb_mat, nmod_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

PRIME = 2**61 - 1
PLACE = "(refdem/truth/witnesses/statics.py)"
BOOLE = [(Fraction(weight, 90), Fraction(k, 4)) for k, weight in enumerate((7, 32, 12, 32, 7))]
"""Weights and places of a rule on [0, 1] that is exact to the fifth degree."""
Point = Sequence[Any]
Rule = Iterator[tuple[Any, Point]]
"""Weights (volumes) and points whose sums are the integrals of polynomials of second degree over a
solid.
"""


def rank(rows: Sequence[Sequence[Fraction]]) -> int:
    """Modulo a prime far larger than any number here."""
    table = [[x.numerator * pow(x.denominator, -1, PRIME) % PRIME for x in row] for row in rows]
    if table:
        return int(
            nmod_mat(len(table), len(table[0]), [x for row in table for x in row], PRIME).rank()
        )
    return 0


def freedom(points: Sequence[Sequence[Fraction]]) -> tuple[int, int]:
    """Velocities that keep all distances to first order; and those of the body as a whole: rank of
    translations and turns.
    """
    size = len(points[0])
    count = len(points)
    rods = []
    whole = []
    for a, b in combinations(range(count), 2):
        rods.append(
            [
                (points[a][i] - points[b][i]) * ((n == a) - (n == b))
                for n in range(count)
                for i in range(size)
            ]
        )
    for axis in range(size):
        whole.append([Fraction(int(i == axis)) for _ in range(count) for i in range(size)])
    for i, j in combinations(range(size), 2):
        whole.append(
            [point[j] * (k == i) - point[i] * (k == j) for point in points for k in range(size)]
        )
    return size * count - rank(rods), rank(whole)


def counted(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Every row of degrees-of-freedom."""
    flat = vector(p, "points")
    space = [flat[3 * i : 3 * i + 3] for i in range(5)]
    plane = [point[:2] for point in space]
    placed = {
        f"{d}d-{n}": points[:n] for d, points in ((2, plane), (3, space)) for n in range(1, 6)
    }
    placed |= {"rods-6-on-4-in-2d": plane[:4], "rods-10-on-5-in-3d": space, "rod-twice": space[:2]}
    found = {name: freedom(points)[0] for name, points in placed.items()}
    on_table = [[x, y, Fraction(0)] for x, y, _ in space]
    in_line = [
        [x * along for x in space[1]] for along in (Fraction(0), Fraction(1), Fraction(5, 2))
    ]
    special = {
        "coplanar-4": on_table[:4],
        "coplanar-5": on_table,
        "collinear-3": in_line,
        "2d-collinear-3": [x[:2] for x in in_line],
    }
    for name, points in special.items():
        found[f"{name}-first-order"], found[f"{name}-rigid"] = freedom(points)
    yield None, {name: arb(n) for name, n in found.items()}


def brick(
    low: Point, high: Point, corner: Callable[[Any, Any, Any], tuple[Point, Any]] | None = None
) -> Rule:
    """A cuboid; or its image under a map with the factor by which volumes grow."""
    sides = [h - x for x, h in zip(low, high, strict=True)]
    for rule in product(BOOLE, repeat=3):
        weight = rule[0][0] * rule[1][0] * rule[2][0] * sides[0] * sides[1] * sides[2]
        x, y, z = (low[i] + sides[i] * rule[i][1] for i in range(3))
        place, grown = corner(x, y, z) if corner else ((x, y, z), 1)
        yield weight * grown, place


def cylinder(a: Any, b: Any, c: Any) -> Rule:
    """Half-axes a, b: the mean over four points of a circle is exact to the third degree."""
    for (w, rho), (u, up), (x, y) in product(BOOLE, BOOLE, ((1, 0), (0, 1), (-1, 0), (0, -1))):
        yield (
            arb.pi() / 2 * arb_of(w * rho * u * a * b * c),
            (
                a * rho * x,
                b * rho * y,
                c * (up - Fraction(1, 2)),
            ),
        )


def ellipsoid(a: Any, b: Any, c: Any) -> Rule:
    """Shells of discs: x = a rho sqrt(1 - s^2) cos f, z = c rho s."""
    for (w, rho), (u, half), (x, y) in product(BOOLE, BOOLE, ((1, 0), (0, 1), (-1, 0), (0, -1))):
        s = 2 * half - 1
        wide = arb_of(1 - s * s).sqrt() * arb_of(rho)
        place = (arb_of(a * x) * wide, arb_of(b * y) * wide, arb_of(c * rho * s))
        yield arb.pi() * arb_of(w * rho * rho * u * a * b * c), place


def without(whole: Rule, part: Rule) -> Rule:
    """The solid `whole` with the solid `part` removed."""
    yield from whole
    yield from ((-weight, place) for weight, place in part)


def angled(a: Fraction, b: Fraction, thick: Fraction) -> Rule:
    """A cuboid from the origin without the quarter beyond the middle."""
    low = [Fraction(0)] * 3
    return without(brick(low, [a, b, thick]), brick([a / 2, b / 2, Fraction(0)], [a, b, thick]))


def boxed(x: Fraction, y: Fraction, z: Fraction) -> Rule:
    """A cuboid about the origin."""
    return brick([-x / 2, -y / 2, -z / 2], [x / 2, y / 2, z / 2])


def solids(p: Mapping[str, Exact]) -> dict[str, Rule]:
    """Every solid of moments-of-inertia, from what it is: half spaces and maps of a cube."""
    a, b, c, f = numbers(p, "a", "b", "c", "hollow").values()
    flat = ((weight, (x, y, Fraction(0))) for weight, (x, y, _) in angled(a, b, Fraction(1)))
    # m kg at 0, (a, 0, 0), (a, b, 0) and (a, b, c).
    masses = ((Fraction(m), (a * (m > 1), b * (m > 2), c * (m > 3))) for m in (1, 2, 3, 4))
    plain = {
        "cuboid": boxed(a, b, c),
        "ellipsoid": ellipsoid(a, b, c),
        "elliptical-cylinder": cylinder(a, b, c),
        "cuboid-at-corner": boxed(a, b, c),
        "angle": angled(a, b, c),
        "angle-plate": flat,
        "points": masses,
    }
    hollow = {
        "hollow-cuboid": without(boxed(a, b, c), boxed(a * f, b * f, c * f)),
        "hollow-cylinder": without(cylinder(a, a, c), cylinder(a * f, a * f, c)),
    }
    tetrahedron = images(a, b, c)["tetrahedron"]
    turns = {"turned-tetrahedron": turned(tetrahedron, vector(p, "attitude"))}
    return plain | hollow | images(a, b, c) | turns


def images(a: Fraction, b: Fraction, c: Fraction) -> dict[str, Rule]:
    """Solids that taper: images of cuboids, with the factor by which volumes grow."""
    half = Fraction(1, 2)
    nothing = Fraction(0)
    one = Fraction(1)

    def tetrahedron(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        grown = a * b * c * (1 - y) * (1 - z) * (1 - z)
        return (a * x * (1 - y) * (1 - z), b * y * (1 - z), c * z), grown

    def pyramid(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (a * x * (1 - z), b * y * (1 - z), c * z), a * b * c * (1 - z) ** 2

    def right_angle_wedge(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (a * x * (1 - z), b * y, c * z), a * b * c * (1 - z)

    def isosceles_wedge(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (b * x * (1 - z), a * y, c * z), a * b * c * (1 - z)

    def triangle(x: Any, y: Any, z: Any) -> tuple[Point, Any]:
        return (b * x * (1 - y) + a * y, c * y, nothing), b * c * (1 - y)

    cube = [nothing, nothing, nothing]
    ones = [one, one, one]
    halves = [half, half, one]
    lows = [-half, -half, nothing]
    return {
        "tetrahedron": brick(cube, ones, tetrahedron),
        "rectangular-pyramid": brick(lows, halves, pyramid),
        "right-angle-wedge": brick([nothing, -half, nothing], [one, half, one], right_angle_wedge),
        "isosceles-wedge": brick(lows, halves, isosceles_wedge),
        "triangle": brick(cube, ones, triangle),
    }


def turned(rule: Rule, q: Sequence[Fraction]) -> Rule:
    """Every point r by q r q*, after division by |q|^2."""
    back = (q[0], *(-x for x in q[1:]))
    size = sum(x * x for x in q)
    for weight, place in rule:
        yield weight, [x / size for x in hamilton(hamilton(q, (Fraction(0), *place)), back)[1:]]


def weighed(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Mass, centre and tensor of every solid, as sums over its points."""
    corner = [x / 2 for x in numbers(p, "a", "b", "c").values()]
    found: dict[str, arb] = {}
    for name, rule in solids(p).items():
        density = arb_of(1 if name == "points" else number(p, "density"))
        points = [(density * arb_of(weight), [arb_of(x) for x in place]) for weight, place in rule]
        mass = sum((w for w, _ in points), arb(0))
        centre = [sum((w * r[i] for w, r in points), arb(0)) / mass for i in range(3)]
        if name == "cuboid-at-corner":
            about = [arb_of(x) for x in corner]
        else:
            about = centre
        arms = [(w, [x - y for x, y in zip(r, about, strict=True)]) for w, r in points]
        found |= {f"{name}.mass": mass} | {
            f"{name}.centre.{axis}": x for axis, x in zip("xyz", centre, strict=True)
        }
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
            own = sum(
                (
                    w * ((r[0] * r[0] + r[1] * r[1] + r[2] * r[2]) * int(i == j) - r[i] * r[j])
                    for w, r in arms
                ),
                arb(0),
            )
            found[f"{name}.inertia.{'xyz'[i]}{'xyz'[j]}"] = own
    yield None, found


def hamilton(a: Point, b: Point) -> list[Any]:
    """Hamilton's product of two quaternions."""
    w, x, y, z = a
    s, t, u, v = b
    return [
        w * s - x * t - y * u - z * v,
        w * t + x * s + y * v - z * u,
        w * u - x * v + y * s + z * t,
        w * v + x * u - y * t + z * s,
    ]


def matrix_of(q: Point) -> list[list[Any]]:
    """The rotation matrix 1 + 2 w [v] + 2 [v]^2 of a quaternion."""
    w = q[0]
    (x, y, z) = q[1:]
    skew = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    square = [[sum(skew[i][k] * skew[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[int(i == j) + 2 * (w * skew[i][j] + square[i][j]) for j in range(3)] for i in range(3)]


def euler_of(r: Sequence[Sequence[arb]]) -> list[arb]:
    """z-x-z angles of a matrix from body to space."""
    return [arb.atan2(r[0][2], -r[1][2]), r[2][2].acos(), arb.atan2(r[2][0], r[2][1])]


def listed(found: Mapping[str, Sequence[Any]]) -> dict[str, arb]:
    """`name`, or `name.0`, `name.1` ... where there are several numbers."""
    return {
        (name if len(row) == 1 else f"{name}.{i}"): arb_of(x)
        for name, row in found.items()
        for i, x in enumerate(row)
    }


def conjugate(q: Point) -> list[Any]:
    """The conjugate (w, -x, -y, -z) of a quaternion."""
    return [q[0], -q[1], -q[2], -q[3]]


def applied(rows: Sequence[Sequence[Any]], v: Sequence[Fraction]) -> list[arb]:
    """A matrix times an exact vector."""
    return [sum((m * arb_of(x) for m, x in zip(row, v, strict=True)), arb(0)) for row in rows]


def added(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The sum a + b, entry by entry."""
    return [x + y for x, y in zip(a, b, strict=True)]


def quaternions(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Hamilton's products, exact as long as nothing is made unit; the matrix from w and the skew
    matrix of the vector.
    """
    b = vector(p, "q")
    size = arb_of(sum((x * x for x in b), Fraction(0))).sqrt()
    u = [arb_of(x) / size for x in b]
    yield None, listed(products(p, size) | turns_by(p, u) | rates_of(p, u))


def products(p: Mapping[str, Exact], size: arb) -> dict[str, Sequence[Any]]:
    """What the exact quaternions p, q and r give; `size` is |q|."""
    a, b, c = (vector(p, name) for name in ("p", "q", "r"))
    pq = hamilton(a, b)
    qp = hamilton(b, a)
    both = added(a, b)
    # q* / |q|^2
    inverse = [x / sum(y * y for y in b) for x in conjugate(b)]
    across = (size * size - arb_of(b[0] * b[0])).sqrt()
    return {
        "p-q": pq,
        "q-p": qp,
        "commutator": [x - y for x, y in zip(pq, qp, strict=True)],
        "q-r": hamilton(b, c),
        "left": hamilton(pq, c),
        "right": hamilton(a, hamilton(b, c)),
        "conjugate-of-product": conjugate(pq),
        "sum": both,
        "conjugate-of-sum": conjugate(both),
        "inverse": inverse,
        "one": hamilton(b, inverse),
        "absolute": [size],
        "real-product": pq,
        "complex-product": pq,
        "complex-eigenvalue": [b[0], across],
    }


def turns_by(p: Mapping[str, Exact], u: Sequence[arb]) -> dict[str, Sequence[Any]]:
    """What a vector is turned to by the unit quaternion u."""
    v = vector(p, "vector")
    matrix = matrix_of(u)
    twice = hamilton(u, u)
    moved = applied(matrix, v)
    return {
        "u": u,
        "-u": [-x for x in u],
        "u-conjugate": conjugate(u),
        "back": [x if u[0] > 0 else -x for x in u],
        "rotated": moved,
        "rotated-by-minus-u": moved,
        "matrix": [x for row in matrix for x in row],
        "euler": euler_of(matrix),
        "turned-twice": twice,
        "rotated-twice": applied(matrix_of(twice), v),
    }


def rates_of(p: Mapping[str, Exact], u: Sequence[arb]) -> dict[str, Sequence[Any]]:
    """u' = omega u/2 and what follows from it."""
    omega = vector(p, "omega")
    turning = [arb(0), *map(arb_of, omega)]
    rising = [arb(0), *map(arb_of, vector(p, "rise"))]
    rate = [x / 2 for x in hamilton(turning, u)]
    # u'' = (omega' u + omega u')/2
    second = [x / 2 for x in added(hamilton(rising, u), hamilton(turning, rate))]
    matrix = matrix_of(u)
    body = [sum((matrix[k][i] * arb_of(omega[k]) for k in range(3)), arb(0)) for i in range(3)]
    ahead = hamilton(u, conjugate(rate))
    behind = hamilton(rate, conjugate(u))
    return {
        "rate": rate,
        "second-rate": second,
        "orthogonal": [sum((x * y for x, y in zip(u, rate, strict=True)), arb(0))],
        "rate-conjugate": conjugate(rate),
        "u-rate": ahead,
        "rate-u": behind,
        "anticommute": added(ahead, behind),
        # omega = 2 u' u*
        "omega-back": [2 * x for x in behind][1:],
        "omega-body": body,
    }


def about(axis: str, angle: arb) -> arb_mat:
    """Rodrigues' formula for a coordinate axis."""
    i = "xyz".index(axis)
    j = (i + 1) % 3
    k = (i + 2) % 3
    sine, cosine = angle.sin_cos()
    entries = {(i, i): arb(1), (j, j): cosine, (k, k): cosine, (j, k): -sine, (k, j): sine}
    return arb_mat([[entries.get((m, n), arb(0)) for n in range(3)] for m in range(3)])


PRODUCTS = (
    ("z-then-x", "x+90", "z+90"),
    ("x-then-z", "z+90", "x+90"),
    ("globe", "x-90", "y-90"),
    ("two-halves", "x+180", "y+180"),
    ("x-y", "x+90", "y+90"),
    ("x-y-back", "x-y", "x-90"),
)
"""Products of turns: name, first and second factor."""


def rotations(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Products of turns about coordinate axes; rates from the axes about which Euler's angles
    turn.
    """
    frequency = arb_of(number(p, "frequency"))
    # Energy per moment of inertia, omega^2/2 with omega = 2 pi f.
    spin = (2 * arb.pi() * frequency) ** 2 / 2
    slow = frequency * frequency / 2
    energies = {"energy": [spin], "frequency-energy": [slow], "energy-ratio": [spin / slow]}
    yield None, listed(quarter_turns() | in_the_plane(p) | by_euler(p) | energies)


def quarter_turns() -> dict[str, Sequence[Any]]:
    """Turns by 90 and 180 degrees, and products of them."""
    turn = {
        f"{axis}{degrees:+d}": about(axis, arb.pi() * degrees / 180)
        for axis in "xyz"
        for degrees in (90, -90, 180)
    }
    for name, first, second in PRODUCTS:
        turn[name] = turn[first] * turn[second]
    found: dict[str, Sequence[Any]] = {name: row_by_row(m) for name, m in turn.items()}
    globe = turn["globe"]
    trace = globe[0, 0] + globe[1, 1] + globe[2, 2]
    return found | {
        "globe-x": [globe[i, 0] for i in range(3)],
        "globe-determinant": [globe.det()],
        # The trace is 1 + 2 cos(angle).
        "globe-angle": [((trace - 1) / 2).acos()],
    }


def row_by_row(m: arb_mat) -> list[arb]:
    """The entries of a matrix."""
    return [x for row in m.table() for x in row]


def in_the_plane(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """A turn of the plane, and the mirror at the line that the x axis is turned to."""
    v = [arb_of(x) for x in vector(p, "vector")]
    plane = about("z", arb_of(number(p, "angle")))
    flat = [plane[i, 0] * v[0] + plane[i, 1] * v[1] for i in (0, 1)]
    along = plane[0, 0] * v[0] + plane[1, 0] * v[1]
    return {
        "plane-turn": flat,
        "complex-turn": flat,
        "plane-determinant": [plane.det()],
        "mirror-determinant": [-plane.det()],
        "plane-eigenvalue": [plane[0, 0], (plane[0, 1] * plane[0, 1]).sqrt()],
        # 2 (v.e) e - v
        "mirror": [2 * along * plane[i, 0] - v[i] for i in (0, 1)],
    }


def by_euler(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """Euler's angles z-x-z, with their rates, also next to their singularity."""
    near = arb_of(number(p, "near"))
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    omega = [arb_of(x) for x in vector(p, "omega")]
    whole = about("z", phi) * about("x", theta) * about("z", psi)
    tilted = attitude(phi, near, psi)
    return {
        "euler-matrix": row_by_row(whole),
        "euler-back": euler_of(whole.table()),
        "euler-quaternion": attitude(phi, theta, psi),
        "euler-rates": turning(phi, theta, omega),
        "near-rates": turning(phi, near, omega),
        "near-quaternion": tilted,
        "near-quaternion-rate": [x / 2 for x in hamilton([arb(0), *omega], tilted)],
    }


def attitude(phi: arb, theta: arb, psi: arb) -> list[arb]:
    """The quaternion of three turns."""
    (a, b), (c, d), (e, f) = ((half / 2).sin_cos() for half in (phi, theta, psi))
    return hamilton(
        hamilton([b, arb(0), arb(0), a], [d, c, arb(0), arb(0)]), [f, arb(0), arb(0), e]
    )


def turning(phi: arb, theta: arb, omega: Sequence[arb]) -> list[arb]:
    """phi', theta', psi': omega = phi' e_z + theta' (line of nodes) + psi' (axis of the body),
    solved as linear equations.
    """
    sine, cosine = phi.sin_cos()
    down, up = theta.sin_cos()
    axes = arb_mat([[0, cosine, sine * down], [0, sine, -cosine * down], [1, 0, up]])
    return [row[0] for row in axes.solve(arb_mat([[x] for x in omega])).table()]


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
