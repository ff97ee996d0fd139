"""Bounces of a billiard: speed is conserved, each bounce lies on the wall, and each new direction
points inwards.

Each bounce is tested by itself, so chaos does not matter: all of the run is judged.
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
"""Distance from a corner, relative to the table, below which either wall may be the one that was
hit.
"""
BASIS = (
    "each bounce is tested from the previous one alone, so errors do not"
    " accumulate: a few roundings are allowed"
)


class Bounces(Check):
    """Local properties of every bounce, also beyond the predictability horizon."""

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
        """Three findings: |direction| = 1, distance of the bounce from the wall, and direction .
        normal <= 0.
        """
        problem = subject.instance.problem
        run = runs[subject.finest].trajectory
        assert isinstance(problem, Iteration)
        assert isinstance(problem.map, Billiard)
        position = run.values["position"][1:]
        direction = run.values["direction"][1:]
        distance, normal = wall(problem.map, position)
        measured = {
            "speed": (
                np.abs(np.hypot(*direction.T) - 1),
                "The relative change of the speed",
            ),
            "wall": (
                np.abs(distance) / subject.instance.scales.length,
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
            for name, (values, what) in measured.items()
        ]


def wall(table: Billiard, position: Array) -> tuple[Array, Array]:
    """Signed distance (T,) [m] of points (T, 2) from the wall, positive outside, and the outward
    unit normal there (T, 2).

    A stadium is all points within a radius (half its height) of a segment on the x axis. In the
    corner of a rectangle, up to rounding, two walls are hit one after the other and either may be
    the one recorded: the normal is 0.
    """
    half = np.array([table.width, table.height]) / 2
    if isinstance(table, StadiumBilliard):
        past_end = np.maximum(np.abs(position[:, 0]) - (half[0] - half[1]), 0.0)
        # The vector from the nearest point of the segment |x| <= half width - radius, y = 0.
        offset = np.column_stack((np.copysign(past_end, position[:, 0]), position[:, 1]))
        distance = np.hypot(*offset.T)
        return distance - half[1], offset / np.maximum(distance, np.finfo(float).tiny)[:, None]
    beyond = np.abs(position) - half
    is_side = beyond[:, 0] > beyond[:, 1]
    is_corner = beyond.min(axis=1) > -CORNER * half.max()
    normal = (
        np.where(is_side[:, None], [1.0, 0.0], [0.0, 1.0]) * np.sign(position) * ~is_corner[:, None]
    )
    return np.where(is_side, beyond[:, 0], beyond[:, 1]), normal


CHECK = Bounces()
