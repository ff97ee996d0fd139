"""Lorenz' equations in C: against plain Python, the fate of every start below rho = 1, and what the
method refuses.
"""

import numpy as np
import pytest

from refdem.core.maps import Logistic, LorenzFlow
from refdem.core.problem import Iteration, Request
from refdem.engines.reference import ENGINE
from refdem.errors import EngineError
from refdem.faults.iterating import CORRECT_MAPS, iterated

METHOD = "lorenz-taylor"
START = np.array([3.0, -2.0, 15.0])


def flow(**changed):
    """Lorenz' own numbers, seen every quarter of a unit of time, but for what is changed."""
    numbers = {"sigma": 10.0, "rho": 28.0, "beta": 8 / 3, "interval": 0.25}
    return LorenzFlow(**{**numbers, **changed})


def states(problem):
    """The states (T, 3) by the reference."""
    run, _ = ENGINE.run(Request(problem=problem, method=METHOD))
    return run.values["state"]


@pytest.mark.parametrize(
    "changed", [{}, {"rho": 14.0}, {"rho": 0.5, "interval": 1.0}, {"sigma": 16.0, "interval": 0.01}]
)
def test_the_kernel_is_what_plain_python_gives(changed):
    problem = Iteration(flow(**changed), START, 16)
    plain = iterated(problem, CORRECT_MAPS).values["state"]
    assert np.allclose(states(problem), plain, rtol=0, atol=1e-10)


def test_many_short_intervals_come_to_the_state_of_a_long_one():
    short = states(Iteration(flow(interval=1 / 64), START, 128))
    long = states(Iteration(flow(interval=1.0), START, 2))
    assert np.allclose(short[::64], long, rtol=0, atol=1e-12)


def test_iterate_zero_is_the_start():
    assert np.array_equal(states(Iteration(flow(), START, 3))[0], START)


def test_on_the_z_axis_only_the_decay_of_z_is_left():
    seen = states(Iteration(flow(), np.array([0.0, 0.0, 5.0]), 8))
    assert np.all(seen[:, :2] == 0.0)
    assert np.allclose(seen[:, 2], 5.0 * np.exp(-8 / 3 * 0.25 * np.arange(9)), rtol=1e-15)


def test_below_rho_1_every_motion_ends_at_the_origin():
    end = states(Iteration(flow(rho=0.5, interval=1.0), START, 64))[-1]
    assert np.max(np.abs(end)) < 1e-10


def test_the_equilibria_are_kept_while_they_are_stable():
    """At rho = 14 they are: a start beside one spirals into it."""
    height = 13.0
    across = np.sqrt(8 / 3 * height)
    end = states(Iteration(flow(rho=14.0), np.array([across + 0.5, across, height]), 1000))[-1]
    assert np.allclose(end, [across, across, height], rtol=0, atol=1e-12)


def test_a_start_so_far_out_that_no_step_is_short_enough_is_an_error():
    problem = Iteration(flow(), np.array([1e13, 1e13, 0.0]), 2)
    with pytest.raises(EngineError, match="stops converging before iterate 1"):
        states(problem)


def test_another_map_is_refused():
    problem = Iteration(Logistic(eta=2.0), np.array([0.5]), 3)
    assert "logistic is not the flow" in ENGINE.unsupported(problem, ENGINE.method(METHOD))
