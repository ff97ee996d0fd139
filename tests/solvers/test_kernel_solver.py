"""What all methods that are one call of a kernel have in common."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.selection import Selection
from refdem.engines.reference import ENGINE
from refdem.kernels import repeated
from refdem.solvers._free_bodies import FreeBodies
from refdem.solvers._kernel_solver import KernelRun


def answers():
    """Every method of this kind, and the first problem that it answers of all cases."""
    found = {}
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if isinstance(case, Selection):
            continue
        problem = case.at().problem
        for solver in ENGINE.solvers.values():
            is_call = isinstance(solver, KernelRun | FreeBodies)
            if is_call and ENGINE.unsupported(problem, solver.claims) is None:
                found.setdefault(solver.claims.name, problem)
    return sorted(found.items())


@pytest.mark.parametrize(("method", "problem"), answers())
def test_a_kernel_that_is_asked_twice_answers_the_same_bits(method, problem):
    step = None
    if ENGINE.method(method).control == "step":
        # So small that no motion diverges.
        step = abs(problem.interval) / 256
    request = Request(problem=problem, method=method, step=step)
    once, _ = ENGINE.run(request)
    with repeated(2):
        twice, cost = ENGINE.run(request)
    for name, values in once.columns().items():
        assert np.array_equal(values, twice.columns()[name]), name
    for name, values in once.channels.items():
        assert np.array_equal(values, twice.channels[name]), name
    assert once.events == twice.events
    assert cost.seconds >= 0.0
    assert cost.setup >= 0.0
