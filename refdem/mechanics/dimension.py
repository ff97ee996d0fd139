"""Box-counting dimension of a set of points on a line: 0 for a periodic motion, 1 for one that
fills intervals, and a number between for a fractal.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def box_counts(points: Array, halvings: Sequence[int]) -> Array:
    """How many (K,) of the 2^k equal boxes between the least and the largest of the points (N,)
    hold a point, for each number k of halvings; the points must not all be one.
    """
    low = float(np.min(points))
    part = (points - low) / float(np.ptp(points))
    counts = []
    for k in halvings:
        # The largest point is in the last box, as those just below it are.
        box = np.minimum(np.floor(part * 2.0**k), 2.0**k - 1)
        counts.append(len(np.unique(box)))
    return np.array(counts, float)


def box_dimension(points: Array, first: int, last: int) -> tuple[float, float]:
    """The mean of log2 N(k + 1) - log2 N(k) from `first` to `last` halvings, and its standard error
    from its spread over the halvings.

    A set that is similar to itself by another ratio than 2 has counts that rise unevenly, which the
    error includes. It does not include boxes that too few points left empty: those of a set that
    fills intervals are all counted while its rarest box expects a few points.
    """
    gains = np.diff(np.log2(box_counts(points, range(first, last + 1))))
    error = float(np.std(gains, ddof=1)) / np.sqrt(len(gains))
    return float(np.mean(gains)), float(error)
