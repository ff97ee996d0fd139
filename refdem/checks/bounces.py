"""Bounces of a billiard: speed is conserved, each bounce lies on the wall, each new direction
points inwards and is the mirror image of the one before; in a rectangle |vx| and |vy| are constant.

Each bounce is tested by itself, so chaos does not matter: all of the run is judged. With the normal
n of the wall a direction u becomes u - 2 (n . u) n (1.6.4). Where every n is parallel to an axis, a
reflection changes the sign of one component only: |u_x| and |u_y| are those of the start after any
number of bounces, except for a rounding at each.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import worst
from refdem.core.maps import Billiard, RectangleBilliard, StadiumBilliard
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
KEPT_BASIS = (
    "every wall is parallel to an axis, so a reflection changes the sign of one component and"
    " nothing else: a few roundings are allowed at each"
)


class Bounces(Check):
    """Local properties of every bounce, also beyond the predictability horizon."""

    name = "bounces"
    title = "Bounces"
    judges = (Iteration,)
    kills = (
        "an incorrect reflection, a wall in the wrong place, a direction vector"
        " that loses its length over many bounces, a rectangle that turns paths a little"
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
        """Four findings: |direction| = 1, distance of the bounce from the wall, direction . normal
        <= 0, and the law of reflection. In a rectangle two more: |direction| along each axis.
        """
        problem = subject.instance.problem
        run = runs[subject.finest].trajectory
        assert isinstance(problem, Iteration)
        assert isinstance(problem.map, Billiard)
        position = run.values["position"][1:]
        direction = run.values["direction"][1:]
        distance, normal = wall(problem.map, position)
        round_off = ROUND_OFF_FACTOR * subject.method.round_off
        # | |u| - 1 |,   |d|/L,   max(0, u . n).
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
        found = [
            worst(
                check=self.name,
                quantity=name,
                t=run.t[1:],
                values=values,
                allowed=round_off,
                unit="1",
                basis=BASIS,
                what=what,
            )
            for name, (values, what) in measured.items()
        ]
        before = np.vstack((problem.start[2:], direction[:-1]))
        follows = np.diff(run.t) == 1
        found.append(
            worst(
                check=self.name,
                quantity="reflection",
                t=run.t[1:][follows],
                values=not_mirrored(before, direction, normal)[follows],
                allowed=round_off * roundings_of_normal(problem.map),
                unit="1",
                basis=BASIS,
                what="The deviation of a direction vector from the mirror image of the one before",
            )
        )
        if isinstance(problem.map, RectangleBilliard):
            # | |u_i(n)| - |u_i(0)| | <= n roundings, for i = x, y.
            changes = np.abs(np.abs(direction) - np.abs(problem.start[2:]))
            found += [
                worst(
                    check=self.name,
                    quantity=f"kept.{name}",
                    t=run.t[1:],
                    values=change,
                    allowed=round_off * run.t[1:],
                    unit="1",
                    basis=KEPT_BASIS,
                    what=f"The change of |v{name}| since the start, relative to the speed,",
                )
                for name, change in zip("xy", changes.T, strict=True)
            ]
        return found


def not_mirrored(before: Array, after: Array, normal: Array) -> Array:
    """Distance (T,) of each direction (T, 2) after a bounce from u - 2 (n . u) n, with u the one
    before it.

    In a corner, where the normal is 0, one or both walls may have been hit: the direction is
    compared with the nearest of u, its images in one wall, and its image in both. Its distance from
    that one is | |after| - |u| |, with |u| = (|u_x|, |u_y|).
    """
    # u - 2 (n . u) n.
    along = np.sum(before * normal, axis=1)
    image = before - 2.0 * along[:, None] * normal
    deviation = np.hypot(*(after - image).T)
    in_corner = ~normal.any(axis=1)
    either = np.hypot(*(np.abs(after) - np.abs(before)).T)
    nearest: Array = np.where(in_corner, either, deviation)
    return nearest


def roundings_of_normal(table: Billiard) -> float:
    """The rounding error of the normal of a wall at a computed place on it, in roundings of a
    direction: 1 for a straight wall, 1 + (length/2)/r for a half circle of radius r.
    """
    if isinstance(table, StadiumBilliard):
        return 1.0 + table.width / table.height
    return 1.0


def wall(table: Billiard, position: Array) -> tuple[Array, Array]:
    """Signed distance (T,) [m] of points (T, 2) from the wall, positive outside, and the outward
    unit normal there (T, 2).

    A stadium is all points within a radius (half its height) of a segment on the x axis. In the
    corner of a rectangle, up to rounding, two walls are hit one after the other and either may be
    the one recorded: the normal is 0.
    """
    half = np.array([table.width, table.height]) / 2
    if isinstance(table, StadiumBilliard):
        # Stadium: d = |(x, y) - nearest point of the segment| - r,   r = height/2.
        past_end = np.maximum(np.abs(position[:, 0]) - (half[0] - half[1]), 0.0)
        # The vector from the nearest point of the segment |x| <= half width - radius, y = 0.
        offset = np.column_stack((np.copysign(past_end, position[:, 0]), position[:, 1]))
        distance = np.hypot(*offset.T)
        return distance - half[1], offset / np.maximum(distance, np.finfo(float).tiny)[:, None]
    # Rectangle: d = max(|x| - width/2, |y| - height/2).
    beyond = np.abs(position) - half
    is_side = beyond[:, 0] > beyond[:, 1]
    is_corner = beyond.min(axis=1) > -CORNER * half.max()
    normal = (
        np.where(is_side[:, None], [1.0, 0.0], [0.0, 1.0]) * np.sign(position) * ~is_corner[:, None]
    )
    return np.where(is_side, beyond[:, 0], beyond[:, 1]), normal


CHECK = Bounces()
