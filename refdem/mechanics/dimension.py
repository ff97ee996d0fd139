"""Box-counting dimension of a set of points on a line or in the plane: 0 for a periodic motion, 1
for one that fills intervals or a curve, 2 for one that fills areas, and a number between for a
fractal.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def box_counts(points: Array, halvings: Sequence[int]) -> Array:
    """How many (K,) of the boxes that halving every axis k times makes hold a point, for each
    number k of halvings: 2^k of points (N,) on a line, 2^(k D) of points (N, D).

    Boxes reach from the least to the largest coordinate along each axis, which no dimension depends
    on; along each axis the points must not all be one.
    """
    columns = points.reshape(len(points), -1)
    low = np.min(columns, axis=0)
    part = (columns - low) / np.ptp(columns, axis=0)
    counts = []
    for k in halvings:
        # The largest point is in the last box, as those just below it are.
        box = np.minimum(np.floor(part * 2.0**k), 2.0**k - 1)
        counts.append(len(np.unique(box, axis=0)))
    return np.array(counts, float)


def return_map(places: Array) -> Array:
    """The points (N - 1, 2) of the plane that have each place but the last, and the one after it,
    as coordinates: a motion that a map of the line makes lies on the graph of the map.
    """
    return np.column_stack((places[:-1], places[1:]))


def box_dimension(points: Array, first: int, last: int) -> tuple[float, float]:
    """The mean of log2 N(k + 1) - log2 N(k) from `first` to `last` halvings, and its standard error
    from its spread over the halvings.

    A set that is similar to itself by another ratio than 2 has counts that rise unevenly, which the
    error includes. It does not include boxes that too few points left empty: those of a set that
    fills intervals are all counted while its rarest box expects a few points. Nor does it include
    coarse boxes: a smooth curve has counts near a 2^k + b, and a mean above 1 until b is small.
    """
    gains = np.diff(np.log2(box_counts(points, range(first, last + 1))))
    error = float(np.std(gains, ddof=1)) / np.sqrt(len(gains))
    return float(np.mean(gains)), float(error)
