"""The Coulomb oscillator: certified truth at every sample, the stop to the last bit, nothing
afterwards.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

METHOD = ENGINE.method("exact-coulomb")


def run(problem: Motion) -> Trajectory:
    """A run of the exact method."""
    return ENGINE.run(Request(problem=problem, method="exact-coulomb"))[0]


def rubbed(
    friction: float = 0.25,
    gravity: float = 0.0,
    axis=(1.0, 0.0, 0.0),
    anchor=(0.0, 0.0, 0.0),
    **body,
) -> Scene:
    """A point on a spring of stiffness 1 that rubs."""
    spring = Spring(a=0, stiffness=1.0, anchor_b=anchor)
    field = UniformGravity(g=tuple(gravity * a for a in axis))
    return Scene.of(
        [Body(mass=1.0, **body)],
        [spring, Slider(a=0, friction=friction, normal_force=1.0, axis=axis), field],
    )


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"v0": "2"},
        {"v0": "-1.3", "x0": "0.2"},
        {"friction_force": "1/3"},
        {"friction_force": "0.001", "duration": "500"},
        {"mass": "2.5", "stiffness": "7", "friction_force": "0.1"},
    ],
    ids=str,
)
def test_every_sample_agrees_with_certified_truth(given, largest_error):
    seen = run(discovery.case("coulomb-oscillator").at(**given).problem)
    assert largest_error("coulomb-oscillator", seen, ("x", "v"), **given) < 3e-15


def test_it_turns_at_1_minus_07_04_and_stops_at_minus_01_after_three_half_cycles():
    seen = run(discovery.case("coulomb-oscillator").at().problem)
    assert [(event.kind, event.body) for event in seen.events] == [("stop", 0)]
    assert seen.events[0].time == 3 * np.pi
    after = seen.t >= seen.events[0].time
    assert np.all(seen.velocity[after] == 0.0)
    assert np.ptp(seen.position[after, 0, 0]) == 0.0
    assert seen.position[-1, 0, 0] == pytest.approx(-0.1, abs=3e-16)
    assert seen.channels["dissipated_work"][-1] == pytest.approx(0.495, rel=1e-15)


def test_dyadic_numbers_give_the_exact_stop():
    """x0 = 1, f/k = 1/8: turning points -3/4, 1/2, -1/4, 0: exactly representable, so exactly
    hit.
    """
    seen = run(Motion(rubbed(0.125, position=(1.0, 0.0, 0.0)), np.arange(33) * 0.5))
    assert seen.position[-1, 0, 0] == 0.0
    assert seen.events[0].time == 4 * np.pi


@pytest.mark.parametrize("start", [0.25, -0.25, 0.1, 0.0])
def test_a_body_at_rest_under_no_more_than_the_limit_stays(start):
    """Closed: also at k|x| = f exactly."""
    seen = run(Motion(rubbed(0.25, position=(start, 0.0, 0.0)), np.arange(9) * 0.5))
    assert np.all(seen.position[:, 0, 0] == start)
    assert not np.any(seen.velocity)
    assert seen.events[0].time == 0.0


@pytest.mark.parametrize("speed", [1.5, -1.5])
def test_energy_lost_is_the_work_of_friction_at_every_sample(speed):
    """Also on the way to the first turning point, in both directions."""
    scene = rubbed(0.1, position=(2.0, 0.0, 0.0), velocity=(speed, 0.0, 0.0))
    seen = run(Motion(scene, np.arange(129) * 0.25))
    balance = mechanical(scene, seen) + seen.channels["dissipated_work"]
    assert np.abs(balance - balance[0]).max() < 1e-14


def test_gravity_shifts_the_equilibrium_and_nothing_else():
    times = np.arange(65) * 0.25
    level = run(Motion(rubbed(0.25, position=(2.0, 0.0, 0.0)), times))
    hanging = run(Motion(rubbed(0.25, gravity=4.0, position=(6.0, 0.0, 0.0)), times))
    assert np.abs(hanging.position[:, 0, 0] - 4.0 - level.position[:, 0, 0]).max() < 5e-15
    assert hanging.events[0].time == level.events[0].time


def test_it_runs_along_any_axis():
    axis = (0.6, 0.0, 0.8)
    place = tuple(1.0 + 2.0 * a for a in axis)
    turned = run(
        Motion(
            rubbed(0.25, axis=axis, anchor=(1.0, 1.0, 1.0), position=place), np.arange(65) * 0.25
        )
    )
    level = run(Motion(rubbed(0.25, position=(2.0, 0.0, 0.0)), np.arange(65) * 0.25))
    assert (
        np.abs((turned.position[:, 0] - 1.0) @ np.array(axis) - level.position[:, 0, 0]).max()
        < 1e-14
    )


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (rubbed(0.25, position=(1.0, 0.5, 0.0)), "along the slider"),
        (rubbed(0.25, position=(1.0, 0.0, 0.0), velocity=(0.0, 0.0, 1.0)), "along the slider"),
        (rubbed(0.0, position=(1.0, 0.0, 0.0)), "does not rub"),
    ],
)
def test_what_it_cannot_do_is_refused_with_its_reason(scene, reason):
    assert reason in ENGINE.unsupported_motion(Motion(scene, np.arange(3) * 0.5), METHOD)


def test_time_backwards_is_refused_because_rest_has_no_past():
    problem = Motion(rubbed(0.25, position=(1.0, 0.0, 0.0)), -np.arange(3) * 0.5)
    assert "backwards" in ENGINE.unsupported_motion(problem, METHOD)
