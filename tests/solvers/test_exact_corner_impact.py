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
        ({"bodies": {"omega": np.array([[0.0, 0.0, 1.0]])}}, "turns at the start"),
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
