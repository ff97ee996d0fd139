"""The equations of the peers, integrated by a Runge-Kutta method of this file and compared with
certified truth.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from refdem.bench.peers._coulomb import coulomb
from refdem.bench.peers._equations import equations
from refdem.bench.session import sampled_truth
from refdem.core import discovery
from refdem.core.judgement import errors

STEPS = 64
SETS = [
    ("pendulum", {"length": "2", "mass": "3", "theta0": "2", "thetadot0": "1"}, False),
    ("pendulum", {"length": "2", "mass": "3", "theta0": "2", "thetadot0": "1"}, True),
    ("harmonic-oscillator", {"mass": "2", "stiffness": "3", "gravity": "1"}, False),
    ("duffing", {"alpha": "-1", "beta": "2", "amplitude": "1.5"}, False),
    ("two-body-orbit", {"gm": "2", "eccentricity": "1/4"}, False),
    ("free-rigid-body", {"attitude": "1,2,3,4", "omega_body": "1,-2,0.5"}, False),
]


def rk4(rates: Callable[[Sequence[float]], np.ndarray], y: np.ndarray, h: float) -> np.ndarray:
    """One classical step."""
    a = rates(y)
    b = rates(y + h / 2 * a)
    c = rates(y + h / 2 * b)
    return y + h / 6 * (a + 2 * b + 2 * c + rates(y + h * c))


@pytest.mark.parametrize(("case", "given", "cartesian"), SETS)
def test_the_equations_of_a_peer_have_the_motion_of_the_case(
    case: str, given: dict[str, str], cartesian: bool
) -> None:
    instance = discovery.case(case).at(**given, samples="8")
    system = equations(instance.motion, cartesian=cartesian)
    if system is None:
        pytest.fail(f"{case} has no equations")
    states = [np.array(system.start)]
    y = np.array(system.start)
    steps = STEPS * math.ceil(instance.scales.duration / instance.scales.tau / 8)
    h = instance.motion.interval / steps
    for _ in instance.times[1:]:
        for _ in range(steps):
            y = rk4(lambda state: np.array(system.rates(state, math.sin)), y, h)
        states.append(y)
    run = system.trajectory(instance.times, np.array(states))
    seen = errors(instance, run, sampled_truth(instance, []))
    assert max(float(np.max(values)) for values in seen.values()) < 1e-4


def test_scenes_that_are_not_simple_have_no_equations() -> None:
    for name in ("coulomb-oscillator", "viscous-oscillator", "double-pendulum", "hertz-spheres"):
        assert equations(discovery.case(name).at().motion) is None


def test_friction_points_against_where_the_spring_pulls_a_mass_at_rest() -> None:
    law = coulomb(
        discovery.case("coulomb-oscillator").at(mass="2", stiffness="3", friction_force="0.5").scene
    )
    assert law is not None
    assert (law.stiffness, law.friction) == (1.5, 0.25)
    assert law.direction == -math.copysign(1.0, law.place)
    assert coulomb(discovery.case("harmonic-oscillator").at().scene) is None
