"""Mass properties of solids by integrals done by hand (Table 1.1, (1.14), (1.28), (1.30), (1.31)):
exact rationals, times pi if round.

A solid is its volume (the area of a plate), the mean of r over it, and the mean of (r - centre)(r -
centre)^T.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.exact import numbers, vector
from refdem.truth.timeless import Timeless

F = Fraction
ZERO = F(0)
Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Means:
    """`volume` counts in units of pi if `is_round`; the tensor is about `about`, the centre if
    there is none.
    """

    volume: Fraction
    centre: Vector
    second: Matrix
    is_round: bool = False
    about: Vector | None = None

    def tensor(self) -> Matrix:
        """Inertia over mass: trace(M) 1 - M, with M the second moments there."""
        arm = [c - p for c, p in zip(self.centre, self.about or self.centre, strict=True)]
        moments = [[self.second[i][j] + arm[i] * arm[j] for j in range(3)] for i in range(3)]
        trace = sum((moments[i][i] for i in range(3)), F(0))
        return matrix(lambda i, j: (trace if i == j else 0) - moments[i][j])


def matrix(entry: Callable[[int, int], Fraction]) -> Matrix:
    """The symmetric matrix that has these entries."""
    rows = [(entry(i, 0), entry(i, 1), entry(i, 2)) for i in range(3)]
    return rows[0], rows[1], rows[2]


def diagonal(
    xx: Fraction,
    yy: Fraction,
    zz: Fraction = ZERO,
    *,
    xy: Fraction = ZERO,
    xz: Fraction = ZERO,
    yz: Fraction = ZERO,
) -> Matrix:
    """The symmetric matrix with these entries."""
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def cuboid(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """Sides a, b, c about the origin: the mean of x^2 is a^2/12."""
    return Means(a * b * c, (F(0),) * 3, diagonal(a * a / 12, b * b / 12, c * c / 12))


def hollowed(whole: Means, factor: Fraction, *, across: bool = False) -> Means:
    """The solid without its copy scaled by `factor` about the centre, in x and y alone if `across`:
    volumes and moments subtract (1.31).
    """
    if across:
        part = factor**2
    else:
        part = factor**3
    scale = (factor**2, factor**2, F(1) if across else factor**2)
    left = [whole.second[i][i] * (1 - part * scale[i]) / (1 - part) for i in range(3)]
    return Means(whole.volume * (1 - part), whole.centre, diagonal(*left), whole.is_round)


def plate_triangle(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """Corners 0, (b, 0), (a, c): with p, q two corners from the third, the second moments are (2 p
    p + 2 q q - p q - q p)/36.
    """
    p = (b, F(0), F(0))
    q = (a, c, F(0))

    def moment(i: int, j: int) -> Fraction:
        own = 2 * p[i] * p[j] + 2 * q[i] * q[j]
        mixed = p[i] * q[j] + q[i] * p[j]
        return (own - mixed) / 36

    centre = ((a + b) / 3, c / 3, F(0))
    return Means(b * c / 2, centre, matrix(moment))


def angle(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """A cuboid [0, a] [0, b] [0, c] without the quarter x > a/2, y > b/2."""
    volume = a * b * c * 3 / 4
    centre = (a * 5 / 12, b * 5 / 12, c / 2)
    second = diagonal(a * a * 11 / 144, b * b * 11 / 144, c * c / 12, xy=-a * b / 36)
    return Means(volume, centre, second)


def cylinder(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """Half-axes a, b, height c, about the origin."""
    return Means(a * b * c, (F(0),) * 3, diagonal(a * a / 4, b * b / 4, c * c / 12), True)


SOLIDS: dict[str, Callable[[Fraction, Fraction, Fraction, Fraction], Means]] = {
    "cuboid": lambda a, b, c, f: cuboid(a, b, c),
    "ellipsoid": lambda a, b, c, f: Means(
        a * b * c * 4 / 3, (F(0),) * 3, diagonal(a * a / 5, b * b / 5, c * c / 5), True
    ),
    "elliptical-cylinder": lambda a, b, c, f: cylinder(a, b, c),
    "rectangular-pyramid": lambda a, b, c, f: Means(
        a * b * c / 3, (F(0), F(0), c / 4), diagonal(a * a / 20, b * b / 20, c * c * 3 / 80)
    ),
    "right-angle-wedge": lambda a, b, c, f: Means(
        a * b * c / 2,
        (a / 3, F(0), c / 3),
        diagonal(a * a / 18, b * b / 12, c * c / 18, xz=-a * c / 36),
    ),
    "isosceles-wedge": lambda a, b, c, f: Means(
        a * b * c / 2, (F(0), F(0), c / 3), diagonal(b * b / 24, a * a / 12, c * c / 18)
    ),
    "tetrahedron": lambda a, b, c, f: Means(
        a * b * c / 6,
        (a / 4, b / 4, c / 4),
        diagonal(
            a * a * 3 / 80,
            b * b * 3 / 80,
            c * c * 3 / 80,
            xy=-a * b / 80,
            xz=-a * c / 80,
            yz=-b * c / 80,
        ),
    ),
    "angle": lambda a, b, c, f: angle(a, b, c),
    "hollow-cuboid": lambda a, b, c, f: hollowed(cuboid(a, b, c), f),
    "hollow-cylinder": lambda a, b, c, f: hollowed(cylinder(a, a, c), f, across=True),
    "cuboid-at-corner": lambda a, b, c, f: Means(
        a * b * c, (F(0),) * 3, cuboid(a, b, c).second, about=(a / 2, b / 2, c / 2)
    ),
    "triangle": lambda a, b, c, f: plate_triangle(a, b, c),
    "angle-plate": lambda a, b, c, f: Means(
        a * b * 3 / 4, (a * 5 / 12, b * 5 / 12, F(0)), _flat(angle(a, b, c).second)
    ),
    "points": lambda a, b, c, f: points(a, b, c),
}
"""By name, for sizes a, b, c [m] and the part f of the size that a hollow has."""


def _flat(second: Matrix) -> Matrix:
    return diagonal(second[0][0], second[1][1], xy=second[0][1])


def points(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """1, 2, 3 and 4 kg at 0, (a, 0, 0), (a, b, 0) and (a, b, c), as sums over pairs: (1/M^2) sum
    m_i m_j (r_i - r_j)(r_i - r_j)^T.
    """
    masses = [F(1), F(2), F(3), F(4)]
    places = [
        (F(0),) * 3,
        (a, F(0), F(0)),
        (a, b, F(0)),
        (a, b, c),
    ]
    pairs = [
        (masses[i] * masses[j], [x - y for x, y in zip(places[i], places[j], strict=True)])
        for i in range(4)
        for j in range(i)
    ]
    second = matrix(lambda i, j: sum((m * d[i] * d[j] for m, d in pairs), F(0)) / 100)
    return Means(F(10), (a * 9 / 10, b * 7 / 10, c * 4 / 10), second)


def turned(means: Means, q: tuple[Fraction, ...]) -> Means:
    """The solid after the turn q r q*/|q|^2, as columns of the turned axes; rational for every
    rational q.
    """
    w = q[0]
    v = q[1:]
    size = w * w + sum(x * x for x in v)
    columns = []
    for k in range(3):
        e = [F(int(i == k)) for i in range(3)]
        along = v[k]
        cross = [
            v[(i + 1) % 3] * e[(i + 2) % 3] - v[(i + 2) % 3] * e[(i + 1) % 3] for i in range(3)
        ]
        columns.append(
            [
                (2 * along * v[i] + (2 * w * w - size) * e[i] + 2 * w * cross[i]) / size
                for i in range(3)
            ]
        )
    own = means.second
    pairs = [(k, m) for k in range(3) for m in range(3)]
    second = matrix(
        lambda i, j: sum((columns[k][i] * own[k][m] * columns[m][j] for k, m in pairs), F(0))
    )
    centre = tuple(sum((columns[k][i] * means.centre[k] for k in range(3)), F(0)) for i in range(3))
    return Means(means.volume, (centre[0], centre[1], centre[2]), second, means.is_round)


def every(p: Parameters) -> dict[str, Means]:
    """The solids at these parameters; the tetrahedron also turned by `attitude`."""
    sizes = numbers(p, "a", "b", "c", "hollow")
    found = {name: solid(*sizes.values()) for name, solid in SOLIDS.items()}
    return found | {"turned-tetrahedron": turned(found["tetrahedron"], vector(p, "attitude"))}


def values(p: Parameters) -> dict[str, arb]:
    """Mass [kg], centre of mass [m] and inertia tensor [kg m^2] of every solid."""
    found: dict[str, arb] = {}
    for name, means in every(p).items():
        if name == "points":
            density = F(1)
        else:
            density = numbers(p, "density")["density"]
        mass = arb_of(density * means.volume) * (arb.pi() if means.is_round else 1)
        tensor = means.tensor()
        found[f"{name}.mass"] = mass
        found |= {f"{name}.centre.{x}": arb_of(means.centre["xyz".index(x)]) for x in "xyz"}
        found |= {
            f"{name}.inertia.{i}{j}": mass * arb_of(tensor["xyz".index(i)]["xyz".index(j)])
            for i, j in PAIRS
        }
    return found


PAIRS = tuple((pair[0], pair[1]) for pair in ("xx", "yy", "zz", "xy", "xz", "yz"))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters a, b, c, density, hollow, attitude."""
    return Timeless(
        scale,
        lambda: values(p),
        witness="sums over signed tetrahedra in rational arithmetic; quadrature where round",
    )
