"""Harmonic motion in closed form: against certified truth and elementary values."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity


def on_spring(position, velocity, g=(0.0, 0.0, 0.0), **more):
    """A point of 2 kg on a spring of 8 N/m: w = 2."""
    spring = {"a": 0, "stiffness": 8.0} | more
    return Scene.of(
        [Body(mass=2.0, position=position, velocity=velocity)],
        [Spring(**spring), UniformGravity(g=g)],
    )


@pytest.mark.parametrize("duration", [6300.0, -1e7])
@pytest.mark.parametrize("gravity", ["0", "9.75"])
def test_state_is_right_to_some_ulps_after_any_number_of_periods(
    solved, largest_error, duration, gravity
):
    given = {"mass": "3", "stiffness": "7", "gravity": gravity, "x0": "0.5", "v0": "0.25"}
    scene = discovery.case("harmonic-oscillator").at(**given).scene
    trajectory = solved(scene, duration * np.array([0.0, 0.3, 0.7, 1.0]), "exact-harmonic")
    # The motion is about m g/k, up to 4 m away, with an amplitude as large.
    assert largest_error("harmonic-oscillator", trajectory, ("x", "v"), **given) < 4e-15


def test_motion_in_space_is_an_ellipse_about_the_shifted_equilibrium(solved):
    anchor = np.array((1.0, -2.0, 3.0))
    g = np.array((0.0, 4.0, -8.0))
    scene = on_spring((3.0, -2.0, 3.0), (0.0, 2.0, 4.0), tuple(g), anchor_b=tuple(anchor))
    t = np.array([0.0, 0.5, -0.75, 30.0])[[2, 0, 1, 3]]
    trajectory = solved(scene, t - t[0], "exact-harmonic")
    rest = anchor + g / 4.0
    c = np.cos(2 * (t - t[0]))[:, None]
    s = np.sin(2 * (t - t[0]))[:, None]
    start = np.array((3.0, -2.0, 3.0)) - rest
    speed = np.array((0.0, 2.0, 4.0))
    assert trajectory.position[:, 0] == pytest.approx(rest + start * c + speed / 2 * s, abs=5e-15)
    assert trajectory.velocity[:, 0] == pytest.approx(speed * c - 2 * start * s, abs=4e-15)


def test_point_at_rest_at_the_equilibrium_stays_to_the_last_bit(solved):
    trajectory = solved(
        on_spring((0.0, -2.0, 0.0), (0.0, 0.0, 0.0), (0.0, -8.0, 0.0)),
        (0.0, 1.0, 1e6),
        "exact-harmonic",
    )
    assert np.array_equal(trajectory.position[:, 0], np.tile((0.0, -2.0, 0.0), (3, 1)))
    assert not trajectory.velocity.any()


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ({"length": 1.0}, "natural length 0"),
        ({"exponent": 1.5}, "natural length 0"),
        ({"anchor_a": (1.0, 0.0, 0.0)}, "off a body's"),
    ],
)
def test_springs_that_are_not_harmonic_are_refused(more, reason):
    problem = Motion(on_spring((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), **more), np.array([0.0, 1.0]))
    assert reason in str(ENGINE.unsupported_motion(problem, ENGINE.method("exact-harmonic")))
