"""Period doubling of the logistic map x -> eta x (1 - x): cycles, the parameters at which the
period doubles, and the distribution of the iterates at eta = 4.

With w = eta (1/2 - x) the map is w -> w^2 + c, where c = eta/2 - eta^2/4, or eta = 1 + sqrt(1 - 4
c). A cycle of p iterates is superstable where w = 0 is one of them, and its period doubles where
its multiplier (f^p)'(w) is -1.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SUPERSTABLE = (0.0, -1.0, -1.3107)
"""About the c at which cycles of 1, 2 and 4 iterates are superstable."""
FOLLOWED = 64
"""Values of the multiplier, from 0 to -1, through which a cycle is followed by Newton's method."""


def two_cycle(eta: float) -> Array:
    """The two iterates (2,), larger first, between which the map alternates, for eta > 3.

    They are (eta + 1 +- sqrt((eta - 3)(eta + 1)))/(2 eta).
    """
    root = np.sqrt((eta - 3) * (eta + 1))
    return np.array([eta + 1 + root, eta + 1 - root]) / (2 * eta)


def share_below(x: float) -> float:
    """The share of the iterates of the map at eta = 4 that are below x in [0, 1], over a long time
    and for almost every start: 2/pi asin(sqrt x).

    With x = sin^2(pi u/2) the map is u -> 1 - |2 u - 1|, which keeps a uniform u (Ulam and von
    Neumann 1947).
    """
    return float(2 / np.pi * np.arcsin(np.sqrt(x)))


def doubling_point(doublings: int) -> float:
    """The eta at which the period doubles for the next time after `doublings` (0, 1 or 2): 3, 1 +
    sqrt 6, 3.54409.
    """
    period = 2**doublings
    w = 0.0
    c = SUPERSTABLE[doublings]
    for multiplier in np.linspace(0.0, -1.0, FOLLOWED):
        w, c = _cycle(w, c, period, float(multiplier))
    # c = eta/2 - eta^2/4.
    return float(1 + np.sqrt(1 - 4 * c))


def _cycle(w: float, c: float, period: int, multiplier: float) -> tuple[float, float]:
    """The iterate w and the parameter c near the given ones at which the cycle has the multiplier:
    Newton's method for f^p(w) = w, (f^p)'(w) = multiplier.
    """
    for _ in range(8):
        residual, derivatives = _residual(w, c, period, multiplier)
        step_w, step_c = np.linalg.solve(derivatives, residual)
        w -= float(step_w)
        c -= float(step_c)
    return w, c


def _residual(w: float, c: float, period: int, multiplier: float) -> tuple[Array, Array]:
    """The residuals f^p(w) - w and (f^p)'(w) - multiplier (2,), and their derivatives (2, 2) by w
    and c.
    """
    image = w
    by_w = 1.0
    by_c = 0.0
    by_ww = 0.0
    by_wc = 0.0
    for _ in range(period):
        # For y <- y^2 + c: y_ww <- 2 (y_w^2 + y y_ww), y_wc <- 2 (y_w y_c + y y_wc), y_w <- 2 y
        # y_w, y_c <- 2 y y_c + 1.
        by_ww = 2 * (by_w * by_w + image * by_ww)
        by_wc = 2 * (by_w * by_c + image * by_wc)
        by_w = 2 * image * by_w
        by_c = 2 * image * by_c + 1
        image = image * image + c
    residual = np.array([image - w, by_w - multiplier])
    derivatives = np.array([[by_w - 1, by_c], [by_ww, by_wc]])
    return residual, derivatives
