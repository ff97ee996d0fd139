"""Stability in dynamics (1.131)-(1.133): neighbours part as a power of the time, or exponentially;
from how far apart they are.

Lyapunov unstable is what diverges as C exp(lambda t), lambda > 0 (1.133); stable what stays below a
power of the time span (1.132).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCKS = 8
"""Parts of the time in each of which an exponent is taken: their scatter is the error bar of the
mean.
"""
LARGEST_POWER = 2.0
"""Neighbours of regular motions part as t (other frequencies, free flight), in a resonance or a
free fall as t^2.
"""


@dataclass(frozen=True)
class Growth:
    """Exponent [1/time] with its standard error, and the power that growth over the second half of
    the time would be.
    """

    exponent: float
    error: float
    power: float

    def is_exponential(self, errors: float = 3.0) -> bool:
        """Faster than LARGEST_POWER between the middle and the end, and positive by so many
        standard errors.
        """
        return self.power > LARGEST_POWER and self.exponent > errors * self.error


def growth(t: Array, separation: Array) -> Growth:
    """How the separation (T,) of two neighbours grows with the times t (T,) since they were
    `separation[0]` > 0 apart.

    The largest separation so far counts: (1.131) and (1.132) bound it, and what oscillates has no
    other limit. The power is log(d(T)/d(T/2))/log 2, as if d ~ t^p held between.
    """
    since = t - t[0]
    logarithm = np.log(np.maximum.accumulate(separation) / separation[0])
    ends = np.interp(np.linspace(0.0, since[-1], BLOCKS + 1), since, logarithm)
    rates = np.diff(ends) * BLOCKS / since[-1]
    half = float(np.interp(since[-1] / 2, since, logarithm))
    over_second_half = float(logarithm[-1]) - half
    return Growth(
        exponent=float(rates.mean()),
        error=float(rates.std(ddof=1) / np.sqrt(BLOCKS)),
        power=over_second_half / float(np.log(2.0)),
    )
