"""Reasons made from declared patterns of scenes."""

import numpy as np
import pytest

from refdem.core.problem import Motion
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, SOME, TWO, Count, ScenePattern

T = np.linspace(0.0, 1.0, 3)
POINT = Body(mass=1.0)
BALL = Body(mass=1.0, shape=Sphere(radius=0.5), inertia=(0.1, 0.1, 0.1))
SPRING = Spring(a=0, stiffness=1.0)
LINEAR = Contact(law="linear", stiffness=1.0)


@pytest.mark.parametrize(
    ("pattern", "bodies", "elements", "reason"),
    [
        (ScenePattern(), [POINT], [], None),
        (ScenePattern(), [POINT], [SPRING], "an element of kind spring; expected none"),
        (
            ScenePattern(elements={Rod: SOME, UniformGravity: ANY}),
            [POINT],
            [SPRING],
            "an element of kind spring; expected only rod, uniform_gravity",
        ),
        (
            ScenePattern(elements={Rod: SOME}),
            [POINT],
            [],
            "no elements of kind rod; expected at least one",
        ),
        (
            ScenePattern(elements={Spring: OPTIONAL}),
            [POINT],
            [SPRING, SPRING],
            "2 elements of kind spring; expected at most one",
        ),
        (ScenePattern(bodies=TWO), [POINT], [], "1 bodies; expected two"),
        (ScenePattern(bodies=Count(2, 8)), [POINT], [], "1 bodies; expected two to 8"),
        (ScenePattern(shape=Sphere), [BALL, POINT], [], "body 1 is no sphere"),
        (
            ScenePattern(),
            [Body(mass=1.0, fixed=True)],
            [],
            "a body is fixed; expected bodies that are free to move",
        ),
        (ScenePattern(may_be_fixed=True), [Body(mass=1.0, fixed=True)], [], None),
        (
            ScenePattern(has_inertia=True),
            [POINT],
            [],
            "a body without inertia about one of its axes",
        ),
        (
            ScenePattern(may_spin=False),
            [Body(mass=1.0, inertia=(1.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))],
            [],
            "a body turns at the start",
        ),
        (
            ScenePattern(in_plane=True),
            [Body(mass=1.0, velocity=(0.0, 0.0, 1.0))],
            [],
            "the motion is not in the plane x-y",
        ),
        (
            ScenePattern(elements={Spring: ONE}, only_points=True),
            [POINT],
            [Spring(a=0, stiffness=1.0, anchor_a=(0.1, 0.0, 0.0))],
            None,
        ),
        (
            ScenePattern(elements={Contact: ONE}, law="hertz"),
            [BALL],
            [LINEAR],
            "contact law linear; expected hertz",
        ),
    ],
)
def test_the_first_difference_from_a_pattern_is_the_reason(pattern, bodies, elements, reason):
    found = pattern.unsupported(Motion(Scene.of(bodies, elements), T))
    if pattern.only_points:
        assert found
    else:
        assert found == reason


def test_a_method_that_runs_forward_only_says_why():
    pattern = ScenePattern(irreversible="motion cannot be recovered")
    scene = Scene.of([POINT], [])
    assert pattern.unsupported(Motion(scene, T)) is None
    said = pattern.unsupported(Motion(scene, -T))
    assert said == "time runs backwards, but motion cannot be recovered"
