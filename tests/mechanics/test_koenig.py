"""Parts of energy and of angular momentum by Koenig's theorem, and the energy of a turn."""

import numpy as np
import pytest

from refdem.mechanics import koenig


@pytest.fixture
def cloud():
    """Masses, positions and velocities of 7 points, and an omega."""
    random = np.random.default_rng(38)
    mass = random.uniform(0.5, 2, 7)
    return mass, random.normal(size=(7, 3)), random.normal(size=(7, 3)), random.normal(size=3)


def test_parts_of_the_centre_and_about_it_are_the_whole(cloud):
    mass, position, velocity, _ = cloud
    energy = koenig.energy_of_centre(mass, velocity) + koenig.energy_about_centre(mass, velocity)
    assert energy == pytest.approx(koenig.energy(mass, velocity), rel=1e-14)
    momentum = koenig.angular_momentum_of_centre(mass, position, velocity)
    momentum += koenig.angular_momentum_about_centre(mass, position, velocity)
    whole = koenig.angular_momentum(mass, position, velocity)
    np.testing.assert_allclose(momentum, whole, rtol=0, atol=1e-13)


def test_what_is_about_the_centre_does_not_know_who_looks(cloud):
    mass, position, velocity, _ = cloud
    elsewhere = position + np.array([3.0, -1.0, 2.0])
    boosted = velocity + np.array([-5.0, 4.0, 1.0])
    seen = koenig.energy_about_centre(mass, boosted)
    assert seen == pytest.approx(koenig.energy_about_centre(mass, velocity), rel=1e-13)
    momentum = koenig.angular_momentum_about_centre(mass, elsewhere, boosted)
    still = koenig.angular_momentum_about_centre(mass, position, velocity)
    np.testing.assert_allclose(momentum, still, rtol=0, atol=1e-12)


def test_the_tensor_gives_the_energy_of_the_points_that_turn(cloud):
    mass, position, _, omega = cloud
    by_points = koenig.swept_energy(mass, position, omega)
    assert koenig.tensor_energy(mass, position, omega) == pytest.approx(by_points, rel=1e-13)
