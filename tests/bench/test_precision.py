"""Order, constant and time to an error from points that were made up."""

import pytest

from refdem.bench import precision
from refdem.bench.record import Point


def points(*rows: tuple[float, float, float]) -> list[Point]:
    """Points from (level, error, seconds), three equal rounds."""
    return [Point(level=level, error=error, rounds=[seconds] * 3) for level, error, seconds in rows]


def test_the_time_to_an_error_lies_on_a_line_between_logarithms() -> None:
    curve = points((1e-1, 1e-2, 1.0), (1e-2, 1e-4, 10.0))
    found = precision.reach(curve, 1e-3)
    assert found is not None
    assert found.seconds == pytest.approx(10**0.5, rel=1e-12)


def test_an_error_that_no_point_meets_is_not_reached() -> None:
    assert precision.reach(points((1e-1, 1e-2, 1.0), (1e-2, 1e-4, 10.0)), 1e-5) is None


def test_a_first_point_that_meets_the_error_stands_for_itself() -> None:
    found = precision.reach(points((0.0, 1e-15, 2e-5)), 1e-3)
    assert found is not None
    assert found.seconds == 2e-5


def test_the_least_and_the_most_of_the_rounds_are_kept_beside_the_median() -> None:
    found = precision.reach([Point(level=0.0, error=0.0, rounds=[3.0, 1.0, 2.0])], 1e-12)
    assert found is not None
    assert (found.least, found.seconds, found.most) == (1.0, 2.0, 3.0)


def test_the_error_in_a_time_lies_on_a_line_between_logarithms() -> None:
    curve = points((1e-1, 1e-2, 1.0), (1e-2, 1e-4, 10.0))
    assert precision.error_within(curve, 10**0.5) == pytest.approx(1e-3, rel=1e-12)
    assert precision.error_within(curve, 10.0) == 1e-4


def test_a_time_shorter_than_every_run_buys_no_error() -> None:
    assert precision.error_within(points((1e-1, 1e-2, 1.0)), 0.5) is None


def test_more_time_than_the_finest_level_takes_buys_the_least_error() -> None:
    curve = points((0.4, 1e-2, 1.0), (0.2, 1e-15, 2.0), (0.1, 3e-15, 4.0))
    assert precision.error_within(curve, 3.0) == 1e-15
    assert precision.error_within(curve, 100.0) == 1e-15


@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_order_and_the_constant_of_a_power_law_are_found(order: int) -> None:
    tau = 0.5
    duration = 10.0
    levels = [0.1 / 4**k for k in range(4)]
    curve = points(
        *((h, 0.007 * (1 + duration / tau) * (h / tau) ** order, 1.0 / h) for h in levels)
    )
    # sharp: made-up numbers that involve no rounding of a run
    curve = [point for point in curve if point.error > 1e-12]
    assert precision.order(curve) == pytest.approx(order, rel=1e-9)
    assert precision.constant(curve, claimed=order, tau=tau, duration=duration) == pytest.approx(
        0.007, rel=1e-9
    )


def test_levels_at_the_floor_of_round_off_do_not_count_for_the_order() -> None:
    curve = points((0.4, 1.6e-5, 1.0), (0.2, 1e-6, 2.0), (0.1, 3e-14, 4.0), (0.05, 1e-15, 8.0))
    assert precision.order(curve) == pytest.approx(4.0, rel=1e-12)


def test_time_in_proportion_to_steps_grows_with_exponent_one() -> None:
    assert precision.growth("steps", [10, 100, 1000], [1e-5, 1e-4, 1e-3]).exponent == pytest.approx(
        1.0
    )
    assert precision.growth("bodies", [10, 100], [1.0, 100.0]).exponent == pytest.approx(2.0)
    assert precision.growth("bodies", [10], [1.0]).exponent is None
