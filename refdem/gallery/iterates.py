"""Late iterates of the logistic map over its parameter (1.127)."""

from typing import Any

import numpy as np

from refdem.core.maps import Logistic
from refdem.core.problem import DENSE, Iteration
from refdem.gallery.runs import Array, answer, command, instance, remember
from refdem.mechanics.poincare import distinct

SETTLED = 4096
"""Iterates before the picture begins: by then the map is on its attractor but near doublings."""
START = 0.3
"""First iterate, anywhere in the basin of the attractor."""


def late(eta: float, chunks: int = 1) -> Array:
    """The next `chunks` times 129 iterates, after SETTLED others."""
    orbits = []
    x = last(eta, START, SETTLED)
    for _ in range(chunks):
        orbit = iterates(eta, x, DENSE)
        orbits.append(orbit)
        x = float(orbit[-1])
    return np.concatenate(orbits)


def iterates(eta: float, x0: float, counts: Any) -> Array:
    """The iterates of x0 that the reference keeps of so many."""
    values: Array = answer(Iteration(Logistic(eta=eta), np.array([x0]), counts)).values["x"]
    return values


def last(eta: float, x0: float, n: int) -> float:
    """The iterate x_n of the logistic map from x0."""
    return float(iterates(eta, x0, n)[-1])


def period(eta: float, tolerance: float = 1e-7) -> int:
    """How many values the settled iterates go through."""
    return distinct(late(eta), tolerance)


def doubling(periods: int, low: float, high: float) -> float:
    """Where the period passes `periods`, by halving of [low, high] until an orbit no longer settles
    in SETTLED iterates.
    """
    while high - low > 2e-5:
        middle = (low + high) / 2
        if period(middle, 2e-3 / periods) <= periods:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def remember_run(eta: str) -> None:
    """Remembers the command of the orbit at one parameter."""
    remember(command(instance("logistic", eta=eta)))
