"""Box-counting and correlation dimension of a set of points on a line or in the plane.

A dimension is 0 for a periodic motion, 1 for one that fills intervals or a curve, 2 for one that
fills areas, and not an integer for a fractal. With boxes of size 2^-k, N(k) of which hold a point,
and C(k) pairs of points closer than 2^-k,

    D_box = lim log2 N(k)/k,   D_corr = lim -log2 C(k)/k.

Every box counts once, whereas pairs weight a region by the number of its points. The correlation
dimension is therefore at most the box-counting dimension.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AT_ONCE = 2**22
"""Distances of pairs that are held in memory at once: 32 MB."""


def box_counts(points: Array, halvings: Sequence[int]) -> Array:
    """Numbers N(k) (K,) of boxes that hold a point, for each number k of halvings of every axis.

    There are 2^k boxes for points (N,) on a line, and 2^(k D) for points (N, D). They cover the
    range from the least to the largest coordinate along each axis, which does not change a
    dimension. Along each axis at least two coordinates must differ.
    """
    columns = points.reshape(len(points), -1)
    low = np.min(columns, axis=0)
    part = (columns - low) / np.ptp(columns, axis=0)
    counts = []
    for k in halvings:
        # The largest coordinate, part = 1, belongs to the last box.
        box = np.minimum(np.floor(part * 2.0**k), 2.0**k - 1)
        counts.append(len(np.unique(box, axis=0)))
    return np.array(counts, float)


def return_map(places: Array) -> Array:
    """The points (x_n, x_n+1) (N - 1, 2) of the plane, from iterates x (N,). For an iterated map x
    -> f(x) of the line they lie on the graph of f.
    """
    return np.column_stack((places[:-1], places[1:]))


def box_dimension(points: Array, first: int, last: int) -> tuple[float, float]:
    """The mean of log2 N(k + 1) - log2 N(k) from `first` to `last` halvings, and its standard error
    from its spread over the halvings.

    The counts of a set that is self-similar with a ratio other than 2 rise unevenly; the error
    includes this. It does not include two systematic errors. Boxes may stay empty because there are
    too few points: all boxes of a set that fills intervals are counted only while a few points are
    expected in the least visited one. And coarse boxes are biased: a smooth curve has counts near a
    2^k + b, whose gains differ from 1 until b is small against a 2^k.
    """
    # D_k = log2 N(k + 1) - log2 N(k); the error of their mean is s/sqrt(n).
    gains = np.diff(np.log2(box_counts(points, range(first, last + 1))))
    error = float(np.std(gains, ddof=1)) / np.sqrt(len(gains))
    return float(np.mean(gains)), float(error)


def correlation_counts(points: Array, halvings: Sequence[int]) -> Array:
    """Numbers C(k) (K,) of pairs of points (N,) on a line, or (N, D), that are closer than 2^-k
    times the largest distance between any two, for each number k of halvings.

    The distance is that of the maximum norm. Coinciding points are counted as a pair.
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
    # distance = m 2^e with 1/2 <= m < 1, so that distance < 2^e. A distance of 0 gets the least e.
    mantissa, exponents = np.frexp(distance)
    exponents[mantissa == 0] = np.iinfo(np.int32).min
    is_later = np.arange(len(part) - begin) > np.arange(end - begin)[:, None]
    return exponents[is_later].astype(np.int64)


def correlation_dimension(points: Array, first: int, last: int) -> tuple[float, float]:
    """The mean of log2 C(k) - log2 C(k + 1) from `first` to `last` halvings, and its standard error
    from its spread over the halvings and from the numbers of pairs; C(k) counts the pairs closer
    than 2^-k (Grassberger and Procaccia 1983).

    The spread includes the unevenness of a set that is self-similar with a ratio other than 2. The
    mean is (log2 C(first) - log2 C(last))/(last - first), so that the counting errors 1/sqrt(C) of
    ln C at both ends contribute. The error does not include two systematic errors. At large
    distances points near the ends of a set have fewer neighbours, a relative error of about 2^-k of
    a gain. And an inverse square root singularity of the density, as a map with a smooth maximum
    has it, makes C proportional to r log(1/r), so that gains approach 1 only as 1 - 1/log(1/r).
    """
    counts = correlation_counts(points, range(first, last + 1))
    gains = -np.diff(np.log2(counts))
    spread = float(np.std(gains, ddof=1)) / np.sqrt(len(gains))
    # log2 C has the counting error 1/(sqrt(C) ln 2).
    of_ends = np.sqrt(1 / counts[0] + 1 / counts[-1]) / np.log(2)
    error = float(np.hypot(spread, of_ends / len(gains)))
    return float(np.mean(gains)), error
