"""Degrees of freedom of points on rods, generic, redundant and degenerate (chapter 1, section
1.1).
"""

from itertools import combinations
from typing import Any

from refdem.cases._algebra import AlgebraCase, Row
from refdem.core.parameters import Parameter, Parameters
from refdem.core.truth import Truth
from refdem.errors import UsageError

REDUNDANT = {"rods-6-on-4-in-2d": (2, 4), "rods-10-on-5-in-3d": (3, 5)}
DEGENERATE = {
    "coplanar-4": (3, 4),
    "coplanar-5": (3, 5),
    "collinear-3": (3, 3),
    "2d-collinear-3": (2, 3),
}
"""Dimension and number of points."""


class DegreesOfFreedom(AlgebraCase):
    """Five points; the first n of them hang together, in space or in the plane of their x and y."""

    id = "degrees-of-freedom"
    title = "Degrees of freedom"
    words = ("constraints", "joints", "count", "gear", "linkage")
    motion = "formula"
    statement = (
        "Points that all hang together by rods move as one body: three ways in the plane, six in"
        " space, however many they are. Rods more than needed take no freedom. In degenerate"
        " placements, all points in a plane or on a line, the constraints are dependent to first"
        " order: there are more velocities that keep them (7, 8, 7; 4 in the plane) than finite"
        " motions (6, 6, 5; 3)."
    )
    latex = r"f=Dn-\operatorname{rank}\frac{\partial g}{\partial\mathbf r}"
    source = "Matuttis and Chen 2014, chapter 1, section 1.1"
    parameters = (
        Parameter(
            name="points",
            default="0,0,0,3,1/2,-1,1,2,1/4,-1,5/4,2,2,-3/2,3/4",
            unit="m",
            doc="in general position",
            shape=(5, 3),
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for points that are not in general position.

        No four may lie in a plane, and no three on a line once z is left out. Points span a space
        of as many dimensions as the rank of their differences from the first one.
        """
        from refdem.mechanics.freedom import rank

        spans_space = all(
            rank(p.points[list(four)] - p.points[four[0]]) == 3
            for four in combinations(range(5), 4)
        )
        spans_plane = all(
            rank(p.points[list(three), :2] - p.points[three[0], :2]) == 2
            for three in combinations(range(5), 3)
        )
        if not (spans_space and spans_plane):
            raise UsageError(
                "parameter points: expected no four of them in a plane, and no three on a line as"
                " seen along z"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """Counts of complete graphs of 1 to 5 points, of redundant rods, and of degenerate
        placements to first order and for finite motions.
        """
        rows: list[Row] = []
        for dimension in (2, 3):
            for n in range(1, 6):
                rows.append(_count(f"{dimension}d-{n}", dimension, p.points[:n, :dimension]))
        for name, (dimension, n) in REDUNDANT.items():
            rows.append(_count(name, dimension, p.points[:n, :dimension]))
        # The rod from point 0 to point 1, and once more from 1 to 0.
        two_points = p.points[:2].ravel().tolist()
        same_rod = [0.0, 1.0, 1.0, 0.0]
        rows.append(("rod-twice", "first-order-freedom", [[3.0], two_points, same_rod]))
        for name, (dimension, n) in DEGENERATE.items():
            placement: Any
            if "coplanar" in name:
                placement = p.points[:n, :dimension] * (1, 1, 0)
            else:
                # Three points on the line through the origin and point 1.
                placement = [x * p.points[1, :dimension] for x in (0.0, 1.0, 2.5)]
            coordinates = [float(x) for point in placement for x in point]
            rows.append(_count(f"{name}-first-order", dimension, placement))
            rows.append((f"{name}-rigid", "rigid-freedom", [[float(dimension)], coordinates]))
        return rows

    def truth(self, p: Parameters) -> Truth:
        """The certified numbers: ranks in rational arithmetic."""
        from refdem.truth.closed_forms.degrees_of_freedom import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _count(name: str, dimension: int, points: Any) -> Row:
    """The row of the first-order freedom of `points` (n, dimension), a rod between any two of
    them.
    """
    coordinates = [float(x) for point in points for x in point]
    pairs = combinations(range(len(points)), 2)
    rods = [float(end) for pair in pairs for end in pair]
    return (name, "first-order-freedom", [[float(dimension)], coordinates, rods])


CASE = DegreesOfFreedom()
