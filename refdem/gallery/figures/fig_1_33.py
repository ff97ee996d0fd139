"""Figure 1.33: the shape of the wall alone: a cat's head of points flies on a rectangular and on a
stadium table (1.6.4).
"""

from typing import Any

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.core.problem import Iteration
from refdem.gallery.runs import Array, answer, command, instance, remember

DIRECTION = (4, 3)
BOUNCES = 16
"""Bounces of each point that are drawn."""
MOMENTS = (0.0, 4.0, 8.0, 14.0)
PICKED = (0, 130, 300)


def figure() -> Figure:
    """The two tables, with the points at four moments and three of their paths."""
    head = instance("phase-flow", points=1024, centre=("-1", "-1/2"), size="1/4").problem
    points = np.stack((head.position[:, 0, 0], head.velocity[:, 0, 0]), axis=1)
    panels = []
    numbers = {}
    for geometry in ("rectangle", "stadium"):
        asked = instance("billiards", geometry=geometry, direction=DIRECTION)
        remember(command(asked))
        paths = [path(asked, point) for point in points]
        series = [Series(x=paths[k][:, 0], y=paths[k][:, 1], ink=GREY, width=1) for k in PICKED]
        border = wall(geometry, asked.p.size)
        series.append(Series(x=border[:, 0], y=border[:, 1], ink=1, width=2))
        for n, moment in enumerate(MOMENTS):
            places = np.array([place(own, moment) for own in paths])
            series.append(Series(x=places[:, 0], y=places[:, 1], mark="cloud", width=2.5))
            if n in (0, len(MOMENTS) - 1):
                spread = float(np.hypot(*places.std(axis=0)))
                numbers[f"{geometry}: spread at t = {moment:g} [m]"] = spread
        axes: dict[str, Any] = {
            "x": Axis(ends=(-2.1, 2.1), is_hidden=True),
            "y": Axis(ends=(-1.1, 1.1), is_hidden=True),
        }
        panels.append(Panel(series=tuple(series), title=geometry, size=(630, 330), **axes))
    caption = (
        "1040 points on a cat's head fly with one velocity and are reflected by the wall; blue are"
        " the points at t = 0, 4, 8 and 14, grey the paths of three of them. In the rectangle they"
        " stay side by side, in the stadium the half circles scatter them."
    )
    return Figure(
        id="1.33", title="Billiards", caption=caption, panels=tuple(panels), numbers=numbers
    )


def path(asked: Any, start: Array) -> Array:
    """Places (BOUNCES + 1, 2) of the bounces of a point."""
    first: Iteration = asked.problem
    # The place of the point, the direction of the case.
    begin = np.concatenate((start, first.start[2:]))
    run = answer(Iteration(first.map, begin, BOUNCES))
    return run.values["position"]


def place(path: Array, moment: float) -> Array:
    """Where a point is that flies along a path with speed 1."""
    # Length [m] of the path to each bounce, and so the time [s] of it.
    legs = np.hypot(*np.diff(path, axis=0).T)
    way = np.concatenate(([0.0], np.cumsum(legs)))
    return np.array([np.interp(moment, way, path[:, i]) for i in (0, 1)])


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
