"""Mass properties of solids by integrals done by hand (Table 1.1, (1.14), (1.28), (1.30), (1.31)):
exact rationals, times pi if round.

A solid is its volume V (the area of a plate, the mass of point masses), its centre c, the mean of r
over it, and its second moments M, the mean of (r - c)(r - c)^T. The inertia tensor about c, over
the mass, is trace(M) 1 - M.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.refiner import Refiner
from refdem.truth.timeless import Timeless

F = Fraction
ZERO = F(0)
Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Means:
    """The volume, centre and second moments of a solid.

    `volume` counts in units of pi if `is_round`; the tensor is that about the point `about`, or
    about the centre if that is None.
    """

    volume: Fraction
    centre: Vector
    second: Matrix
    is_round: bool = False
    about: Vector | None = None

    def tensor(self) -> Matrix:
        """The inertia tensor over the mass: trace(M) 1 - M, with M + a a^T about a point at -a
        from the centre (parallel axes).
        """
        # J/m = tr(M') 1 - M' with M' = M + a a^T and a = centre - about.
        arm = [c - p for c, p in zip(self.centre, self.about or self.centre, strict=True)]
        moments = [[self.second[i][j] + arm[i] * arm[j] for j in range(3)] for i in range(3)]
        trace = sum((moments[i][i] for i in range(3)), F(0))

        # (J/m)_ij = tr(M') delta_ij - M'_ij.
        def entry(i: int, j: int) -> Fraction:
            if i == j:
                return trace - moments[i][j]
            return -moments[i][j]

        return matrix(entry)


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
    """A cuboid of sides a, b, c about the origin: the mean of x^2 is a^2/12."""
    return Means(a * b * c, (F(0),) * 3, diagonal(a * a / 12, b * b / 12, c * c / 12))


def hollowed(whole: Means, factor: Fraction, *, across: bool = False) -> Means:
    """The solid without its copy scaled by `factor` about the centre, in x and y alone if `across`.

    Volumes and integrals subtract (1.31): with the copy's part of the volume, p, and of the mean of
    x_i^2, s_i, the mean over what is left is M_ii (1 - p s_i)/(1 - p).
    """
    if across:
        # A copy scaled by f in x and y has the part f^2 of the volume; x^2 and y^2 scale by f^2.
        part = factor**2
        scale = (factor**2, factor**2, F(1))
    else:
        # A copy scaled by f in all axes has the part f^3 of the volume, and squares scale by f^2.
        part = factor**3
        scale = (factor**2, factor**2, factor**2)
    # (V M_ii - p V s_i M_ii)/((1 - p) V).
    second = [whole.second[i][i] * (1 - part * scale[i]) / (1 - part) for i in range(3)]
    return Means(whole.volume * (1 - part), whole.centre, diagonal(*second), whole.is_round)


def plate_triangle(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """A triangular plate with the corners 0, (b, 0) and (a, c).

    With p, q two corners from the third, the second moments about its centre are (2 p p^T + 2 q q^T
    - p q^T - q p^T)/36.
    """
    p = (b, F(0), F(0))
    q = (a, c, F(0))

    def moment(i: int, j: int) -> Fraction:
        squares = 2 * p[i] * p[j] + 2 * q[i] * q[j]
        mixed = p[i] * q[j] + q[i] * p[j]
        return (squares - mixed) / 36

    # The mean of the corners, and half the base times the height.
    centre = ((a + b) / 3, c / 3, F(0))
    return Means(b * c / 2, centre, matrix(moment))


def angle(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """The angle: a cuboid [0, a] [0, b] [0, c] without the quarter x > a/2, y > b/2.

    Three quarters of its volume, with the means over three equal blocks a/2 by b/2.
    """
    volume = a * b * c * 3 / 4
    # Blocks about (a/4, b/4), (3a/4, b/4) and (a/4, 3b/4): the mean of x is 5 a/12, and with
    # (a/2)^2/12 of each block M_xx = a^2 (1/48 + 1/18) = 11 a^2/144, M_xy = -a b/36.
    centre = (a * 5 / 12, b * 5 / 12, c / 2)
    second = diagonal(a * a * 11 / 144, b * b * 11 / 144, c * c / 12, xy=-a * b / 36)
    return Means(volume, centre, second)


def ellipsoid(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """An ellipsoid with half-axes a, b, c about the origin: the mean of x^2 is a^2/5."""
    return Means(a * b * c * 4 / 3, (F(0),) * 3, diagonal(a * a / 5, b * b / 5, c * c / 5), True)


def cylinder(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """An elliptical cylinder with half-axes a, b and height c, about the origin."""
    # pi a b c; <x^2> = a^2/4 over an ellipse, <z^2> = c^2/12 over the height.
    return Means(a * b * c, (F(0),) * 3, diagonal(a * a / 4, b * b / 4, c * c / 12), True)


SOLIDS: dict[str, Callable[[Fraction, Fraction, Fraction, Fraction], Means]] = {
    "cuboid": lambda a, b, c, f: cuboid(a, b, c),
    "ellipsoid": lambda a, b, c, f: ellipsoid(a, b, c),
    "sphere": lambda a, b, c, f: ellipsoid(a, a, a),
    "hollow-sphere": lambda a, b, c, f: hollowed(ellipsoid(a, a, a), f),
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
"""Solids by name, for sizes a, b, c [m] and the relative size f of a cavity."""


def _flat(second: Matrix) -> Matrix:
    """The second moments of the projection of a solid with these moments to z = 0."""
    return diagonal(second[0][0], second[1][1], xy=second[0][1])


def points(a: Fraction, b: Fraction, c: Fraction) -> Means:
    """Point masses of 1, 2, 3 and 4 kg at 0, (a, 0, 0), (a, b, 0) and (a, b, c); `volume` is 10 kg.

    Second moments as sums over pairs: (1/M^2) sum m_i m_j (r_i - r_j)(r_i - r_j)^T.
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
    # sum m (r - c)(r - c)^T/M = (1/M^2) sum over pairs m_i m_j d d^T, d = r_i - r_j, M = 10.
    second = matrix(lambda i, j: sum((m * d[i] * d[j] for m, d in pairs), F(0)) / 100)
    # c = sum m r/10: x = (2 + 3 + 4) a/10, y = (3 + 4) b/10, z = 4 c/10.
    return Means(F(10), (a * 9 / 10, b * 7 / 10, c * 4 / 10), second)


