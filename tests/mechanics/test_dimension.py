"""Box dimensions of sets that have one on paper, and of two return maps: that of the stick-slip
oscillator fills intervals, that of the logistic map at the end of its doublings is a fractal.
"""

import numpy as np
import pytest

from refdem.gallery.belt import section
from refdem.mechanics.dimension import box_counts, box_dimension

RNG = np.random.default_rng(38)
COUNT = 2**16
ACCUMULATION = 3.569945671870945
"""eta at which the logistic map has doubled its period without end (Feigenbaum 1978)."""
FEIGENBAUM_SET = 0.538045
"""Dimension of the set that it then visits (Grassberger 1981)."""


def logistic(eta: float, count: int) -> np.ndarray:
    """So many iterates after 2^16 others."""
    x = 0.3
    found = []
    for number in range(2**16 + count):
        x = eta * x * (1 - x)
        if number >= 2**16:
            found.append(x)
    return np.array(found)


def test_boxes_are_counted_once() -> None:
    points = np.array([0.0, 0.1, 0.3, 0.9, 1.0])
    assert box_counts(points, [0, 1, 2, 3]).tolist() == [1, 2, 3, 3]


def test_an_interval_has_dimension_one_and_a_cycle_zero() -> None:
    assert box_dimension(RNG.uniform(size=COUNT), 2, 11) == (1.0, 0.0)
    assert box_dimension(RNG.integers(5, size=COUNT) / 7.0, 4, 11) == (0.0, 0.0)


def test_cantors_set_has_dimension_ln_2_over_ln_3() -> None:
    digits = 2 * RNG.integers(2, size=(COUNT, 30))
    points = digits @ 3.0 ** -np.arange(1, 31)
    value, error = box_dimension(points, 2, 16)
    assert abs(value - np.log(2) / np.log(3)) < 3 * error
    assert error < 0.06


def test_the_return_map_of_the_logistic_map_is_a_fractal() -> None:
    value, error = box_dimension(logistic(ACCUMULATION, COUNT), 4, 16)
    assert abs(value - FEIGENBAUM_SET) < 3 * error
    assert error < 0.06
    assert box_dimension(logistic(4.0, COUNT), 2, 8) == (1.0, 0.0)
    assert box_dimension(logistic(3.5, COUNT), 4, 16) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("eta", "given", "regime", "rate"),
    [
        (1.22, {"gamma": "2", "friction_law": "linear"}, "chaotic", 0.086),
        (1.22, {}, "quasi-periodic", 0.0),
    ],
)
def test_that_of_the_stick_slip_oscillator_fills_an_interval(eta, given, regime, rate) -> None:
    """Every box holds a point; two chaotic motions part at the rate 0.086 1/s."""
    passages = section(np.array([eta]), skip=200, keep=2**14, **given)
    assert passages.exponent.regimes().tolist() == [regime]
    assert passages.exponent.value[0] == pytest.approx(rate, abs=0.002)
    (places,) = passages.places
    assert box_dimension(places, 2, 8) == (1.0, 0.0)
