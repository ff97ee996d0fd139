"""The scales of stick-slip: no rate of the motion is left out of tau."""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.scene.elements.slider import Slider

FAST = [
    {"v0": "805", "belt": "505", "lambda1": "0.00226", "a": "31.6"},
    {"v0": "-40", "lambda1": "0.1"},
    {"belt": "-200", "lambda1": "0.03"},
    {"lambda1": "7", "friction_law": "linear"},
    {"x0": "300", "lambda1": "0.2"},
]


@pytest.mark.parametrize("given", FAST)
def test_tau_is_no_longer_than_friction_takes_to_slow_the_mass(given):
    instance = discovery.case("stick-slip").at(**given)
    (slider,) = instance.scene.all(Slider)
    start = float(instance.scene.bodies.velocity[0, 0])
    belt = slider.belt_velocity
    # The slope of the friction with the speed, by central differences, at the start and at rest.
    for speed in (abs(start - belt), abs(belt)):
        change = 1e-4 * speed
        slope = (slider.coefficient(speed + change) - slider.coefficient(speed - change)) / (
            2 * change
        )
        assert instance.scales.tau <= 1.001 / (slider.normal_force * slope)


@pytest.mark.parametrize(
    ("given", "most"),
    [
        ({"a": "13.5", "mu0": "57.6", "mu1": "0.308", "lambda0": "0.732"}, 4.0),
        ({"lambda0": "300"}, 4.0),
        ({"mu1": "30", "lambda0": "5"}, 1.0),
    ],
)
def test_a_step_resolves_how_friction_changes_from_rest(given, most):
    """A step that does not jumps over the speeds at which the mass sticks."""
    instance = discovery.case("stick-slip").at(**given)
    (slider,) = instance.scene.all(Slider)
    change = 1e-6 / slider.lambda0
    slope = (slider.coefficient(change) - slider.coefficient(0.0)) / change
    assert instance.scales.tau <= 1.001 * most / (slider.normal_force * abs(slope))


def test_the_default_duration_is_one_of_the_oscillation_however_fast_friction_acts():
    instance = discovery.case("stick-slip").at(lambda1="3", eta="2")
    assert instance.scales.tau < 0.1
    assert instance.times[-1] == 10.0


def test_a_belt_that_runs_backwards_pulls_twice_and_the_scale_says_so():
    """With the belt at -50 m/s the mass rests where the spring holds two times a mu(50)."""
    given = {"belt": "-50", "lambda1": "0.002", "gamma": "0", "x0": "-1", "duration": "12"}
    instance = discovery.case("stick-slip").at(**given, samples="8")
    (slider,) = instance.scene.all(Slider)
    rest = 2 * slider.normal_force * slider.coefficient(50.0)
    assert float(instance.truth().at(Fraction(12))["x"].mid) == pytest.approx(-rest, rel=0.02)
    assert rest <= instance.scales.length <= 1.1 * rest
