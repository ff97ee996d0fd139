"""Growth of errors made on the way, against the sensitivity of a motion that is started there."""

from dataclasses import replace
from fractions import Fraction

import pytest

from refdem.core.discovery import truth_of
from refdem.truth.balls import precision
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody
from refdem.truth.refiner import Refiner
from refdem.truth.sampled import sampled

SPINS = [f"{name}.{a}" for name in ("omega_body", "omega") for a in "xyz"]
MADE = Fraction(5, 4)
SEEN = Fraction(4)


def grown(truth):
    """S at SEEN with an error made at 0 or at MADE."""
    return truth.sensitivities([Fraction(0), MADE, SEEN])[-1]


@pytest.mark.parametrize(
    "given",
    [{"theta0": "3"}, {"theta0": "0", "thetadot0": "6"}, {"theta0": "1", "thetadot0": "-7"}],
)
def test_growth_in_a_pendulum_is_that_of_one_started_on_the_way(given):
    truth = truth_of("pendulum", **given)
    way = truth.refined(70).at(MADE)
    start = {"theta0": way["theta"].mid, "thetadot0": way["thetadot"].mid}
    later = replace(truth, **start).sensitivity(SEEN - MADE)
    # What grows from MADE on alone is no more than S, and S is not much more than the largest of
    # what is made before and after.
    assert later <= 1.3 * grown(truth)
    assert grown(truth) <= 1.3 * max(later, truth.sensitivity(MADE) * later)
    assert from_the_start(truth, SEEN) <= grown(truth)


def from_the_start(truth, t):
    """What errors of the start have grown to, by central differences."""
    with precision(384):
        table = truth.jacobian(t).table()
    return max(sum(abs(float(entry.mid())) for entry in row) for row in table)


def test_a_pendulum_let_go_near_the_top_answers_more_to_an_error_at_the_bottom():
    truth = truth_of("pendulum", theta0="3")
    assert grown(truth) > 2 * from_the_start(truth, SEEN)


@pytest.mark.parametrize("omega", [(0.9, 1.1, 1.3), (0.01, 1, 0), (0, 0, 1)])
def test_growth_in_a_free_body_is_that_of_one_started_on_the_way(omega):
    inertia = tuple(map(Fraction, (1, 2, 3)))
    unit = tuple(map(Fraction, (1, 0, 0, 0)))
    refiner = Refiner.of({**dict.fromkeys(SPINS, 2.0), "attitude.w": 0.5})
    truth = FreeRigidBody(refiner, inertia, tuple(map(Fraction, omega)), unit)
    way = FreeRigidBody(refiner, inertia, truth.omega, unit).at(MADE)
    spin = tuple(way[f"omega_body.{a}"].mid for a in "xyz")
    attitude = tuple(way[f"attitude.{a}"].mid for a in "wxyz")
    later = FreeRigidBody(refiner, inertia, spin, attitude).sensitivity(SEEN - MADE)
    assert later <= 1.3 * grown(truth)
    assert grown(truth) <= 2 * truth.sensitivity(MADE) * later


def test_samples_carry_the_growth_of_all_earlier_ones():
    truth = truth_of("pendulum", theta0="3")
    times = [0.5 * k for k in range(9)]
    found = sampled(truth, times)
    assert found.sensitivity == truth.sensitivities([Fraction(t) for t in times])
    assert found.sensitivity[-1] > max(from_the_start(truth, Fraction(t)) for t in times)
