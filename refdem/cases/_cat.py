"""A cat's head of our own drawing, in the phase plane (x, v): the outline that flows carry."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameters
from refdem.errors import UsageError

Array = NDArray[np.float64]
HEAD = (
    (12, -6),
    (14, 0),
    (13, 6),
    (12, 16),
    (5, 10),
    (-5, 10),
    (-12, 16),
    (-13, 6),
    (-14, 0),
    (-12, -6),
    (-7, -11),
    (0, -13),
    (7, -11),
)
"""Corners (a, b), counter-clockwise, in sixteenths of `size`: cheeks, ears, chin."""
SIXTEEN = 16
"""Denominator of the coordinates of HEAD: sixteenths are exact in binary64."""


def corners(p: Parameters) -> list[tuple[Fraction, Fraction]]:
    """The exact (x, v) of every corner: centre + size (a, b)/16."""
    scale = p["size"]
    centre = p["centre"]
    assert isinstance(scale, Fraction)
    assert isinstance(centre, tuple)
    return [(centre[0] + scale * a / SIXTEEN, centre[1] + scale * b / SIXTEEN) for a, b in HEAD]


def points(p: Parameters) -> Array:
    """Points (M, 2) of the outline, (x, v) each, evenly along every side from its first corner on.

    M is at least the parameter `points`: every side has the same number of them, a multiple of 4.
    """
    starts = np.array([[float(x) for x in corner] for corner in corners(p)])
    ends = np.roll(starts, -1, axis=0)
    per_side = 4 * int(np.ceil(p.points / (4 * len(starts))))
    fraction = np.arange(per_side)[:, None] / per_side
    sides = [
        (1 - fraction) * start + fraction * end for start, end in zip(starts, ends, strict=True)
    ]
    return np.concatenate(sides)


def refuse_crossing(p: Parameters) -> None:
    """Raises UsageError, under dry friction, for a head that has corners on both sides of v = 0."""
    rates = [v for _, v in corners(p)]
    if p.flow == "coulomb" and not (min(rates) > 0 or max(rates) < 0):
        raise UsageError(
            f"centre and size put v between {float(min(rates)):g} and {float(max(rates)):g} m/s; "
            "under dry friction the head must start on one side of v = 0"
        )
