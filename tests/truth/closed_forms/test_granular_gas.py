"""Haff's time against integrals over Maxwell's velocities by quadrature."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError


def scalars(**given: str) -> dict[str, float]:
    truth = discovery.case("granular-gas").at(**given).truth()
    return {name: float(ball.mid) for name, ball in truth.scalars().items()}


def moment(power: int, t0: float) -> float:
    """Integral over v_n > 0 of v_n^power with the Gaussian density of the normal relative velocity,
    variance 2 T/m, by quadrature.
    """
    v, w = np.polynomial.laguerre.laggauss(80)
    spread = np.sqrt(2 * t0)
    u = np.sqrt(2 * v)  # exp(-u^2/2) du u = exp(-v) dv
    return float(np.sum(w * (spread * u) ** power / u)) / np.sqrt(2 * np.pi)


@pytest.mark.parametrize(
    ("e", "d", "n", "t0"), [(0.9, 1.0, 0.05, 1.0), (0.5, 0.5, 0.3, 2.0), (0.8, 2.0, 0.01, 0.25)]
)
def test_haff_time_is_the_mean_loss_times_the_rate_of_collisions(e, d, n, t0):
    """Flux through the sphere of radius sigma: every direction sees n chi 4 pi sigma^2 <v_n>, and
    loses (1 - e^2) m v_n^2/4.
    """
    phi = np.pi * n * d**3 / 6
    chi = (1 - phi / 2) / (1 - phi) ** 3
    area = 4 * np.pi * d * d * n * chi
    rate = area * moment(1, t0)
    power = area * moment(3, t0) * (1 - e * e) / 4 / 2  # each collision is shared by two
    found = scalars(restitution=str(e), diameter=str(d), density=str(n), t0=str(t0))
    assert found["collision_frequency"] == pytest.approx(rate, rel=1e-12)
    assert found["haff_time"] == pytest.approx(2 * (1.5 * t0) / power, rel=2e-12)


def test_the_radius_is_as_small_as_asked_for():
    truth = discovery.case("granular-gas").at().truth().refined(60)
    assert 0 < truth.scalars()["haff_time"].radius <= Fraction(1, 10**60)


def test_an_elastic_gas_has_no_haff_time():
    assert set(scalars(restitution="1")) == {"collision_frequency"}


def test_the_motion_itself_is_not_certified():
    with pytest.raises(NotCertifiedError, match="chaotic"):
        discovery.case("granular-gas").at().truth().at(Fraction(1))
