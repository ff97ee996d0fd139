"""Errors of engines against certified truth, observed orders, and the period of a pendulum."""

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import pairwise

from refdem.core import discovery
from refdem.core.engine import Engine, Method
from refdem.core.problem import Request
from refdem.scene.force_rows import CENTRAL, DASHPOT, DRIVE, PIECEWISE, SPRING

STRENGTHS = {DRIVE: (0,), SPRING: (0, 6, 7), DASHPOT: (0, 1), CENTRAL: (0,), PIECEWISE: (0, 1)}
"""Columns of the row of each kind of force that the force is proportional to."""


def misread(numbers: Iterable[float], columns: Iterable[int], factor: float) -> tuple[float, ...]:
    """The numbers with some columns multiplied by a factor."""
    wrong = list(numbers)
    for column in columns:
        wrong[column] *= factor
    return tuple(wrong)


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
