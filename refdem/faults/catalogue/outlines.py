"""Flows of outlines in phase space: volume that is lost or gained, and points that do not move."""

from dataclasses import replace
from functools import partial
from math import exp
from typing import Any

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import of_parts
from refdem.faults.fault import Fault
from refdem.faults.outlines import linear_flow

carried = partial(Fault, kind="phase-volume", method="carried")
AREA = ("phase-area", "area")


def _left_behind(request: Request, run: Trajectory) -> Trajectory:
    """One point between two corners stays where it began."""
    values = {name: column.copy() for name, column in run.values.items()}
    for column in values.values():
        column[:, 1] = column[0, 1]
    return replace(run, values=values)


def _squeezed(x: float, v: float, square: float, delta: float, t: float) -> Any:
    """Velocities are multiplied by exp(-1e-10 t), so that areas shrink at this rate."""
    place, rate = linear_flow(x, v, square, delta, t)
    return place, rate * exp(-1e-10 * t)


FAULTS = (
    carried(
        name="point-left-behind",
        sentence="One point of the outline does not move.",
        on=("head",),
        sees=AREA,
        after=_left_behind,
    ),
    carried(
        name="hidden-damping-of-volume",
        sentence="A flow that should conserve phase-space volume slowly reduces it.",
        on=("head",),
        sees=AREA,
        inside=of_parts(flow=_squeezed),
    ),
    carried(
        name="volume-shrinks-half-as-fast",
        sentence="The phase-space volume decays as exp(-delta t) instead of exp(-2 delta t).",
        on=("wet-head",),
        sees=AREA,
        inside=of_parts(
            flow=lambda x, v, square, delta, t: linear_flow(x, v, square, delta / 2, t)
        ),
    ),
)
