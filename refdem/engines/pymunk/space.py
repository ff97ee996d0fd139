"""A scene as Chipmunk's space with its bodies and joints."""

from collections.abc import Iterator
from math import exp
from typing import Any

import numpy as np
import pymunk

from refdem.engines.pymunk.callbacks import (
    CENTRE,
    Law,
    bent,
    fading_friction,
    pushes,
    soft_contacts,
)
from refdem.engines.pymunk.shapes import add_shapes
from refdem.engines.pymunk.unsupported import fading
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

COUPLED_ITERATIONS = 200
"""Iterations over joints and contacts that share bodies: Gauss-Seidel needs many to converge to
near round-off.
"""


def space_of(
    scene: Scene, *, is_tuned: bool = True
) -> tuple[pymunk.Space, list[pymunk.Body], list[Law]]:
    """The space, its bodies in the scene's order, and the laws that it calls in every step.

    Unless it is tuned, it has pymunk's defaults for collision slop, iterations and the correction
    of joints.
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
    links = [link for link in links if not all(_is_still(scene, end) for end in (link.a, link.b))]
    joints = [_joint(space, bodies, link, is_tuned=is_tuned) for link in links]
    pressing = list(soft_contacts(scene, bodies))
    laws = [law for joint, link in zip(joints, links, strict=True) for law in _laws(joint, link)]
    laws += [*pressing, *pushes(scene, bodies)]
    space.add(*joints)
    touching = add_shapes(space, scene, bodies)
    space.add(*[law.owner for law in pressing])
    if is_tuned:
        _tune(space, is_independent=not touching and _is_independent(scene, links))
    return space, bodies, laws


def _is_independent(scene: Scene, links: list[Spring | Rod | Slider]) -> bool:
    """True if no body is held by two constraints, so that each is solved in one pass.

    Springs are forces; all other joints are constraints that the solver iterates over.
    """
    held = [
        end
        for link in links
        if not isinstance(link, Spring)
        for end in (link.a, link.b)
        if not _is_still(scene, end)
    ]
    return len(held) == len(set(held))


def _tune(space: pymunk.Space, *, is_independent: bool) -> None:
    """Replaces the defaults of pymunk that change the mechanics of a scene."""
    space.collision_slop = 0.0
    space.sleep_time_threshold = float("inf")
    space.iterations = COUPLED_ITERATIONS
    if is_independent:
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
        # Chipmunk accepts no moment of 0; a point that cannot rotate has an infinite one.
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
    """A kinematic body of constant velocity: the belt on which the slider rubs."""
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
        return pymunk.DampedSpring(
            a, b, link.anchor_a[:2], link.anchor_b[:2], link.length, link.stiffness, 0.0
        )
    if isinstance(link, Rod):
        rod = pymunk.PinJoint(a, b, link.anchor_a[:2], link.anchor_b[:2])
        rod.distance = link.length
        if is_tuned:
            rod.error_bias = 0.0
        return rod
    joint = pymunk.PivotJoint(a, b, CENTRE, CENTRE)
    joint.max_force = link.normal_force * link.coefficient(0.0)
    # The bias is the part of an error that remains after a second. With 1, positions are not
    # corrected, because friction has no rest position.
    joint.error_bias = 1.0
    return joint


def _laws(joint: pymunk.Constraint, link: Spring | Rod | Slider) -> Iterator[Law]:
    """The law that a joint does not have by itself, if there is one."""
    if isinstance(link, Spring) and (link.exponent != 1 or link.quadratic or link.cubic):
        yield bent(joint, link)
    if isinstance(link, Slider) and link.law != "coulomb":
        yield fading_friction(joint, link)
