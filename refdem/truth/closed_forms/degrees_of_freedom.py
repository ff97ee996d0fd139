"""Degrees of freedom by ranks in rational arithmetic: of rods at first order, of points for finite
motions.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations

from flint import arb, fmpq, fmpq_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import vector
from refdem.truth.timeless import Timeless

Point = Sequence[Fraction]


def rank(rows: Sequence[Sequence[Fraction]]) -> int:
    """The rank of a matrix of exact numbers."""
    entries = [[fmpq(x.numerator, x.denominator) for x in row] for row in rows]
    if entries:
        return int(fmpq_mat(entries).rref()[1])
    return 0


def first_order(points: Sequence[Point], rods: Sequence[tuple[int, int]]) -> int:
    """Coordinates less the rank of the derivatives of half the squared lengths."""
    size = len(points[0])
    count = len(points)
    rows = []
    for a, b in rods:
        along = [x - y for x, y in zip(points[a], points[b], strict=True)]
        row = [[Fraction(0)] * size for _ in range(count)]
        row[a] = along
        row[b] = [-x for x in along]
        rows.append([x for part in row for x in part])
    return size * count - rank(rows)


def finite(points: Sequence[Point]) -> int:
    """Dimension of the orbit under translations and turns: those that move nothing turn about all
    points at once.
    """
    size = len(points[0])
    spread = rank([[x - y for x, y in zip(point, points[0], strict=True)] for point in points])
    turns = {(2, 0): 0, (2, 1): 1, (2, 2): 1, (3, 0): 0, (3, 1): 2, (3, 2): 3, (3, 3): 3}
    return size + turns[size, spread]


def counts(p: Parameters) -> dict[str, int]:
    """Every row of the case as an integer, by name."""
    numbers = vector(p, "points")
    space = [numbers[3 * i : 3 * i + 3] for i in range(5)]
    every = {size: [point[:size] for point in space] for size in (2, 3)}

    def whole(points: Sequence[Point]) -> int:
        return first_order(points, list(combinations(range(len(points)), 2)))

    found = {f"{size}d-{n}": whole(every[size][:n]) for size in (2, 3) for n in range(1, 6)}
    found |= {"rods-6-on-4-in-2d": whole(every[2][:4]), "rods-10-on-5-in-3d": whole(every[3])}
    found["rod-twice"] = first_order(space[:2], [(0, 1), (1, 0)])
    flat = [(*point[:2], Fraction(0)) for point in space]
    lines = {
        size: [
            [factor * x for x in every[size][1]]
            for factor in (Fraction(0), Fraction(1), Fraction(5, 2))
        ]
        for size in (2, 3)
    }
    degenerate: dict[str, Sequence[Point]] = {
        "coplanar-4": flat[:4],
        "coplanar-5": flat,
        "collinear-3": lines[3],
        "2d-collinear-3": lines[2],
    }
    for name, points in degenerate.items():
        found |= {f"{name}-first-order": whole(points), f"{name}-rigid": finite(points)}
    return found


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at the parameter points."""
    return Timeless(
        scale,
        lambda: {name: arb(n) for name, n in counts(p).items()},
        witness="the chapter's counts",
    )
