"""Stability of a motion (1.131)-(1.133), from the separation of two neighbouring trajectories.

A motion is unstable in Lyapunov's sense if the separation grows as C exp(lambda t), lambda > 0
(1.133), and stable if it stays below a power of time (1.132).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCKS = 8
"""Equal parts of the time, each with its own exponent; their scatter is the standard error of the
mean.
"""
LARGEST_POWER = 2.0
"""Largest power of time with which neighbours separate in regular motions: t for different
frequencies or in free flight, t^2 in a resonance or free fall.
"""


@dataclass(frozen=True)
class Growth:
    """Exponent [1/time] with its standard error, and the power of time that would give the growth
    over the second half.
    """

    exponent: float
    error: float
    power: float

    def is_exponential(self, errors: float = 3.0) -> bool:
        """True if the growth over the second half is faster than t^LARGEST_POWER, and the exponent
        positive by so many standard errors.
        """
        return self.power > LARGEST_POWER and self.exponent > errors * self.error


def growth(t: Array, separation: Array) -> Growth:
    """Growth of the separation (T,) of two neighbours with time t (T,), relative to `separation[0]`
    > 0.

    The running maximum d(t) of the separation is used, because (1.131) and (1.132) bound it, while
    the logarithm of an oscillating separation has no limit. The exponent is the mean of d(ln d)/dt
    over the blocks. The power is p = log(d(T)/d(T/2))/log 2, from d ~ t^p in the second half.
    """
    since = t - t[0]
    # ln of the largest separation so far.
    logarithm = np.log(np.maximum.accumulate(separation) / separation[0])
    log_at_block_ends = np.interp(np.linspace(0.0, since[-1], BLOCKS + 1), since, logarithm)
    # The exponent of each block; their mean is the exponent, their scatter its error.
    rates = np.diff(log_at_block_ends) * BLOCKS / since[-1]
    # p = log2(d(T)/d(T/2)).
    log_at_half = float(np.interp(since[-1] / 2, since, logarithm))
    over_second_half = float(logarithm[-1]) - log_at_half
    return Growth(
        exponent=float(rates.mean()),
        error=float(rates.std(ddof=1) / np.sqrt(BLOCKS)),
        power=over_second_half / float(np.log(2.0)),
    )
