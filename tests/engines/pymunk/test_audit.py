"""The audit of defaults says what the installed pymunk comes with and what the adapter sets."""

import math
from itertools import combinations

import numpy as np
import pymunk
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.pymunk import ENGINE
from refdem.engines.pymunk.shapes import factors
from refdem.engines.pymunk.space import space_of
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

LINE = {setting.setting: setting for setting in ENGINE.audit}
SCENE = Scene.of(
    [Body(mass=1.0, position=(1.0, 0.0, 0.0))],
    [Rod(a=0, length=1.0), Spring(a=0, stiffness=1.0), Slider(a=0, friction=0.5, normal_force=3.0)],
)


def test_pymunk_comes_with_what_the_audit_says():
    space = pymunk.Space()
    joint = pymunk.PinJoint(pymunk.Body(1, 1), pymunk.Body(1, 1))
    assert (space.damping, space.iterations, space.threaded) == (1.0, 10, False)
    assert space.collision_slop == float(np.float32(0.1))
    assert LINE["Space.collision_slop"].default == "0.1 m"
    assert math.isinf(space.sleep_time_threshold)
    assert math.isinf(joint.max_bias)
    assert math.isinf(joint.max_force)
    assert abs(joint.error_bias - 0.9**60) < 1e-7
    assert abs(space.collision_bias - 0.9**60) < 1e-7


def test_the_adapter_sets_what_the_audit_says():
    space, bodies, _ = space_of(SCENE)
    rod, spring, friction = space.constraints
    assert (space.damping, space.collision_slop) == (1.0, 0.0)
    assert math.isinf(space.sleep_time_threshold)
    assert (rod.error_bias, spring.damping, friction.error_bias, friction.max_force) == (
        0.0,
        0.0,
        1.0,
        1.5,
    )
    assert math.isinf(rod.max_bias)
    assert bodies[0].moment == math.inf


@pytest.mark.parametrize(("balls", "planes"), [(1, 1), (2, 0), (2, 1)])
def test_the_product_of_two_shapes_is_the_contact_s_value(balls, planes):
    bodies = [
        Body(
            mass=1.0,
            inertia=(0.4, 0.4, 0.4),
            position=(3.0 * n, 1.0, 0.0),
            shape=Sphere(radius=1.0),
        )
        for n in range(balls)
    ]
    law = Contact(law="rigid", friction=0.75, restitution=0.3)
    space, moving, _ = space_of(Scene.of(bodies, [law, *[Plane(normal=(0.0, 1.0, 0.0))] * planes]))
    for one, other in combinations(space.shapes, 2):
        unit = 0.0 if balls == 1 else 2e-15  # the square of a rounded root is not exact
        assert abs(one.friction * other.friction - 0.75) <= unit
        assert abs(one.elasticity * other.elasticity - 0.3) <= unit
    assert len(space.shapes) == balls + planes
    assert len(moving) == balls


@pytest.mark.parametrize("value", [0.0, 0.1, 0.3, 0.75, 1.0])
def test_a_block_alone_feels_exactly_the_friction_of_the_law(value):
    of_shapes, of_walls = factors(value, is_alone=True)
    assert of_shapes * of_walls == value


def test_a_block_that_friction_just_holds_stays_where_it_is():
    instance = discovery.case("block-on-slope").at(
        duration="16", samples="16"
    )  # of 3 in 4, with friction 3/4
    run, _ = ENGINE.run(
        Request(problem=instance.problem, method="semi-implicit-euler", step=2.0**-10)
    )
    assert np.abs(run.position[1:, 0, 0]).max() < 1e-20
    assert not run.velocity[1:, 0, 0].any()
