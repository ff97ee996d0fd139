"""Box and correlation dimensions of sets that have one on paper, and of two return maps: that of
the stick-slip oscillator fills intervals, and a curve of the plane, that of the logistic map at the
end of its doublings is a fractal.
"""

import numpy as np
import pytest

from refdem.gallery.belt import CHAOTIC, section
from refdem.mechanics.dimension import (
    box_counts,
    box_dimension,
    correlation_counts,
    correlation_dimension,
    return_map,
)

RNG = np.random.default_rng(38)
COUNT = 2**16
ACCUMULATION = 3.569945671870945
"""eta at which the logistic map has doubled its period without end (Feigenbaum 1978)."""
PAIRED = 2**13
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


def dust(base: int, digits: tuple[int, ...], places: int) -> np.ndarray:
    """All points of the plane whose coordinates have only these digits, so many of them."""
    line = np.zeros(1)
    for number in range(1, places + 1):
        steps = np.array(digits) / float(base) ** number
        line = (line[:, None] + steps).ravel()
    across, up = np.meshgrid(line, line)
    return np.column_stack((across.ravel(), up.ravel()))


def test_boxes_of_the_plane_are_counted_once() -> None:
    corners = np.array([[0.0, 0.0], [0.1, 5.0], [2.0, 0.2], [2.0, 8.0], [1.9, 7.9]])
    assert box_counts(corners, [0, 1, 2, 3]).tolist() == [1, 4, 4, 4]


def test_cantors_dust_has_dimension_2_ln_2_over_ln_3() -> None:
    value, error = box_dimension(dust(3, (0, 2), 9), 2, 10)
    assert abs(value - 2 * np.log(2) / np.log(3)) < 3 * error
    assert error < 0.08


def test_a_dust_that_keeps_four_corners_of_16_squares_has_dimension_one() -> None:
    points = dust(4, (0, 3), 8)
    # Every other halving only makes its boxes smaller: the gains are 2 and 0 in turns.
    assert box_counts(points, range(7)).tolist() == [1, 4, 4, 16, 16, 64, 64]
    value, error = box_dimension(points, 2, 14)
    assert value == 1.0
    assert error == pytest.approx(np.sqrt(1 / 11))


def test_a_curve_has_dimension_one_and_an_area_two() -> None:
    angle = RNG.uniform(0, 2 * np.pi, COUNT)
    circle = np.column_stack((3 * np.cos(angle), np.sin(angle)))
    value, error = box_dimension(circle, 5, 9)
    assert abs(value - 1) < 3 * error < 0.05
    value, error = box_dimension(RNG.uniform(size=(COUNT, 2)), 1, 6)
    assert (value, error) == (2.0, 0.0)


def test_kochs_curve_has_dimension_ln_4_over_ln_3() -> None:
    ends = np.array([0.0 + 0.0j, 1.0 + 0.0j])
    for _ in range(9):
        parts = np.diff(ends) / 3
        peak = parts * np.exp(1j * np.pi / 3)
        corners = [ends[:-1], ends[:-1] + parts, ends[:-1] + parts + peak, ends[:-1] + 2 * parts]
        ends = np.append(np.column_stack(corners).ravel(), 1.0)
    value, error = box_dimension(np.column_stack((ends.real, ends.imag)), 3, 9)
    assert abs(value - np.log(4) / np.log(3)) < 3 * error
    assert error < 0.05


def test_the_plane_sees_the_fractal_that_the_line_does() -> None:
    # The points (x, next x) lie on the parabola of the map, and neither adds a dimension.
    value, error = box_dimension(return_map(logistic(ACCUMULATION, COUNT)), 4, 14)
    assert abs(value - FEIGENBAUM_SET) < 3 * error
    assert error < 0.03


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
    passages = section(np.array([eta]), skip=200, keep=2**16, **given)
    assert passages.exponent.regimes().tolist() == [regime]
    assert passages.exponent.value[0] == pytest.approx(rate, abs=0.002)
    (places,) = passages.places
    assert box_dimension(places, 2, 8) == (1.0, 0.0)
    # In the plane each is a curve, of which a place alone decides the next one.
    value, error = box_dimension(return_map(places), 5, 9)
    assert abs(value - 1) < 3 * error < 0.1


