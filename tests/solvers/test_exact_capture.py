"""A mass caught by a hook: certified truth, any place and direction, what is out of reach, the
event, the force.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.uniform_gravity import UniformGravity

T = np.linspace(0.0, 8.0, 17)


def flying(position, velocity, radius=1.0, hook=(0.0, 0.0, 0.0), mass=1.0):
    """A mass on its way past a hook."""
    body = Body(mass=mass, position=tuple(np.add(position, hook)), velocity=velocity)
    return Scene.of([body], [Catch(a=0, radius=radius, anchor_b=hook)])


@pytest.mark.parametrize("given", [{}, {"mass": "3", "speed": "5/2", "radius": "2"}])
def test_state_is_right_to_round_off(solved, largest_error, given):
    run = solved(discovery.case("captured-mass").at(**given).scene, T, "exact-capture")
    assert largest_error("captured-mass", run, ("x", "y", "vx", "vy"), **given) < 4e-15


def test_force_and_event_are_those_of_the_circle(solved):
    run = solved(flying((-2.0, -0.5, 0.0), (4.0, 0.0, 0.0), mass=3.0), T, "exact-capture")
    assert [(event.kind, event.time) for event in run.events] == [("catch", 0.5)]
    assert run.channels["rod_force"][:, 0] == pytest.approx([0.0, *[3.0 * 16.0 / 0.5] * 16])


@pytest.mark.parametrize(
    ("position", "velocity"),
    [
        ((-2.0, -1.5, 0.0), (1.0, 0.0, 0.0)),
        ((0.5, -0.5, 0.0), (1.0, 0.0, 0.0)),
        ((0.5, 0.5, 0.0), (0.0, 0.0, 0.0)),
    ],
)
def test_what_is_out_of_reach_flies_away_or_at_rest_stays_straight(solved, position, velocity):
    run = solved(flying(position, velocity), T, "exact-capture")
    assert run.position[:, 0] == pytest.approx(
        np.array(position) + np.outer(T, velocity), abs=1e-14
    )
    assert not run.channels["rod_force"].any() or not any(velocity)


def test_what_is_on_the_circle_goes_on(solved):
    run = solved(
        flying((0.6, 0.8, 0.0), (-1.6, 1.2, 0.0), hook=(3.0, -1.0, 2.0)), T, "exact-capture"
    )
    angle = np.arctan2(0.8, 0.6) + 2.0 * T
    expected = np.array([3.0, -1.0, 2.0]) + np.stack([np.cos(angle), np.sin(angle), 0 * T], axis=1)
    assert run.position[:, 0] == pytest.approx(expected, abs=2e-14)


@pytest.mark.parametrize(
    ("scene", "times", "reason"),
    [
        (flying((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), T, None),
        (flying((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), -T, "let go"),
        (
            Scene.of(
                [Body(mass=1.0)], [Catch(a=0, radius=1.0), UniformGravity(g=(0.0, -1.0, 0.0))]
            ),
            T,
            "uniform_gravity; expected only catch",
        ),
        (Scene.of([Body(mass=1.0)] * 2, [Catch(a=0, b=1, radius=1.0)]), T, "bodies"),
    ],
)
def test_what_is_no_free_flight_past_a_hook_is_refused(scene, times, reason):
    unsupported = ENGINE.unsupported_motion(Motion(scene, times), ENGINE.method("exact-capture"))
    assert unsupported is None if reason is None else reason in str(unsupported)
