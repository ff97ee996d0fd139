"""Errors of engines against certified truth, observed orders, and the period of a pendulum."""

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import pairwise

from refdem.core import discovery
from refdem.core.engine import Engine, Method
from refdem.core.problem import Request


def largest_error(
    engine: Engine, method: Method, case: str, given: Mapping[str, str], steps: int
) -> float:
    """The largest error of any quantity in units of its scale, with this many steps a sample."""
    instance = discovery.case(case).at(samples="8", **given)
    assert engine.unsupported_motion(instance.motion, method) is None
    step = instance.problem.interval / steps
    run, _ = engine.run(Request(problem=instance.problem, method=method.name, step=step))
    observed = instance.observe(run)
    truth = instance.truth()
    largest = 0.0
    for row, t in enumerate(instance.problem.times):
        certified = truth.at(Fraction(float(t)))
        for name, quantity in instance.quantities.items():
            error = abs(observed[name][row] - float(certified[name].mid)) / quantity.scale
            largest = max(largest, error)
    return largest


def orders(errors: Iterable[float]) -> list[float]:
    """Observed order of each pair of neighbours whose step halves."""
    return [math.log2(coarse / fine) for coarse, fine in pairwise(errors)]


def agm(a: float, b: float) -> float:
    """Arithmetic-geometric mean; pi/(2 agm(1, k')) is the complete elliptic integral K(k)."""
    while abs(a - b) > 1e-15 * a:
        mean = (a + b) / 2
        b = math.sqrt(a * b)
        a = mean
    return a
