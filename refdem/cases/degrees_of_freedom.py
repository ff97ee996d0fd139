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
        """Raises UsageError for points of which four lie in a plane, or three have a line as their
        shadow.
        """
        from refdem.mechanics.freedom import rank

        space = all(
            rank(p.points[list(four)] - p.points[four[0]]) == 3
            for four in combinations(range(5), 4)
        )
        if not (
            space
            and all(
                rank(p.points[list(three), :2] - p.points[three[0], :2]) == 2
                for three in combinations(range(5), 3)
            )
        ):
            raise UsageError(
                "parameter points: expected no four of them in a plane, and no three on a line as"
                " seen along z"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """Counts of complete graphs, of redundant rods, and of degenerate placements to first order
        and for finite motions.
        """
        found: list[Row] = []
        for size in (2, 3):
            found += [_count(f"{size}d-{n}", size, p.points[:n, :size]) for n in range(1, 6)]
        found += [_count(name, size, p.points[:n, :size]) for name, (size, n) in REDUNDANT.items()]
        found.append(
            (
                "rod-twice",
                "first-order-freedom",
                [[3.0], p.points[:2].ravel().tolist(), [0.0, 1.0, 1.0, 0.0]],
            )
        )
        for name, (size, n) in DEGENERATE.items():
            flat: Any
            if "coplanar" in name:
                flat = p.points[:n, :size] * (1, 1, 0)
            else:
                flat = [x * p.points[1, :size] for x in (0.0, 1.0, 2.5)]
            coordinates = [float(x) for point in flat for x in point]
            found.append(_count(f"{name}-first-order", size, flat))
            found.append((f"{name}-rigid", "rigid-freedom", [[float(size)], coordinates]))
        return found

    def truth(self, p: Parameters) -> Truth:
        """The certified numbers: ranks in rational arithmetic."""
        from refdem.truth.closed_forms.degrees_of_freedom import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _count(name: str, size: int, points: object) -> Row:
    """The freedom of points that all hang together."""
    coordinates = [[float(x) for x in point] for point in points]  # type: ignore[attr-defined]
    rods = [float(i) for pair in combinations(range(len(coordinates)), 2) for i in pair]
    return (
        name,
        "first-order-freedom",
        [[float(size)], [x for point in coordinates for x in point], rods],
    )


CASE = DegreesOfFreedom()
