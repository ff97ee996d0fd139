"""The audit of defaults says what the installed pymunk comes with and what the adapter sets."""

import math

import numpy as np
import pymunk

from refdem.engines.pymunk import ENGINE
from refdem.engines.pymunk.space import space_of
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

LINE = {setting.setting: setting for setting in ENGINE.audit}
SCENE = Scene.of(
    [Body(mass=1.0, position=(1.0, 0.0, 0.0))],
    [Rod(a=0, length=1.0), Spring(a=0, stiffness=1.0), Slider(a=0, friction=0.5, normal_force=3.0)],
)


def test_pymunk_comes_with_what_the_audit_says():
    space, joint = pymunk.Space(), pymunk.PinJoint(pymunk.Body(1, 1), pymunk.Body(1, 1))
    assert (space.damping, space.iterations, space.threaded) == (1.0, 10, False)
    assert space.collision_slop == float(np.float32(0.1))
    assert LINE["Space.collision_slop"].default == "0.1 m"
    assert math.isinf(space.sleep_time_threshold)
    assert math.isinf(joint.max_bias)
    assert math.isinf(joint.max_force)
    assert abs(joint.error_bias - 0.9**60) < 1e-8
    assert abs(space.collision_bias - 0.9**60) < 1e-8


def test_the_adapter_sets_what_the_audit_says():
    space, bodies = space_of(SCENE)
    rod, spring, friction = space.constraints
    assert (space.damping, space.collision_slop) == (1.0, 0.0)
    assert math.isinf(space.sleep_time_threshold)
    assert (rod.error_bias, spring.damping, friction.error_bias, friction.max_force) == (0.0, 0.0, 1.0, 1.5)
    assert math.isinf(rod.max_bias)
    assert bodies[0].moment == math.inf


def test_the_product_of_two_shapes_is_the_contact_s_value():
    ball = Body(mass=1.0, inertia=(0.4, 0.4, 0.4), shape=Sphere(radius=1.0))
    space, _ = space_of(Scene.of([ball], [Contact(law="rigid", friction=0.3, restitution=0.5)]))
    (shape,) = space.shapes
    assert abs(shape.friction**2 - 0.3) < 1e-15
    assert abs(shape.elasticity**2 - 0.5) < 1e-15
