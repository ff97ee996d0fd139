"""Billiards in a rectangle and in a stadium (fig. 1.33): the shape of the wall alone decides
between order and chaos.
"""

from typing import ClassVar

import numpy as np

from refdem.cases._table import exact, refuse_outside
from refdem.core.case import Array, IterationCase
from refdem.core.maps import RectangleBilliard, StadiumBilliard
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Iteration
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth


class Billiards(IterationCase):
    """The table is centred on the origin, its length along x."""

    id = "billiards"
    title = "Billiards"
    words = ("pool", "table", "chaos", "circle", "reflection")
    motion = "formula"
    statement = (
        "A point flies straight at constant speed and is reflected by the wall of its table. In a"
        " rectangle neighbouring paths stay parallel: mirrored tables side by side make one"
        " straight line of them, and place and direction after any number of bounces follow from"
        " whole numbers. In a stadium the half circles focus beams that then spread: errors grow"
        " exponentially, a run in binary64 is scored for a few dozen bounces; but speed it must"
        " keep, and bounce on the wall, for ever. A path that meets a corner has no continuation;"
        " there truth ends, and says so."
    )
    latex = (
        r"\mathbf r_{n+1}=\mathbf r_n+t_n\mathbf u_n,\qquad \mathbf u_{n+1}=\mathbf u_n-2(\mathbf"
        r" n\cdot\mathbf u_n)\,\mathbf n"
    )
    source = "Matuttis and Chen 2014, chapter 1, 1.6.4, fig. 1.33; Bunimovich 1979"
    parameters = (
        Parameter(
            name="geometry",
            default="stadium",
            unit="",
            doc="shape of the table",
            choices=("rectangle", "stadium"),
        ),
        Parameter(
            name="start", default="1/4,1/8", unit="m", doc="a place inside the table", shape=(2,)
        ),
        Parameter(
            name="direction",
            default="4,3",
            unit="1",
            doc="of any length but 0; the speed does not matter",
            shape=(2,),
        ),
        Parameter(
            name="n",
            default="32",
            unit="1",
            doc="number of bounces",
            at_least=1,
            at_most=10_000_000,
            whole=True,
        ),
        Parameter(
            name="size",
            default="4,2",
            unit="m",
            doc="length and width of the table",
            shape=(2,),
            above=0,
        ),
    )
    chaotic_at: ClassVar = {"geometry": "stadium"}

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a start that is not inside, or no direction."""
        refuse_outside(p)

    def is_chaotic(self, p: Parameters) -> bool | None:
        """True in a stadium with straight walls, False in rectangles and circles.

        None for a path along an axis of the stadium, which may be regular.
        """
        length, width = exact(p, "size")
        if p["geometry"] == "rectangle" or length == width:
            return False
        return all(exact(p, "direction")) or None

    def problem(self, p: Parameters) -> Iteration:
        """Place and unit direction from bounce to bounce."""
        table: type[StadiumBilliard | RectangleBilliard] = RectangleBilliard
        if p.geometry == "stadium":
            table = StadiumBilliard
        start = np.concatenate((p.start, p.direction / np.hypot(*p.direction)))
        return Iteration(table(width=p.size[0], height=p.size[1]), start, int(p.n))

    def scales(self, p: Parameters) -> Scales:
        """The length of the table; tau is one bounce."""
        return Scales(length=float(p.size.max()), tau=1.0, duration=p.n)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place of bounce n, and the direction after it."""
        units = (("position", "m", self.scales(p).length), ("direction", "1", 1.0))
        return tuple(
            Quantity(f"{name}.{a}", unit, scale) for name, unit, scale in units for a in "xy"
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The place [m] and the direction at every bounce that is sampled."""
        observed: dict[str, Array] = {}
        for name in ("position", "direction"):
            if name in trajectory.values:
                columns = trajectory.values[name]
                observed[f"{name}.x"] = columns[:, 0]
                observed[f"{name}.y"] = columns[:, 1]
        return observed

    def truth(self, p: Parameters) -> Truth:
        """Unfolding of the rectangle; the collision map of the stadium with a proven itinerary."""
        from refdem.truth.maps.billiards import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Billiards()
