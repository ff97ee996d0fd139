"""What Chipmunk says by functions that it calls in every step: friction that depends on the speed,
forces that follow the clock.
"""

from math import cos

import pymunk
from pymunk._chipmunk_cffi import lib as engine

from refdem.scene import Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider


def rubbing(joint: pymunk.Constraint, link: Slider) -> pymunk.Constraint:
    """The joint as friction: it holds up to Coulomb's limit, or before each step up to the friction
    at the speed that there is then.
    """
    (x, y) = link.axis[:2]
    load = link.normal_force
    joint.max_force = load * link.coefficient(0.0)
    joint.error_bias = 1.0

    def limited(joint: pymunk.Constraint, space: pymunk.Space) -> None:
        apart = joint.a.velocity - joint.b.velocity
        joint.max_force = load * link.coefficient(abs(x * apart.x + y * apart.y))

    if link.law != "coulomb":
        joint.pre_solve = limited
    return joint


def drive(
    space: pymunk.Space, scene: Scene, bodies: list[pymunk.Body], start: float, step: float
) -> None:
    """Forces act where Chipmunk updates a velocity: at the end of the step, where the positions
    already are.
    """
    for number, body in enumerate(bodies):
        forces = [force for force in scene.all(Force) if force.a == number]
        if forces:
            _push(space, body, forces, start, step)


def _push(
    space: pymunk.Space, body: pymunk.Body, forces: list[Force], start: float, step: float
) -> None:
    """Applies these forces [N] to one body; Chipmunk has counted the step that it is in."""

    def updated(body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
        t = start + step * engine.cpSpaceGetTimestamp(space._space)
        sizes = [force.amplitude * cos(force.frequency * t + force.phase) for force in forces]
        x, y = (
            sum(size * force.axis[k] for size, force in zip(sizes, forces, strict=True))
            for k in (0, 1)
        )
        body.force = (x, y)
        pymunk.Body.update_velocity(body, gravity, damping, dt)

    body.velocity_func = updated