def turned(means: Means, q: tuple[Fraction, ...]) -> Means:
    """The solid after the turn R r = q r q*/|q|^2: centre R c, second moments R M R^T.

    R is rational for every rational q. Its column k is the turned unit vector e_k; with q = (w, v)

        R e = (2 (v . e) v + (w^2 - |v|^2) e + 2 w v x e)/|q|^2,    w^2 - |v|^2 = 2 w^2 - |q|^2.
    """
    w = q[0]
    v = q[1:]
    norm_square = w * w + sum(x * x for x in v)
    columns = []
    for k in range(3):
        e = [F(int(i == k)) for i in range(3)]
        cross = [
            v[(i + 1) % 3] * e[(i + 2) % 3] - v[(i + 2) % 3] * e[(i + 1) % 3] for i in range(3)
        ]
        column = []
        for i in range(3):
            numerator = 2 * v[k] * v[i] + (2 * w * w - norm_square) * e[i] + 2 * w * cross[i]
            column.append(numerator / norm_square)
        columns.append(column)

    def entry(i: int, j: int) -> Fraction:
        total = F(0)
        for k in range(3):
            for m in range(3):
                # (R M R^T)_ij = sum R_ik M_km R_jm; `columns[k][i]` is R_ik.
                total += columns[k][i] * means.second[k][m] * columns[m][j]
        return total

    centre = [sum((columns[k][i] * means.centre[k] for k in range(3)), F(0)) for i in range(3)]
    return Means(means.volume, (centre[0], centre[1], centre[2]), matrix(entry), means.is_round)


def thin_solids(a: Fraction, c: Fraction, thin: Fraction) -> dict[str, Means]:
    """A stick along z of length c and radius `thin` c, also about its end, and a hoop: a tube of
    radius a whose wall is `thin` a.
    """
    stick = cylinder(thin * c, thin * c, c)
    hoop = hollowed(cylinder(a, a, c), 1 - thin, across=True)
    return {
        "stick": stick,
        "stick-at-end": replace(stick, about=(F(0), F(0), c / 2)),
        "hoop": hoop,
    }


def every(p: Parameters) -> dict[str, Means]:
    """The solids at these parameters; the tetrahedron also turned by `attitude`."""
    sizes = numbers(p, "a", "b", "c", "hollow")
    solids = {name: solid(*sizes.values()) for name, solid in SOLIDS.items()}
    solids |= thin_solids(sizes["a"], sizes["c"], number(p, "thin"))
    return solids | {"turned-tetrahedron": turned(solids["tetrahedron"], vector(p, "attitude"))}


def values(p: Parameters) -> dict[str, arb]:
    """Mass [kg], centre of mass [m] and inertia tensor [kg m^2] of every solid."""
    quantities: dict[str, arb] = {}
    for name, means in every(p).items():
        density = numbers(p, "density")["density"]
        if name == "points":
            # The volume of the point masses is their mass.
            density = F(1)
        # m = rho V, J = m (J/m).
        mass = arb_of(density * means.volume)
        if means.is_round:
            mass = mass * arb.pi()
        quantities[f"{name}.mass"] = mass
        for axis, x in zip("xyz", means.centre, strict=True):
            quantities[f"{name}.centre.{axis}"] = arb_of(x)
        tensor = means.tensor()
        for i, j in PAIRS:
            entry = tensor["xyz".index(i)]["xyz".index(j)]
            quantities[f"{name}.inertia.{i}{j}"] = mass * arb_of(entry)
    return quantities


PAIRS = tuple((pair[0], pair[1]) for pair in ("xx", "yy", "zz", "xy", "xz", "yz"))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters a, b, c [m], density [kg/m^3], hollow and thin (parts), attitude."""
    return Timeless(
        Refiner.of(scale),
        lambda: values(p),
        witness="sums over signed tetrahedra in rational arithmetic; quadrature where round",
    )
