"""Degrees of freedom by ranks in rational arithmetic: of points with rods to first order, and of
points as a rigid body for finite motions.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations

from flint import arb, fmpq, fmpq_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import vector
from refdem.truth.refiner import Refiner
from refdem.truth.timeless import Timeless

Point = Sequence[Fraction]


def rank(rows: Sequence[Sequence[Fraction]]) -> int:
    """The rank of a matrix of exact numbers."""
    entries = [[fmpq(x.numerator, x.denominator) for x in row] for row in rows]
    if entries:
        # The reduced row echelon form is returned with the rank.
        return int(fmpq_mat(entries).rref()[1])
    return 0


def first_order(points: Sequence[Point], rods: Sequence[tuple[int, int]]) -> int:
    """Degrees of freedom to first order: coordinates minus the rank of the rods' constraints.

    The constraint of a rod is the derivative of |r_a - r_b|^2/2 by all coordinates: r_a - r_b in
    the columns of point a, its opposite in those of point b.
    """
    dimension = len(points[0])
    count = len(points)
    rows = []
    for a, b in rods:
        difference = [x - y for x, y in zip(points[a], points[b], strict=True)]
        # d(|r_a - r_b|^2/2) = (r_a - r_b) . (dr_a - dr_b) = 0.
        row = [Fraction(0)] * (dimension * count)
        row[dimension * a : dimension * (a + 1)] = difference
        row[dimension * b : dimension * (b + 1)] = [-x for x in difference]
        rows.append(row)
    # n points in d dimensions: d n - rank.
    return dimension * count - rank(rows)


def finite(points: Sequence[Point]) -> int:
    """Degrees of freedom of the points as a rigid body: translations, and turns that move a point.

    A rotation about an axis through all points moves none of them. So the number of rotations
    depends on the dimension of space and on the dimension that the points span: `turns` has it by
    (dimension, span).
    """
    dimension = len(points[0])
    span = rank([[x - y for x, y in zip(point, points[0], strict=True)] for point in points])
    # Rotations of d dimensions less those that leave a span of s dimensions at rest:
    # d (d - 1)/2 - (d - s)(d - s - 1)/2, where the last product counts for s < d.
    turns = {(2, 0): 0, (2, 1): 1, (2, 2): 1, (3, 0): 0, (3, 1): 2, (3, 2): 3, (3, 3): 3}
    return dimension + turns[dimension, span]


def with_all_rods(points: Sequence[Point]) -> int:
    """Degrees of freedom to first order with a rod between every two points."""
    return first_order(points, list(combinations(range(len(points)), 2)))


def counts(p: Parameters) -> dict[str, int]:
    """Every row of the case as an integer, by name.

    Rows `2d-n` and `3d-n` are complete graphs of n points; in degenerate places the first-order
    count is larger than that of the rigid body.
    """
    numbers = vector(p, "points")
    space = [numbers[3 * i : 3 * i + 3] for i in range(5)]
    plane = [point[:2] for point in space]
    rows = {}
    for n in range(1, 6):
        rows[f"2d-{n}"] = with_all_rods(plane[:n])
        rows[f"3d-{n}"] = with_all_rods(space[:n])
    # The complete graphs of 4 and 5 points have 6 and 10 rods.
    rows["rods-6-on-4-in-2d"] = with_all_rods(plane[:4])
    rows["rods-10-on-5-in-3d"] = with_all_rods(space)
    # Two equal rows of constraints have the rank 1: 3 * 2 - 1 = 5.
    rows["rod-twice"] = first_order(space[:2], [(0, 1), (1, 0)])
    # To first order a rod has no effect on displacements at right angles to it, so that rods in
    # one plane (or on one line) leave more degrees of freedom than a rigid body has.
    coplanar = [(*point[:2], Fraction(0)) for point in space]
    factors = (Fraction(0), Fraction(1), Fraction(5, 2))
    degenerate: dict[str, Sequence[Point]] = {
        "coplanar-4": coplanar[:4],
        "coplanar-5": coplanar,
        "collinear-3": [[factor * x for x in space[1]] for factor in factors],
        "2d-collinear-3": [[factor * x for x in plane[1]] for factor in factors],
    }
    for name, points in degenerate.items():
        rows[f"{name}-first-order"] = with_all_rods(points)
        rows[f"{name}-rigid"] = finite(points)
    return rows


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at the parameter points."""
    return Timeless(
        Refiner.of(scale),
        lambda: {name: arb(n) for name, n in counts(p).items()},
        witness="the chapter's counts",
    )