def test_pairs_are_counted_once_and_coinciding_points_are_pairs(monkeypatch) -> None:
    points = np.array([0.0, 0.1, 0.3, 0.3, 1.0])
    # Distances 0, 0.1, 0.2, 0.2, 0.3, 0.3, 0.7, 0.7, 0.9, 1: fewer than 2^-k of them.
    expected = [9, 6, 4, 2, 1]
    assert correlation_counts(points, range(5)).tolist() == expected
    plane = np.column_stack((points, np.zeros(5)))
    assert correlation_counts(plane, range(5)).tolist() == expected
    monkeypatch.setattr("refdem.mechanics.dimension.AT_ONCE", 10)
    assert correlation_counts(points, range(5)).tolist() == expected


def test_a_line_has_correlation_dimension_one_and_a_square_two() -> None:
    draws = np.random.default_rng(83)
    value, error = correlation_dimension(draws.uniform(size=PAIRED), 7, 12)
    assert abs(value - 1) < 3 * error < 0.03
    value, error = correlation_dimension(draws.uniform(size=(PAIRED, 2)), 4, 8)
    assert abs(value - 2) < 3 * error < 0.06
    # Near the ends pairs lack: along each axis there are 2 r - r^2 of them closer than r.
    near_and_far = np.array([2.0**-8, 2.0**-4])
    expected = 2 * np.diff(np.log2(2 * near_and_far - near_and_far**2)) / 4
    assert abs(value - expected) < 2 * error


def test_cantors_set_has_the_correlation_dimension_ln_2_over_ln_3() -> None:
    digits = 2 * np.random.default_rng(83).integers(2, size=(PAIRED, 30))
    value, error = correlation_dimension(digits @ 3.0 ** -np.arange(1, 31), 2, 15)
    assert abs(value - np.log(2) / np.log(3)) < 3 * error < 0.1


def test_cantors_set_of_unequal_weights_has_less_than_its_boxes() -> None:
    """With weights p and 1 - p of its halves: ln(p^2 + (1 - p)^2)/ln(1/3)."""
    digits = 2 * (np.random.default_rng(83).uniform(size=(PAIRED, 30)) < 0.8)
    points = digits @ 3.0 ** -np.arange(1, 31)
    value, error = correlation_dimension(points, 2, 15)
    expected = np.log(0.8**2 + 0.2**2) / np.log(1 / 3)
    assert abs(value - expected) < 3 * error < 0.15
    assert value + 3 * error < np.log(2) / np.log(3)


def test_the_correlation_dimension_of_the_logistic_map_is_that_of_grassberger_and_procaccia() -> (
    None
):
    """0.500 +- 0.005 (Grassberger and Procaccia 1983), below the 0.538 of boxes."""
    value, error = correlation_dimension(logistic(ACCUMULATION, PAIRED), 4, 18)
    assert abs(value - 0.500) < 3 * error + 0.005
    assert value + 3 * error < FEIGENBAUM_SET
    of_cycle, error = correlation_dimension(logistic(3.5, PAIRED), 4, 16)
    assert of_cycle == 0.0
    assert error < 1e-4


@pytest.mark.parametrize("given", [CHAOTIC, {}])
def test_the_correlation_dimension_of_the_belt_rises_to_one_as_distances_fall(given) -> None:
    """Passages crowd where the density has a root: 1 - 1/log(1/r), which no fractal has."""
    (places,) = section(np.array([1.22]), skip=200, keep=2 * PAIRED, **given).places
    coarse, _ = correlation_dimension(places[:PAIRED], 3, 7)
    fine, error = correlation_dimension(places[:PAIRED], 7, 11)
    assert coarse + 0.04 < fine < 1 + 3 * error
    assert fine > 0.8
