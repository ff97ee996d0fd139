"""Hermite's interpolation between samples: exact for polynomials, of order 2 m for all else."""

import numpy as np
import pytest

from refdem.mechanics.interpolation import between_samples

NODES = np.array([-0.75, 0.0, 0.5])


@pytest.mark.parametrize("window", [2, 3, 4])
def test_a_polynomial_of_degree_2m_minus_1_is_met_exactly_at_uneven_samples(window):
    rng = np.random.default_rng(window)
    t = np.cumsum(rng.uniform(0.2, 1.0, 9))
    polynomials = [np.polynomial.Polynomial(rng.normal(size=2 * window)) for _ in range(3)]
    position = np.stack([p(t) for p in polynomials], axis=-1)[:, None]
    velocity = np.stack([p.deriv()(t) for p in polynomials], axis=-1)[:, None]
    times, places, speeds = between_samples(t, position, velocity, NODES, window)
    assert places.shape == (8, 3, 1, 3)
    for axis, polynomial in enumerate(polynomials):
        size = np.abs(position[..., axis]).max()
        assert np.abs(places[:, :, 0, axis] - polynomial(times)).max() < 1e-9 * size
        size = np.abs(velocity[..., axis]).max()
        assert np.abs(speeds[:, :, 0, axis] - polynomial.deriv()(times)).max() < 1e-9 * size


@pytest.mark.parametrize("window", [2, 3, 4])
def test_the_error_falls_with_the_power_2m_of_the_distance_of_samples(window):
    def error(count):
        t = np.linspace(0.0, 6.0, count)
        times, places, _ = between_samples(t, np.sin(t), np.cos(t), NODES, window)
        return np.abs(places - np.sin(times)).max()

    order = np.log2(error(25) / error(49))
    assert abs(order - 2 * window) < 0.5


def test_too_few_samples_are_refused():
    t = np.arange(3.0)
    with pytest.raises(ValueError, match="3 samples, expected at least 4"):
        between_samples(t, t, t, NODES, 4)
