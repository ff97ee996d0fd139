"""Velocities that are half a step early are compared with truth at their own time; what mixes two
times is left out.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.judgement import errors
from refdem.core.trajectory import Trajectory
from refdem.truth.sampled import sampled

DELAY = 2.0**-7


def plain(instance: Instance) -> Trajectory:
    """A run that stands still at the start."""
    columns = {
        name: np.repeat(getattr(instance.scene.bodies, name)[None], len(instance.times), axis=0)
        for name in STATE
    }
    return Trajectory(t=instance.times, **columns)


STATE = ("position", "velocity", "attitude", "omega")


@pytest.mark.parametrize("delay", [0.0, DELAY])
def test_a_run_is_right_at_the_time_that_it_says_and_wrong_at_another(delay: float) -> None:
    instance = discovery.case("harmonic-oscillator").at(samples="8", duration="2")
    truth = sampled(instance.truth(), instance.times.tolist(), [DELAY])
    run = plain(instance)
    position = run.position.copy()
    velocity = run.velocity.copy()
    position[:, 0, 0], velocity[:, 0, 0] = np.cos(run.t), -np.sin(run.t - delay)
    run = replace(run, position=position, velocity=velocity)
    right, wrong = (
        errors(instance, run, truth, lag) for lag in ((0.0, DELAY) if not delay else (DELAY, 0.0))
    )
    assert max(right["x"].max(), wrong["x"].max(), right["v"].max()) < 1e-15
    assert wrong["v"][1:].max() > 0.9 * DELAY


def test_quantities_of_two_times_are_left_out() -> None:
    instance = discovery.case("free-rigid-body").at(samples="4", duration="2")
    truth = sampled(instance.truth(), instance.times.tolist(), [DELAY])
    names = set(errors(instance, plain(instance), truth, DELAY))
    assert names == {"attitude", "omega.x", "omega.y", "omega.z"}
    assert "omega_body.x" in errors(instance, plain(instance), truth)


def test_of_two_spheres_places_and_velocities_are_all_compared() -> None:
    instance = discovery.case("two-spheres").at(samples="4")
    truth = sampled(instance.truth(), instance.times.tolist(), [DELAY])
    assert set(errors(instance, plain(instance), truth, DELAY)) == set(
        errors(instance, plain(instance), truth)
    )
