"""Box-counting and correlation dimension of a set of points on a line or in the plane: 0 for a
periodic motion, 1 for one that fills intervals or a curve, 2 for one that fills areas, and a number
between for a fractal.

Boxes are counted alike, however many points they hold; pairs weigh a place by how often it is
visited, so that the correlation dimension is at most that of boxes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AT_ONCE = 2**22
"""Distances of pairs that are held in memory at once: 32 MB."""


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


def correlation_counts(points: Array, halvings: Sequence[int]) -> Array:
    """How many (K,) pairs of points (N,) on a line, or (N, D), are closer than 2^-k of the largest
    distance between any two, for each number k of halvings.

    A distance is the largest difference of any coordinate. Points that coincide are a pair, too.
    """
    columns = points.reshape(len(points), -1)
    part = columns / np.max(np.ptp(columns, axis=0))
    pairs_of_exponent: dict[int, int] = {}
    rows = max(1, AT_ONCE // len(part))
    for begin in range(0, len(part), rows):
        exponents = _exponents(part, begin, min(begin + rows, len(part)))
        values, counts = np.unique(exponents, return_counts=True)
        for value, count in zip(values.tolist(), counts.tolist(), strict=True):
            pairs_of_exponent[value] = pairs_of_exponent.get(value, 0) + count
    return np.array(
        [sum(n for exponent, n in pairs_of_exponent.items() if exponent <= -k) for k in halvings],
        float,
    )


def _exponents(part: Array, begin: int, end: int) -> NDArray[np.int64]:
    """The least e with distance < 2^e of every pair whose first point is one of begin..end - 1 and
    whose second is a later one.
    """
    distance = np.zeros((end - begin, len(part) - begin))
    for column in part.T:
        np.maximum(distance, np.abs(column[begin:end, None] - column[begin:]), out=distance)
    # distance = m 2^e with 1/2 <= m < 1; of a distance 0 every e is one.
    mantissa, exponents = np.frexp(distance)
    exponents[mantissa == 0] = np.iinfo(np.int32).min
    is_later = np.arange(len(part) - begin) > np.arange(end - begin)[:, None]
    return exponents[is_later].astype(np.int64)


def correlation_dimension(points: Array, first: int, last: int) -> tuple[float, float]:
    """The mean of log2 C(k) - log2 C(k + 1) from `first` to `last` halvings, and its standard error
    from its spread over the halvings and from the numbers of pairs; C(k) counts the pairs closer
    than 2^-k (Grassberger and Procaccia 1983).

    The spread includes the unevenness of a set that is similar to itself by another ratio than 2.
    The mean is the slope between both ends alone, so that C counted pairs add 1/sqrt(C) of the
    natural logarithm at each. What the error does not include: at large distances the ends of a set
    lack pairs, a part near 2^-k of a gain; and where a density rises as 1/sqrt at a place, as a map
    with a smooth maximum makes it, pairs go as r log(1/r), and gains come to 1 as slowly as 1 -
    1/log(1/r).
    """
    counts = correlation_counts(points, range(first, last + 1))
    gains = -np.diff(np.log2(counts))
    spread = float(np.std(gains, ddof=1)) / np.sqrt(len(gains))
    of_ends = np.sqrt(1 / counts[0] + 1 / counts[-1]) / np.log(2)
    error = float(np.hypot(spread, of_ends / len(gains)))
    return float(np.mean(gains)), error
