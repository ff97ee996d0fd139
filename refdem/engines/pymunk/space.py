"""A scene as Chipmunk's space with its bodies and joints."""

from math import exp
from typing import Any

import numpy as np
import pymunk

from refdem.engines.pymunk.callbacks import rubbing
from refdem.engines.pymunk.shapes import add_shapes
from refdem.engines.pymunk.springs import add_soft_contacts, bent
from refdem.engines.pymunk.unsupported import fading
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

COUPLED_ITERATIONS = 200
"""Passes over joints and contacts that share bodies: Gauss-Seidel needs many to come near
round-off.
"""


def space_of(scene: Scene, *, is_tuned: bool = True) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """The space and its bodies, in the scene's order; with pymunk's own slop, iterations and pull
    on joints unless it is tuned.
    """
    space = pymunk.Space()
    # Chipmunk's damping is the factor on all velocities in a second, exp(-rate).
    rate = fading(scene) or 0.0
    space.damping = exp(-rate)
    # The total of all uniform fields in the plane; zero without one.
    gravity = np.zeros(2)
    for field in scene.all(UniformGravity):
        gravity += field.g[:2]
    space.gravity = (float(gravity[0]), float(gravity[1]))
    bodies = [_body(scene, number) for number in range(len(scene.bodies))]
    space.add(*bodies)
    links = [element for element in scene.elements if isinstance(element, Spring | Rod | Slider)]
    joints = [
        _joint(space, bodies, link, is_tuned=is_tuned)
        for link in links
        if not all(_is_still(scene, end) for end in (link.a, link.b))
    ]
    space.add(*joints)
    # Springs are forces; all other joints are constraints that the solver iterates over.
    solved = sum(not isinstance(joint, pymunk.DampedSpring) for joint in joints)
    touching = add_shapes(space, scene, bodies)
    add_soft_contacts(space, scene, bodies)
    if is_tuned:
        _tune(space, is_one_joint=solved <= 1 and not touching)
    return space, bodies


def _tune(space: pymunk.Space, *, is_one_joint: bool) -> None:
    """Takes out what pymunk's defaults do to the mechanics of a scene."""
    space.collision_slop = 0.0
    space.sleep_time_threshold = float("inf")
    # One joint is solved exactly in one pass.
    space.iterations = COUPLED_ITERATIONS
    if is_one_joint:
        space.iterations = 1


def angle_of(attitude: Any) -> Any:
    """Angle [rad] about z of attitudes (..., 4) that turn about z alone."""
    return 2.0 * np.arctan2(attitude[..., 3], attitude[..., 0])


def _body(scene: Scene, number: int) -> pymunk.Body:
    """One body: J3 is its moment; a point does not turn."""
    column = scene.bodies
    if column.fixed[number]:
        body = pymunk.Body(body_type=pymunk.Body.STATIC)
    else:
        # Chipmunk takes no moment of 0; a point that nothing can turn has an infinite one.
        moment = float(column.inertia[number, 2])
        if moment == 0:
            moment = float("inf")
        body = pymunk.Body(float(column.mass[number]), moment)
    body.position = tuple(column.position[number, :2].tolist())
    body.angle = float(angle_of(column.attitude[number]))
    if not column.fixed[number]:
        body.velocity = tuple(column.velocity[number, :2].tolist())
        body.angular_velocity = float(column.omega[number, 2])
    return body


def _belt(space: pymunk.Space, link: Slider) -> pymunk.Body:
    """A body of constant velocity, which no force changes: the belt that the slider rubs on."""
    belt = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    space.add(belt)
    belt.velocity = tuple((link.belt_velocity * np.array(link.axis[:2])).tolist())
    return belt


def _is_still(scene: Scene, end: int) -> bool:
    """True if the end of a link is the world or a fixed body."""
    return end < 0 or bool(scene.bodies.fixed[end])


def _joint(
    space: pymunk.Space,
    bodies: list[pymunk.Body],
    link: Spring | Rod | Slider,
    *,
    is_tuned: bool,
) -> pymunk.Constraint:
    """A spring without damper, a rod without slack, or friction as a joint that holds no more than
    Coulomb's limit.
    """
    a = bodies[link.a]
    b = space.static_body
    if link.b >= 0:
        b = bodies[link.b]
    if isinstance(link, Slider) and link.belt_velocity:
        b = _belt(space, link)
    if isinstance(link, Spring):
        spring = pymunk.DampedSpring(
            a, b, link.anchor_a[:2], link.anchor_b[:2], link.length, link.stiffness, 0.0
        )
        if link.exponent == 1 and not link.quadratic and not link.cubic:
            return spring
        return bent(spring, link)
    if isinstance(link, Rod):
        rod = pymunk.PinJoint(a, b, link.anchor_a[:2], link.anchor_b[:2])
        rod.distance = link.length
        if is_tuned:
            rod.error_bias = 0.0
        return rod
    return rubbing(pymunk.PivotJoint(a, b, (0.0, 0.0), (0.0, 0.0)), link)
