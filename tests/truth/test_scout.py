"""A scout's steps are as long as the series of the motion allow, and its clock counts them."""

from math import log, pi

import pytest
from flint import arb

from refdem.truth.scout import ORDER, RATIO, Scout
from refdem.truth.traced_field import Program, traced
from refdem.truth.weights import ABOVE_QUICKEST, MAX_DISC_EXPONENT


def scout_of(field, start):
    outputs, rows = traced(field, len(start))
    slopes = Program([entry for row in rows for entry in row])
    return Scout(Program(outputs), slopes, [arb(value) for value in start], 0.0, range(len(start)))


def test_a_step_is_a_part_of_the_distance_to_a_pole():
    """y' = y^2 from 1 is 1/(1 - t): from t the radius of convergence is 1 - t. The estimate has
    the factor n^(-1/(n - 1)) of a pole of second order, which y' has.
    """
    scout = scout_of(lambda y: [y[0] * y[0]], [1])
    scout.go_on(5, 1.0)
    left = [1 - t for t in scout.times]
    lengths = [b - a for a, b in zip(scout.times, scout.times[1:], strict=False)]
    assert len(lengths) == 5
    parts = [length / distance for length, distance in zip(lengths, left[:-1], strict=True)]
    assert parts == pytest.approx([RATIO * ORDER ** (-1 / (ORDER - 1))] * 5, rel=0.02)


def test_a_step_is_a_part_of_the_widest_disc_that_a_proof_looks_for():
    """A harmonic motion beside y' = -60 y at rest: |J| R <= MAX_DISC_EXPONENT, though the series
    goes much further.
    """
    scout = scout_of(lambda y: [y[1], -y[0], -60 * y[2]], [1, 0, 0])
    assert scout.widest_disc() == pytest.approx(MAX_DISC_EXPONENT / (60 * ABOVE_QUICKEST))
    scout.advance()
    assert scout.times[1] == pytest.approx(RATIO * scout.widest_disc())


def test_a_clock_stands_still_beyond_a_singularity():
    scout = scout_of(lambda y: [y[0] * y[0]], [1])
    scout.go_on(1000, 2.0)
    assert scout.is_singular
    assert scout.times[-1] == pytest.approx(1.0)
    assert len(scout.times) < 100
    assert scout.clock(5.0) == scout.clock(2.0) == len(scout.times) - 1


def test_a_harmonic_motion_has_even_steps_and_is_followed():
    scout = scout_of(lambda y: [y[1], -y[0]], [1, 0])
    scout.go_on(1000, 2 * pi)
    assert scout.times[-2] < 2 * pi <= scout.times[-1]
    lengths = [b - a for a, b in zip(scout.times, scout.times[1:], strict=False)]
    assert max(lengths) < 1.5 * min(lengths)
    assert float(scout.y[0] ** 2 + scout.y[1] ** 2) == pytest.approx(1.0, abs=1e-6)


def test_the_clock_counts_steps_and_goes_on_at_their_pace():
    scout = scout_of(lambda y: [y[1], -y[0]], [1, 0])
    scout.times = [0.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    assert [scout.clock(t) for t in (0.0, 2.0, 4.0, 6.5, 8.0)] == [0.0, 0.5, 1.0, 3.5, 5.0]
    # Four steps in the later half, from 4 to 8 s.
    assert scout.clock(18.0) == pytest.approx(15.0)


def test_a_motion_at_rest_has_no_steps_and_time_is_its_clock():
    scout = scout_of(lambda y: [-y[0]], [0])
    scout.go_on(10, 1.0)
    assert scout.ended
    assert scout.times == [0.0]
    assert scout.clock(3.0) == 3.0


def test_a_series_that_is_not_finite_ends_the_scout():
    scout = scout_of(lambda y: [1 / y[0]], [0])
    scout.go_on(10, 1.0)
    assert scout.ended
    assert scout.times == [0.0]


def test_a_neighbour_swells_as_errors_do():
    """Errors of y'' = y grow as exp(t) and those of y'' = -y stay; a coordinate that is not
    displaced swells nothing, though its own errors would.
    """
    growing = scout_of(lambda y: [y[1], y[0]], [1, 1])
    growing.go_on(1000, 20.0)
    assert growing.swelling(growing.clock(20.0)) == pytest.approx(20 / log(2), rel=0.01)
    turning = scout_of(lambda y: [y[1], -y[0]], [1, 0])
    turning.go_on(1000, 20.0)
    assert abs(turning.swelling(turning.clock(20.0))) < 1
    outputs, rows = traced(lambda y: [y[1], -y[0], y[2]], 3)
    slopes = Program([entry for row in rows for entry in row])
    apart = Scout(Program(outputs), slopes, [arb(1), arb(0), arb(1)], 0.0, (0, 1))
    apart.go_on(1000, 20.0)
    assert abs(apart.swelling(apart.clock(20.0))) < 1
