"""Drawing three dimensions on two: a parallel projection, and the frame of its axes."""

import numpy as np

from refdem.core.figure import GREY, Series
from refdem.gallery.runs import Array

AZIMUTH = 35.0
"""Degrees by which the axes are turned about the vertical: none of them then hides another."""
ELEVATION = 25.0
"""Degrees by which the view is raised above the horizontal."""


def projected(points: Array) -> tuple[Array, Array, Array]:
    """Right, up and towards the eye (N,) of points (N, 3) in a parallel projection."""
    turn = np.radians(AZIMUTH)
    rise = np.radians(ELEVATION)
    x, y, z = points.T
    # A turn about the vertical, then one about the line to the right.
    right = x * np.cos(turn) + y * np.sin(turn)
    depth = -x * np.sin(turn) + y * np.cos(turn)
    up = z * np.cos(rise) + depth * np.sin(rise)
    towards = z * np.sin(rise) - depth * np.cos(rise)
    return right, up, towards


def axis(begin: Array, end: Array, name: str) -> tuple[Series, Series]:
    """A line in space, and its name at the end."""
    beyond = np.asarray(begin) + 1.1 * (np.asarray(end) - begin)
    right, up, _ = projected(np.array([begin, end, beyond]))
    line = Series(x=right[:2], y=up[:2], ink=GREY, width=1)
    letters = Series(x=right[2:], y=up[2:], ink=GREY, mark="text", words=(name,))
    return line, letters
