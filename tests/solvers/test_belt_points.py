"""Points of sections by the solver of the belt: where v is exactly 0 at a sample or at the start,
and where there are none.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.solvers import _belt_points

GLIDING = (
    np.array([1.0, 0.5, 0.5, 0.0, 0.0]),
    np.array([1.0]),
    np.array([10.0, 0.0, 2.0]),
)
"""Friction that balances the steady pull at every speed below that of the belt: x'' = -x."""


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_start_with_v_zero_is_no_passage_and_a_sample_with_v_zero_is_one(n):
    """Passages at 2 pi n lie on samples, which are a whole part of a period of pi."""
    found = _belt_points.passage(*GLIDING, np.array([1.0, 0.0]), np.array([n]))
    np.testing.assert_allclose(found, [2 * np.pi * n, 1.0], rtol=1e-14)


def test_a_passage_in_the_first_step_is_seen():
    early = 1e-4
    start = np.array([np.cos(early), np.sin(early)])
    found = _belt_points.passage(*GLIDING, start, np.array([1]))
    np.testing.assert_allclose(found, [early, 1.0], rtol=0, atol=1e-14)


def test_a_passage_where_v_rises_counts_where_x_is_positive():
    """Under a force of 3 at t = 0 a mass at x = 1 turns upward."""
    friction, power, _ = GLIDING
    driven = np.array([10.0, 3.0, 0.25])
    time, place = _belt_points.passage(
        friction, power, driven, np.array([1.0, -0.1]), np.array([1])
    )
    assert 0 < time < 0.06
    assert 0.99 < place < 1


def test_a_motion_that_does_not_come_to_the_section_has_no_passage():
    creeping = np.array([10.0, 0.5, 0.5, 0.0, 1.0])
    _, power, drive = GLIDING
    start = np.array([-1.0, 0.0])
    assert _belt_points.passage(creeping, power, drive, start, np.array([1])) is None


def test_a_passage_that_does_not_come_is_undecided_and_no_error():
    # The belt carries the mass along for longer than 16 periods.
    instance = discovery.case("poincare-sections").at(a="4920", mu0="37")
    task = task_of(
        discovery.engine("reference"), "rotation-algebra", instance, truth_of(instance), 4
    )
    outcomes = {finding.outcome for finding in record_of(task).findings}
    assert "undecided" in outcomes
    assert not outcomes & {"fail", "error"}
