"""Figure 1.33: the shape of the wall alone: a cat's head of points flies on a rectangular and on a
stadium table (1.6.4).
"""

from typing import Any

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.core.problem import Iteration
from refdem.gallery.runs import Array, answer, command, instance, remember

DIRECTION = (4, 3)
"""Direction in which all points start."""
BOUNCES = 16
"""Bounces of each point that are drawn."""
MOMENTS = (0.0, 4.0, 8.0, 14.0)
"""Times [s] at which all points are drawn."""
PICKED = (0, 130, 300)
"""Points whose paths are drawn."""


def figure() -> Figure:
    """The two tables, with the points at four moments and three of their paths."""
    head = instance("phase-flow", points=1024, centre=("-1", "-1/2"), size="1/4").problem
    # The cat's head of the phase plane, as places on the table.
    points = np.stack((head.position[:, 0, 0], head.velocity[:, 0, 0]), axis=1)
    panels = []
    numbers = {}
    for geometry in ("rectangle", "stadium"):
        table = instance("billiards", geometry=geometry, direction=DIRECTION)
        remember(command(table))
        paths = [path(table, point) for point in points]
        clouds = [places(paths, moment) for moment in MOMENTS]
        panels.append(panel(geometry, wall(geometry, table.p.size), paths, clouds))
        for cloud, moment in ((clouds[0], MOMENTS[0]), (clouds[-1], MOMENTS[-1])):
            numbers[f"{geometry}: spread at t = {moment:g} [m]"] = spread(cloud)
    caption = (
        "1040 points on a cat's head fly with one velocity and are reflected by the wall; blue are"
        " the points at t = 0, 4, 8 and 14, grey the paths of three of them. In the rectangle they"
        " stay side by side, in the stadium the half circles scatter them."
    )
    return Figure(
        id="1.33",
        title="Billiards",
        caption=caption,
        panels=tuple(panels),
        numbers=numbers,
        digits=3,
    )


def panel(geometry: str, border: Array, paths: list[Array], clouds: list[Array]) -> Panel:
    """A table: three paths, its border, and all points at each of the moments."""
    series = []
    for number in PICKED:
        x, y = paths[number].T
        series.append(Series(x=x, y=y, ink=GREY, width=1))
    series.append(Series(x=border[:, 0], y=border[:, 1], ink=1, width=2))
    for cloud in clouds:
        series.append(Series(x=cloud[:, 0], y=cloud[:, 1], mark="cloud", width=2.5))
    return Panel(
        series=tuple(series),
        title=geometry,
        size=(630, 330),
        x=Axis(ends=(-2.1, 2.1), is_hidden=True),
        y=Axis(ends=(-1.1, 1.1), is_hidden=True),
    )


def spread(places: Array) -> float:
    """The root mean square distance [m] of places (N, 2) from their middle."""
    return float(np.hypot(*places.std(axis=0)))


def path(table: Any, start: Array) -> Array:
    """Places (BOUNCES + 1, 2) of the bounces on a table of a point that starts at `start` (2) in
    the direction of the table's own point.
    """
    own: Iteration = table.problem
    begin = np.concatenate((start, own.start[2:]))
    run = answer(Iteration(own.map, begin, BOUNCES))
    return run.values["position"]


def places(paths: list[Array], moment: float) -> Array:
    """Where all points are at a moment (N, 2), each on its path."""
    return np.array([place(path, moment) for path in paths])


def place(path: Array, moment: float) -> Array:
    """Where a point is that flies along a path with speed 1."""
    # Length [m] of the path to each bounce; with speed 1 also its time [s].
    legs = np.hypot(*np.diff(path, axis=0).T)
    times = np.concatenate(([0.0], np.cumsum(legs)))
    x = np.interp(moment, times, path[:, 0])
    y = np.interp(moment, times, path[:, 1])
    return np.array([x, y])


def wall(geometry: str, size: Array) -> Array:
    """The border of the table (N, 2) [m]."""
    half = size / 2
    if geometry == "rectangle":
        rectangle: Array = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
        return rectangle
    turn = np.linspace(-np.pi / 2, np.pi / 2, 61)
    centre = [half[0] - half[1], 0.0]
    arc = half[1] * np.stack((np.cos(turn), np.sin(turn)), axis=1) + centre
    return np.concatenate((arc, -arc, arc[:1]))
