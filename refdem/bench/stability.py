"""The largest stable step of a method, by bisection: the run stays bounded for many steps."""

import numpy as np

from refdem.bench.entrant import Entrant
from refdem.core.problem import Motion
from refdem.core.stability import BEYOND, excess, probe
from refdem.errors import RefdemError

FIRST = 1 / 8
"""Shortest step tried, as a multiple of 2/omega: explicit methods of practice are stable there."""
LAST = 16.0
"""Longest step tried, as a multiple of 2/omega: a method stable there counts as stable for all."""
BISECTIONS = 12
"""Halvings of the interval that holds the limit: 2^-12 of it is finer than the three digits shown.
"""


def stability_limit(entrant: Entrant) -> tuple[float | None, str]:
    """The limit as a multiple of 2/omega = 2 tau and a note; infinite if no step up to LAST is
    unstable; None if the method has none.

    Where the shortest multiple is unstable already the limit is 0.
    """
    if entrant.method.control != "step" or not isinstance(entrant.instance.problem, Motion):
        return None, ""
    if not _is_stable(entrant, FIRST):
        return 0.0, f"unstable at {FIRST:g} x 2/omega already"
    low = FIRST
    while low < LAST and _is_stable(entrant, 2 * low):
        low *= 2
    if low >= LAST:
        return float("inf"), f"stable up to {LAST:g} x 2/omega"
    high = 2 * low
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if _is_stable(entrant, middle):
            low = middle
        else:
            high = middle
    return low, ""


def _is_stable(entrant: Entrant, multiple: float) -> bool:
    """Whether many steps of multiple * 2 tau stay within BEYOND times the scales; an engine that
    gives up is not stable.
    """
    problem = probe(entrant.instance, multiple)
    try:
        with np.errstate(all="ignore"):
            run, _ = entrant.engine.run(entrant.request(problem.interval, problem))
    except (RefdemError, ArithmeticError):
        return False
    return excess(entrant.instance, run) <= BEYOND
