"""Late iterates of the logistic map over its parameter (1.127)."""

import numpy as np

from refdem.core.maps import Logistic
from refdem.core.problem import DENSE, Iteration
from refdem.gallery.runs import Array, answer, command, instance, remember
from refdem.mechanics.poincare import distinct

SETTLED = 4096
START = 0.3


def late(eta: float, chunks: int = 1) -> Array:
    """So many times 129 iterates in turn, after SETTLED others."""
    found = []
    x = last(eta, START, SETTLED)
    for _ in range(chunks):
        found.append(answer(Iteration(Logistic(eta=eta), np.array([x]), DENSE)).values["x"])
        x = float(found[-1][-1])
    return np.concatenate(found)


def last(eta: float, x0: float, n: int) -> float:
    """Iterate n."""
    return float(answer(Iteration(Logistic(eta=eta), np.array([x0]), n)).values["x"][-1])


def period(eta: float, tolerance: float = 1e-7) -> int:
    """How many values the settled iterates go through."""
    return distinct(late(eta), tolerance)


def doubling(periods: int, low: float, high: float) -> float:
    """Where the period passes `periods`, by halving of [low, high] until an orbit no longer settles
    in SETTLED iterates.
    """
    while high - low > 2e-5:
        middle = (low + high) / 2
        low, high = (middle, high) if period(middle, 2e-3 / periods) <= periods else (low, middle)
    return (low + high) / 2


def shown(eta: str) -> None:
    """Remembers one of the orbits."""
    remember(command(instance("logistic", eta=eta)))
