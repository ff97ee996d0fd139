"""Period doubling of the logistic map: cycles close, and settle on twice as many iterates."""

import numpy as np
import pytest

from refdem.mechanics.period_doubling import doubling_point, share_below, two_cycle

POINTS = (3.0, 1 + 6**0.5, 3.5440903595519228)


def iterated(eta: float, x: float, count: int) -> float:
    for _ in range(count):
        x = eta * x * (1 - x)
    return x


@pytest.mark.parametrize("eta", [3.0001, 3.2, 4.0])
def test_the_map_alternates_between_the_iterates_of_a_cycle_of_two(eta: float) -> None:
    high, low = two_cycle(eta)
    assert high > low
    assert iterated(eta, high, 1) == pytest.approx(low, abs=1e-15)
    assert iterated(eta, low, 1) == pytest.approx(high, abs=1e-15)


@pytest.mark.parametrize("doublings", [0, 1, 2])
def test_doubling_points_are_the_known_ones(doublings: int) -> None:
    assert doubling_point(doublings) == pytest.approx(POINTS[doublings], abs=2e-15)


@pytest.mark.parametrize("doublings", [0, 1, 2])
def test_next_to_a_doubling_the_map_settles_on_the_shorter_cycle_and_beyond_on_the_longer(
    doublings: int,
) -> None:
    period = 2**doublings
    for factor, expected in ((1 - 1e-3, period), (1 + 1e-3, 2 * period)):
        eta = doubling_point(doublings) * factor
        settled = iterated(eta, 0.3, 100_000)
        later = np.array([iterated(eta, settled, count) for count in (period, 2 * period)])
        closes = np.abs(later - settled) < 1e-9
        assert closes.tolist() == [expected == period, True]


def test_shares_at_eta_4_are_those_of_many_iterates():
    x = 0.1234
    values = []
    for _ in range(20000):
        x = 4 * x * (1 - x)
        values.append(x)
    for place in (0.1, 0.25, 0.5, 0.9):
        share = sum(value < place for value in values) / len(values)
        assert share == pytest.approx(share_below(place), abs=0.01)
