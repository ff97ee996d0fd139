"""Functions that Chipmunk calls in every step: for friction that depends on the speed, and for
forces on a body that depend on the time, its position or its velocity.
"""

from collections.abc import Callable, Iterator
from math import cos, hypot

import pymunk
from pymunk._chipmunk_cffi import lib as engine

from refdem.engines.pymunk.unsupported import fading
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.slider import Slider

Planar = tuple[float, float]
BodyForce = Callable[[float, pymunk.Body], Planar]
"""The force (x, y) [N] on a body at a time [s]; the body tells its place and velocity."""


def rubbing(joint: pymunk.Constraint, link: Slider) -> pymunk.Constraint:
    """The joint as dry friction: its force is at most f(u) N, f being the coefficient at speed u.

    Coulomb's limit is constant. A limit that depends on the speed is set anew before each step, for
    the speed that the bodies have then.
    """
    (x, y) = link.axis[:2]
    load = link.normal_force
    joint.max_force = load * link.coefficient(0.0)
    # 1 a second leaves the distance as it is: friction has no memory of a place to go back to.
    joint.error_bias = 1.0

    def limited(joint: pymunk.Constraint, space: pymunk.Space) -> None:
        relative = joint.a.velocity - joint.b.velocity
        speed = abs(x * relative.x + y * relative.y)
        joint.max_force = load * link.coefficient(speed)

    if link.law != "coulomb":
        joint.pre_solve = limited
    return joint


def drive(
    space: pymunk.Space, scene: Scene, bodies: list[pymunk.Body], start: float, step: float
) -> None:
    """Sets a velocity function on every body that a force from outside acts on.

    Chipmunk calls it where it updates a velocity, after it has moved the body: the force is that at
    the new place and at the end of the step, with the velocity of its beginning.
    """
    for number, body in enumerate(bodies):
        forces = list(_forces_on(scene, number))
        if forces and not scene.bodies.fixed[number]:
            _push(space, body, forces, start, step)


def _forces_on(scene: Scene, number: int) -> Iterator[BodyForce]:
    """The forces from outside on one body: drives, fields, and dashpots that `Space.damping` cannot
    say.
    """
    mass = float(scene.bodies.mass[number])
    for element in scene.elements:
        if isinstance(element, Force) and element.a == number:
            yield _periodic(element)
        elif isinstance(element, CentralField):
            yield _attraction(element, mass)
        elif isinstance(element, PiecewiseField):
            yield _slope(element)
        elif isinstance(element, Dashpot) and element.a == number and fading(scene) is None:
            yield _resistance(element)


def _periodic(drive: Force) -> BodyForce:
    """F = amplitude cos(frequency t + phase) along the axis."""
    (x, y) = drive.axis[:2]

    def force(t: float, body: pymunk.Body) -> Planar:
        strength = drive.amplitude * cos(drive.frequency * t + drive.phase)
        return strength * x, strength * y

    return force


def _attraction(field: CentralField, mass: float) -> BodyForce:
    """F = -gm m r/|r|^3 towards the origin."""

    def force(t: float, body: pymunk.Body) -> Planar:
        (x, y) = body.position
        distance = hypot(x, y)
        pull = -field.gm * mass / (distance * distance * distance)
        return pull * x, pull * y

    return force


def _slope(field: PiecewiseField) -> BodyForce:
    """F(s) along the axis, s = (r - point).axis: k1 (s - x1) up to s = 0, then k2 (s - x2)."""
    (axis_x, axis_y) = field.axis[:2]
    (point_x, point_y) = field.point[:2]

    def force(t: float, body: pymunk.Body) -> Planar:
        (x, y) = body.position
        s = (x - point_x) * axis_x + (y - point_y) * axis_y
        if s <= 0:
            strength = field.k1 * max(s - field.x1, 0.0)
        else:
            strength = field.k2 * min(s - field.x2, 0.0)
        return strength * axis_x, strength * axis_y

    return force


def _resistance(dashpot: Dashpot) -> BodyForce:
    """F = -(damping + van_der_pol d^2) v, where d is the distance from the dashpot's other end."""
    (anchor_x, anchor_y) = dashpot.anchor_b[:2]

    def force(t: float, body: pymunk.Body) -> Planar:
        (x, y) = body.position
        (v_x, v_y) = body.velocity
        distance_squared = (x - anchor_x) ** 2 + (y - anchor_y) ** 2
        coefficient = dashpot.damping + dashpot.van_der_pol * distance_squared
        return -coefficient * v_x, -coefficient * v_y

    return force


def _push(
    space: pymunk.Space, body: pymunk.Body, forces: list[BodyForce], start: float, step: float
) -> None:
    """Applies these forces to one body; Chipmunk has counted the step that it is in."""

    def updated(body: pymunk.Body, gravity: Planar, damping: float, dt: float) -> None:
        t = start + step * engine.cpSpaceGetTimestamp(space._space)
        components = [force(t, body) for force in forces]
        body.force = (sum(x for x, _ in components), sum(y for _, y in components))
        pymunk.Body.update_velocity(body, gravity, damping, dt)

    body.velocity_func = updated
