"""Figures 1.18 to 1.20 and 1.22: a phase portrait with trajectories, directions of the flow, and
the cat's head at several times.
"""

from collections.abc import Sequence

import numpy as np

from refdem.core.figure import GREY, Axis, Panel, Series
from refdem.gallery.outline import Outline
from refdem.gallery.runs import Array, ObservedRun

SHAFT = 0.055
"""Length of an arrow in units of half the width of the picture."""
BARB = 0.35
"""Length of a barb in units of the shaft."""
OPENING = 0.45
"""Angle between the shaft and a barb [rad]."""


def heads(outline: Outline, samples: Sequence[int], *, ink: int = 0) -> list[Series]:
    """The filled outline at some samples."""
    series = []
    for k in samples:
        # Closed: the first point again at the end.
        x = np.append(outline.x[k], outline.x[k, 0])
        v = np.append(outline.v[k], outline.v[k, 0])
        series.append(Series(x=x, y=v, ink=ink, mark="area"))
    return series


def trajectories(
    runs: Sequence[ObservedRun], *, names: tuple[str, str] = ("x", "v")
) -> list[Series]:
    """The curves of the runs through the plane of two quantities."""
    return [Series(x=run[names[0]], y=run[names[1]], ink=GREY, width=1) for run in runs]


def arrows(
    runs: Sequence[ObservedRun],
    every: int,
    ends: tuple[float, float],
    *,
    names: tuple[str, str] = ("x", "v"),
) -> Series:
    """Arrows along the flow at every so many samples of the runs, all of one length; none where
    nothing moves.
    """
    length = SHAFT * (ends[1] - ends[0]) / 2
    lines: list[Array] = []
    for run in runs:
        points = np.stack((run[names[0]], run[names[1]]), axis=1)
        for k in range(every // 2, len(points) - 1, every):
            displacement = points[k + 1] - points[k]
            distance = float(np.hypot(*displacement))
            if distance > 0:
                lines.append(_arrow(points[k], displacement / distance, length))
    drawn = np.concatenate(lines)
    return Series(x=drawn[:, 0], y=drawn[:, 1], ink=GREY, width=1)


def _arrow(tip: Array, direction: Array, length: float) -> Array:
    """Two barbs at the tip of an arrow along a unit vector, and a break: points (4, 2)."""
    back = -direction * length
    left = tip + BARB * 2 * _turned(back, OPENING)
    right = tip + BARB * 2 * _turned(back, -OPENING)
    return np.array([left, tip, right, [np.nan, np.nan]])


def _turned(vector: Array, angle: float) -> Array:
    """A vector (2,) turned to the left by an angle [rad]."""
    aside = np.array([-vector[1], vector[0]])
    rotated: Array = vector * np.cos(angle) + aside * np.sin(angle)
    return rotated


def portrait(series: Sequence[Series], ends: tuple[float, float], *, width: int = 440) -> Panel:
    """A square picture of place and velocity."""
    return Panel(
        series=tuple(series),
        x=Axis(title="x [m]", ends=ends),
        y=Axis(title="v [m/s]", ends=ends),
        size=(width, width),
    )
