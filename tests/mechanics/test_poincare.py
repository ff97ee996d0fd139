"""Sections and exponents of motions whose answers are known."""

import numpy as np
import pytest

from refdem.mechanics.poincare import Exponent, distinct, exponent, section


def test_a_section_of_a_sine_lies_at_its_turning_points():
    t = np.linspace(0, 20, 401)
    times, places = section(t, np.sin(t), np.cos(t))
    np.testing.assert_allclose(times, np.pi / 2 + np.pi * np.arange(len(times)), atol=1e-3)
    np.testing.assert_allclose(np.abs(places), 1, atol=1e-6)
    assert np.all(np.sign(places) == np.where(np.arange(len(places)) % 2, -1, 1))


def test_a_section_at_a_level_lies_at_the_level():
    t = np.linspace(0, 6, 601)
    times, places = section(t, t**2 / 2, t, level=2.5)
    assert times == pytest.approx([2.5], abs=1e-12)
    assert places == pytest.approx([2.5**2 / 2], abs=1e-9)


def test_an_exponent_is_the_mean_growth_with_the_error_of_the_mean():
    growth = np.array([[1.0, 3.0, 1.0, 3.0], [0.0, 0.0, 0.0, 0.0]])
    found = exponent(growth, np.array([8.0, 4.0]))
    np.testing.assert_allclose(found.value, [1.0, 0.0])  # 8 in 8 s
    np.testing.assert_allclose(found.error, [np.std([0.5, 1.5, 0.5, 1.5], ddof=1) / 2, 0.25])


def test_regimes_need_three_standard_errors():
    found = Exponent(np.array([0.031, 0.029, -0.031, 0.0]), np.full(4, 0.01))
    assert found.regimes().tolist() == ["chaotic", "quasi-periodic", "periodic", "quasi-periodic"]


@pytest.mark.parametrize(
    ("values", "count"),
    [([], 0), ([1.0], 1), ([2.0, 1.0, 2.0 + 1e-9, 1.0], 2), ([3.0, 1.0, 2.0], 3)],
)
def test_distinct_values_are_counted_once(values, count):
    assert distinct(np.array(values), 1e-6) == count
