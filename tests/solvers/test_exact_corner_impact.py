"""The impact of a corner in the reference: what it refuses, and a plane of another direction."""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.mechanics.quaternion import product, rotated, turned_by
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.solvers.exact_corner_impact import METHOD

CASE = discovery.case("corner-impact")
RISING = np.array([[0.0, 0.5, 0.0]])


def problem(bodies=None, law=None, plane=None, **given):
    """The problem of the case with another body, law or plane."""
    motion = CASE.at(**given).problem
    scene = motion.scene
    elements = [law or scene.all(Contact)[0], plane or scene.all(Plane)[0]]
    return Motion(Scene(replace(scene.bodies, **(bodies or {})), tuple(elements)), motion.times)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"law": Contact(law="rigid", restitution=0.5, friction=0.1)}, "friction"),
        ({"plane": Plane(normal=(0.0, 0.6, 0.8))}, "not in the plane"),
        ({"bodies": {"velocity": np.array([[0.0, 1.0, 0.0]])}}, "does not come down"),
        ({"bodies": {"position": np.array([[0.0, 0.1, 0.0]])}}, "does not come down"),
        ({"bodies": {"attitude": np.array([[1.0, 0.0, 0.0, 0.0]])}}, "a face"),
        ({"bodies": {"omega": np.array([[0.0, 1.0, 0.0]])}}, "not in the plane"),
        ({"bodies": {"velocity": RISING, "omega": np.array([[0.0, 0.0, 1e-3]])}}, "does not come"),
    ],
)
def test_what_is_no_smooth_impact_of_one_corner_is_refused(changed, reason):
    assert reason in METHOD.unsupported(problem(**changed))
    assert METHOD.unsupported(problem()) is None


def test_a_second_corner_is_refused():
    motion = problem(angle="1/16")
    times = np.linspace(0, 4, len(motion.times))
    assert "second corner" in METHOD.unsupported(Motion(motion.scene, times))


def test_a_plane_and_a_box_that_are_turned_together_have_the_same_motion():
    turn = turned_by(np.array([0.0, 0.0, 0.7]))
    upright = problem()
    bodies = upright.scene.bodies
    turned = problem(
        bodies={
            "position": rotated(turn, bodies.position),
            "velocity": rotated(turn, bodies.velocity),
            "attitude": product(turn, bodies.attitude),
        },
        plane=Plane(normal=tuple(rotated(turn, np.array([0.0, 1.0, 0.0])).tolist())),
    )
    one, _ = METHOD.run(Request(problem=upright, method=METHOD.claims))
    other, _ = METHOD.run(Request(problem=turned, method=METHOD.claims))
    assert other.omega == pytest.approx(one.omega, abs=1e-14)
    assert other.position == pytest.approx(rotated(turn, one.position), abs=1e-14)
    assert other.velocity == pytest.approx(rotated(turn, one.velocity), abs=1e-14)


@pytest.mark.parametrize("spin", [-2.0, -0.3, 1e-3, 0.3, 2.0])
def test_a_box_that_turns_before_the_impact_keeps_its_energy_and_passes_on_its_momentum(spin):
    """Nothing but an impulse J along y at the corner acts: I domega = r x J, and e = 1 keeps T."""
    turning = problem(bodies={"omega": np.array([[0.0, 0.0, spin]])}, restitution="1")
    run, _ = METHOD.run(Request(problem=turning, method=METHOD.claims))
    bodies = turning.scene.bodies
    (event,) = run.events
    impulse = bodies.mass[0] * (run.velocity[-1, 0] - run.velocity[0, 0])
    moment = bodies.inertia[0, 2]
    gain = moment * (run.omega[-1, 0, 2] - spin)
    lever = gain / impulse[1]
    # The corner that touches: its height at the time of the impact is 0.
    turn = product(turned_by(np.array([0.0, 0.0, spin * event.time])), bodies.attitude[0])
    arms = rotated(turn, np.array(bodies.shape[0].vertices))
    place = bodies.position[0] + bodies.velocity[0] * event.time
    heights = (place + arms)[:, 1]
    assert heights.min() == pytest.approx(0, abs=1e-14)
    assert lever == pytest.approx(arms[np.argmin(heights), 0], rel=1e-12)
    assert impulse[0] == 0
    energy = bodies.mass[0] * np.sum(run.velocity[:, 0] ** 2, axis=1) + moment * (
        run.omega[:, 0, 2] ** 2
    )
    assert energy == pytest.approx(np.full(len(energy), energy[0]), rel=1e-13)


def test_the_first_of_two_corners_that_come_down_is_the_one_that_touches():
    """A box that is nearly flat and turns: the corner that is the higher one at first touches."""
    turning = problem(
        bodies={"omega": np.array([[0.0, 0.0, -2.0]])}, angle="1/8", height="1", restitution="1"
    )
    run, _ = METHOD.run(Request(problem=turning, method=METHOD.claims))
    # The impulse of the corner on the right, in front of the centre, turns the box to the left.
    assert run.omega[-1, 0, 2] > -2.0
