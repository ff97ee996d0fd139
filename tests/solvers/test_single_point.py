"""Motions of any pace: a kernel with series of high order is told them in a unit of time of their
own.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.symmetry import Symmetry
from refdem.engines.reference import ENGINE
from refdem.solvers._single_point import time_unit


@pytest.mark.parametrize(
    ("method", "case", "ordinary", "other", "seconds", "metres"),
    [
        (
            "stick-slip",
            "coulomb-oscillator",
            {"mass": "1"},
            {"mass": str(2.0**-112)},
            2.0**-56,
            1.0,
        ),
        ("stick-slip", "coulomb-oscillator", {"mass": "1"}, {"mass": str(2.0**112)}, 2.0**56, 1.0),
        ("rod-taylor", "pendulum", {"gravity": "1"}, {"gravity": str(2.0**-100)}, 2.0**50, 1.0),
        ("rod-taylor", "pendulum", {"gravity": "1"}, {"gravity": str(2.0**100)}, 2.0**-50, 1.0),
    ],
)
def test_the_same_motion_at_another_pace_has_the_same_numbers(
    method, case, ordinary, other, seconds, metres
):
    def run(given, duration):
        problem = discovery.case(case).at(**given, duration=str(duration), samples="16").problem
        trajectory, _ = ENGINE.run(Request(problem=problem, method=method, step=None))
        return trajectory

    slow = run(ordinary, 8.0)
    fast = run(other, 8.0 * seconds)
    assert np.max(np.abs(fast.position - slow.position * metres)) <= 1e-13 * metres
    assert np.max(np.abs(fast.velocity * seconds - slow.velocity * metres)) <= 1e-13 * metres
    assert len(slow.events) == len(fast.events)
    for one, same in zip(slow.events, fast.events, strict=True):
        assert same.time / seconds == pytest.approx(one.time, rel=1e-12)


@pytest.mark.parametrize("pace", [2.0**-56, 2.0**56])
@pytest.mark.parametrize(
    ("method", "case", "given"),
    [
        ("stick-slip", "stick-slip", {"x0": "3", "v0": "-2"}),
        ("stick-slip", "stick-slip", {"friction_law": "linear", "gamma": "2", "eta": "5/4"}),
        ("stick-slip", "stick-slip", {"belt": "-1/2", "gamma": "3", "lambda1": "1/8"}),
        ("rod-taylor", "pendulum", {"thetadot0": "1/2"}),
    ],
)
def test_every_number_of_a_scene_is_told_in_the_unit_of_its_pace(method, case, given, pace):
    """Quotients by a power of two are exact: only what the kernel's own unit rounds may differ."""
    motion = discovery.case(case).at(**given, duration="6", samples="16").problem
    paced = Symmetry(units=(1.0, 1.0, pace))
    plain, _ = ENGINE.run(Request(problem=motion, method=method))
    mapped, _ = ENGINE.run(Request(problem=paced.applied(motion), method=method))
    undone = paced.undone(mapped)
    assert np.max(np.abs(undone.position - plain.position)) <= 1e-13
    assert np.max(np.abs(undone.velocity - plain.velocity)) <= 1e-13


@pytest.mark.parametrize(
    ("times", "unit"),
    [([1.0], 1.0), ([1e-5, 1e30], 1.0), ([0.0, float("inf")], 1.0), ([1e-18, 1.0], 2.0**-60)],
)
def test_the_unit_is_a_second_unless_a_motion_is_very_fast_or_very_slow(times, unit):
    assert time_unit(times) == unit
