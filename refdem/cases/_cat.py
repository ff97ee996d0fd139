"""A cat's head of our own drawing, in the plane of a place and its rate."""

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
"""Corners against the clock, in sixteenths of the size: cheeks, ears, chin."""
SIXTEEN = 16


def corners(p: Parameters) -> list[tuple[Fraction, Fraction]]:
    """Position and velocity of every corner of the outline, exact."""
    size = p["size"]
    centre = p["centre"]
    assert isinstance(size, Fraction)
    assert isinstance(centre, tuple)
    return [(centre[0] + size * a / SIXTEEN, centre[1] + size * b / SIXTEEN) for a, b in HEAD]


def points(p: Parameters) -> Array:
    """Place and rate (M, 2) of points evenly along every side.

    M is the next multiple of four times the number of sides.
    """
    ends = np.array([[float(x) for x in corner] for corner in corners(p)])
    each = 4 * int(np.ceil(p.points / (4 * len(ends))))
    along = np.arange(each)[:, None] / each
    sides = [
        (1 - along) * a + along * b for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True)
    ]
    return np.concatenate(sides)


def refuse_crossing(p: Parameters) -> None:
    """Raises UsageError for a head of which only a part has passed a turning point."""
    rates = [v for _, v in corners(p)]
    if p.flow == "coulomb" and not (min(rates) > 0 or max(rates) < 0):
        raise UsageError(
            f"centre and size put v between {float(min(rates)):g} and {float(max(rates)):g} m/s; "
            "under dry friction the head must start on one side of v = 0"
        )
