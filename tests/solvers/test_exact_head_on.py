"""Head-on contact in closed form: certified truth, the event-driven method, and what it refuses."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import linear, mechanical
from refdem.core.problem import Motion, Request
from refdem.core.symmetry import Symmetry
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Scene

STATE = tuple(f"{kind}{i}.x" for i in (1, 2) for kind in "rv")
GIVEN = [
    {"damping": "1"},
    {},
    {"damping": "6", "cutoff": "zero_force"},
    {"damping": "16", "cutoff": "zero_force"},
    {"damping": "20", "cutoff": "zero_force"},
    {"damping": "20"},
    {"damping": "6", "masses": "1,1000000", "radii": "1/3,1/7"},
]


def scene_of(**given: str) -> Scene:
    """The scene of two-spheres."""
    return discovery.case("two-spheres").at(**given).scene


def run(problem: Motion, method: str = "exact-head-on") -> Trajectory:
    """A run of an exact method."""
    return ENGINE.run(Request(problem=problem, method=method))[0]


@pytest.mark.parametrize("given", GIVEN, ids=str)
def test_every_sample_agrees_with_certified_truth(given, largest_error):
    problem = discovery.case("two-spheres").at(**given).problem
    assert ENGINE.best(problem).name == "exact-head-on"
    assert largest_error("two-spheres", run(problem), STATE, **given) < 2e-14


@pytest.mark.parametrize("given", GIVEN, ids=str)
def test_it_agrees_with_the_event_driven_method_which_shares_no_formula(given):
    problem = discovery.case("two-spheres").at(**given).problem
    closed = run(problem)
    stepped = run(problem, "contact-events")
    assert np.abs(closed.position - stepped.position).max() < 3e-15
    assert (
        np.abs(closed.channels["dissipated_work"] - stepped.channels["dissipated_work"]).max()
        < 3e-15
    )
    assert [e.kind for e in closed.events] == [e.kind for e in stepped.events]
    assert all(
        abs(a.time - b.time) < 4e-15 for a, b in zip(closed.events, stepped.events, strict=True)
    )


@pytest.mark.parametrize("given", GIVEN, ids=str)
def test_momentum_and_work_balance_to_round_off(given):
    scene = scene_of(**given)
    seen = run(Motion(scene, np.arange(65) * 2.0**-7))
    balance = mechanical(scene, seen) + seen.channels["dissipated_work"]
    assert np.abs(balance - balance[0]).max() < 1e-14
    momentum = linear(scene, seen)
    assert np.abs(momentum - momentum[0]).max() < 4e-15


def test_spheres_apart_fly_first_and_touch_when_the_gap_is_closed():
    """A gap of 1/4 at closing speed 1; flying along a slanted line, carried by a moving centre of
    mass.
    """
    scene = scene_of(damping="6")
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    apart = (scene.bodies.position + np.array([[-0.125, 0, 0], [0.125, 0, 0]])) @ turn.T
    moving = scene.with_state(
        position=apart, velocity=scene.bodies.velocity @ turn.T + np.array([0.0, 0.0, 2.0])
    )
    seen = run(Motion(moving, np.arange(129) * 2.0**-7))
    at_once = run(Motion(scene, np.arange(129) * 2.0**-7))
    assert [e.kind for e in seen.events] == ["contact", "release"]
    assert seen.events[0].time == pytest.approx(0.25, abs=1e-15)
    assert seen.events[1].time - seen.events[0].time == pytest.approx(
        at_once.events[0].time, abs=1e-15
    )
    back = (seen.velocity[32:] - np.array([0.0, 0.0, 2.0])) @ turn
    assert np.abs(back - at_once.velocity[: len(back)]).max() < 4e-15


@pytest.mark.parametrize("backward", [False, True])
def test_an_elastic_collision_runs_back_to_its_start(backward):
    scene = scene_of(damping="0", masses="1,3")
    times = np.arange(33) * 2.0**-6
    end = run(Motion(scene, times)).end()
    if backward:
        sign = 1.0
    else:
        sign = -1.0
    turned = scene.with_state(position=end["position"], velocity=sign * end["velocity"])
    home = run(Motion(turned, times[::-1].copy() if backward else times))
    assert np.abs(home.position[-1] - scene.bodies.position).max() < 3e-15
    assert np.abs(sign * home.velocity[-1] - scene.bodies.velocity).max() < 1e-14


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"angle": "0.5"}, "line of their centres"),
        ({"spins": "0,0,1,0,0,0"}, "turns"),
    ],
)
def test_what_it_cannot_do_is_refused_with_its_reason(given, reason):
    problem = Motion(scene_of(**given), np.arange(3) * 0.5)
    assert reason in ENGINE.unsupported_motion(problem, ENGINE.method("exact-head-on"))


def test_a_dashpot_has_no_way_back_and_an_overlap_no_known_past():
    scene = scene_of(damping="6")
    method = ENGINE.method("exact-head-on")
    assert "backwards" in ENGINE.unsupported_motion(Motion(scene, -np.arange(3) * 0.5), method)
    pressed = scene.with_state(position=scene.bodies.position * 0.9)
    assert "overlap" in ENGINE.unsupported_motion(Motion(pressed, np.arange(3) * 0.5), method)


def test_spheres_of_any_size_meet():
    """Squares of their distance underflow below 1e-162 m; velocities are as they were, in units of
    the length.
    """
    motion = Motion(scene_of(damping="6"), np.arange(33) * 2.0**-6)
    seen = run(motion)
    for unit in (2.0**-600, 2.0**-900, 2.0**300):
        tiny = run(Symmetry(units=(1.0, unit, 1.0)).applied(motion))
        assert np.abs(tiny.velocity / unit - seen.velocity).max() < 1e-15, unit
        assert [event.time for event in tiny.events] == [event.time for event in seen.events]
