"""Bounces of a billiard: the speed is kept and each of them lies on the wall, for ever, whatever
chaos does to the rest.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.maps import Billiard, StadiumBilliard
from refdem.core.problem import Iteration
from refdem.core.refinement import ROUND_OFF_FACTOR
from refdem.core.variant import Variant

CORNER = 1e-12
"""Part of the table's size: a place after many bounces is not known better."""
BASIS = (
    "each bounce is tested from the previous one alone, so errors do not"
    " accumulate: a few roundings are allowed"
)


class Bounces(Check):
    """Judged at every sample, beyond the predictability horizon too."""

    name = "bounces"
    title = "Bounces"
    judges = (Iteration,)
    kills = (
        "an incorrect reflection, a wall in the wrong place, a direction vector"
        " that loses its length over many bounces"
    )

    def applies(self, subject: Subject) -> str | None:
        """None for billiards, else the reason why not."""
        problem = subject.instance.problem
        if isinstance(problem, Iteration) and isinstance(problem.map, Billiard):
            return None
        return "the case is not a billiard"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of the map."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Speed, distance from the wall, and directions that point out of the table."""
        problem = subject.instance.problem
        run = runs[subject.finest].trajectory
        assert isinstance(problem, Iteration)
        assert isinstance(problem.map, Billiard)
        place = run.values["position"][1:]
        direction = run.values["direction"][1:]
        off, normal = wall(problem.map, place)
        sizes = {
            "speed": (
                np.abs(np.hypot(*direction.T) - 1),
                "The relative change of the speed",
            ),
            "wall": (
                np.abs(off) / subject.instance.scales.length,
                "The distance of a bounce from the wall, relative to the size of the table,",
            ),
            "inward": (
                np.maximum(0.0, np.sum(direction * normal, axis=1)),
                "The component of a direction vector that points out of the table",
            ),
        }
        return [
            worst(
                check=self.name,
                quantity=name,
                t=run.t[1:],
                values=values,
                allowed=ROUND_OFF_FACTOR * subject.method.round_off,
                unit="1",
                basis=BASIS,
                what=what,
            )
            for name, (values, what) in sizes.items()
        ]


def wall(table: Billiard, place: Array) -> tuple[Array, Array]:
    """Distance (T,) [m] of places (T, 2) from the wall, positive outside, and the unit normal (T,
    2) out of the table there.

    In the corner of a rectangle, to rounding, two walls are met one after the other and either may
    be meant: the normal is 0.
    """
    half = np.array([table.width, table.height]) / 2
    if isinstance(table, StadiumBilliard):
        ahead = np.maximum(np.abs(place[:, 0]) - (half[0] - half[1]), 0.0)
        from_line = np.column_stack((np.copysign(ahead, place[:, 0]), place[:, 1]))
        size = np.hypot(*from_line.T)
        return size - half[1], from_line / np.maximum(size, np.finfo(float).tiny)[:, None]
    beyond = np.abs(place) - half
    across = beyond[:, 0] > beyond[:, 1]
    cornered = beyond.min(axis=1) > -CORNER * half.max()
    normal = np.where(across[:, None], [1.0, 0.0], [0.0, 1.0]) * np.sign(place) * ~cornered[:, None]
    return np.where(across, beyond[:, 0], beyond[:, 1]), normal


CHECK = Bounces()
