"""Accelerations of points: beside the loads of the transparent engine, which share no line with
them, and by hand where that engine has no such link.
"""

import numpy as np
import pytest

from refdem.faults.correct_parts import CORRECT
from refdem.faults.loads import loads
from refdem.faults.world import start_of, world_of
from refdem.scene import Body, Scene, Sphere
from refdem.scene.acceleration import acceleration, unsupported_feature
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

AXIS = (2 / 3, -1 / 3, 2 / 3)
BODIES = [
    Body(mass=2.0, position=(1.0, 0.5, -0.25), velocity=(0.5, -1.0, 2.0)),
    Body(mass=0.75, position=(-0.5, 2.0, 1.0), velocity=(-1.5, 0.25, 0.5)),
    Body(mass=3.0, position=(0.25, -1.0, 0.5), velocity=(0.0, 1.0, -0.5)),
]
ELEMENTS = {
    "spring": Spring(a=0, b=2, stiffness=3.0, length=0.5),
    "bent spring": Spring(a=1, stiffness=2.0, length=4.0, exponent=1.5, quadratic=0.5, cubic=2.0),
    "spring to a place": Spring(a=0, stiffness=2.0, anchor_b=(1.0, 2.0, 3.0)),
    "dashpot": Dashpot(a=1, damping=0.5, van_der_pol=0.25, anchor_b=(1.0, 0.0, 0.0)),
    "fluid that turns": RotatingDashpot(
        a=1, damping=0.5, rate=(1.0, -2.0, 3.0), anchor_b=(1.0, 0.0, 0.0)
    ),
    "drag": Drag(a=2, coefficient=0.5),
    "drag against another": Drag(a=0, b=1, coefficient=0.5),
    "drive": Force(a=1, amplitude=2.0, frequency=3.0, phase=0.5, axis=AXIS),
    "orbit": CentralField(gm=2.0),
    "gravity": UniformGravity(g=(1.0, -2.0, 0.5)),
    "tent": PiecewiseField(k1=1.0, k2=-1.5, x1=-3.0, x2=2.0, point=(0.25, 0.0, 0.0), axis=AXIS),
}


@pytest.mark.parametrize("names", [*([name] for name in ELEMENTS), list(ELEMENTS)], ids=str)
def test_accelerations_are_the_loads_of_the_transparent_engine_over_masses(
    names: list[str],
) -> None:
    scene = Scene.of(BODIES, [ELEMENTS[name] for name in names])
    assert unsupported_feature(scene) is None
    world = world_of(scene, float)
    state = start_of(scene, world, CORRECT.to_body)
    state.t = 0.75
    expected = np.array(loads(world, state, CORRECT).force) / scene.bodies.mass[:, None]
    bodies = scene.bodies
    found = acceleration(scene)(0.75, bodies.position, bodies.velocity)
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-14)


def test_links_between_two_bodies_act_and_react_and_a_fixed_body_stays() -> None:
    """m1 a1 = F = -m2 a2 with F = -(c + e d^2) w + A axis."""
    links = [
        Dashpot(a=0, b=1, damping=0.5, van_der_pol=0.25),
        Force(a=0, b=1, amplitude=2.0, axis=AXIS),
    ]
    first, second, third = BODIES
    d = np.subtract(first.position, second.position)
    w = np.subtract(first.velocity, second.velocity)
    force = -(0.5 + 0.25 * d @ d) * w + 2.0 * np.array(AXIS)
    fixed = Body(mass=1.0, position=third.position, fixed=True)
    scene = Scene.of([first, second, fixed], [*links, UniformGravity(g=(0.0, 0.0, 0.0))])
    found = acceleration(scene)(0.0, scene.bodies.position, scene.bodies.velocity)
    np.testing.assert_allclose(found[0], force / first.mass, rtol=1e-14)
    np.testing.assert_allclose(found[1], -force / second.mass, rtol=1e-14)
    pulled = Scene.of([first, second, fixed], [Spring(a=2, b=0, stiffness=1.0)])
    assert not acceleration(pulled)(0.0, pulled.bodies.position, pulled.bodies.velocity)[2].any()


def test_a_spring_of_no_length_at_its_anchor_does_not_pull() -> None:
    scene = Scene.of([Body(mass=1.0)], [Spring(a=0, stiffness=3.0, length=0.5)])
    assert not acceleration(scene)(0.0, np.zeros((1, 3)), np.zeros((1, 3))).any()


@pytest.mark.parametrize(
    ("body", "element", "lacks"),
    [
        (Body(mass=1.0), Rod(a=0, length=1.0, anchor_b=(1.0, 0.0, 0.0)), "the element rod"),
        (
            Body(mass=1.0, inertia=(1.0, 2.0, 2.5), omega=(1.0, 0.0, 0.0)),
            ELEMENTS["gravity"],
            "bodies that turn",
        ),
        (
            Body(mass=1.0, shape=Sphere(radius=0.5)),
            Contact(law="linear", stiffness=1.0),
            "the element contact",
        ),
        (
            Body(mass=1.0),
            Spring(a=0, stiffness=1.0, anchor_a=(0.5, 0.0, 0.0)),
            "a spring off the centre of a body",
        ),
    ],
)
def test_what_is_more_than_points_in_forces_is_named(body: Body, element, lacks: str) -> None:  # type: ignore[no-untyped-def]
    assert unsupported_feature(Scene.of([body], [element])) == lacks
