"""Accelerations of points by the forces of a scene, as an integrator of one's own asks for them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene import Scene
from refdem.scene.element import Element, Field, Link

Array = NDArray[np.float64]
Acceleration = Callable[[float, Array, Array], Array]
"""a(t, r, v) (N, 3) [m/s^2] of all bodies, at a time t [s], places r (N, 3) [m] and velocities v
(N, 3) [m/s]."""


def unsupported_feature(scene: Scene) -> str | None:
    """None if every force of the scene acts on points and depends on t, r and v alone, else what
    does not.
    """
    if "rotation" in scene.features:
        return "bodies that turn"
    for element in scene.elements:
        if not isinstance(element, Field) and not (isinstance(element, Link) and element.has_force):
            return f"the element {element.kind}"
        if isinstance(element, Link) and not element.has_central_anchors():
            return f"a {element.kind} off the centre of a body"
    return None


def acceleration(scene: Scene) -> Acceleration:
    """The accelerations of a scene without an `unsupported_feature`; fixed bodies have none."""
    mass = scene.bodies.mass.tolist()
    masses = scene.bodies.mass[:, None]
    moves = ~scene.bodies.fixed[:, None]

    def of(t: float, r: Array, v: Array) -> Array:
        places = [tuple(row) for row in r.tolist()]
        velocities = [tuple(row) for row in v.tolist()]
        forces = [vec.ZERO] * len(mass)
        for element in scene.elements:
            _add(element, forces, t, mass, places, velocities)
        return np.where(moves, np.array(forces) / masses, 0.0)

    return of


def _add(
    element: Element,
    forces: list[Vector],
    t: float,
    mass: list[float],
    places: list[Vector],
    velocities: list[Vector],
) -> None:
    """Adds the force of one element to those [N] on all bodies."""
    if isinstance(element, Field):
        for body, (place, velocity) in enumerate(zip(places, velocities, strict=True)):
            force = element.force(t, mass[body], place, velocity)
            forces[body] = vec.plus(forces[body], force)
    elif isinstance(element, Link):
        force = element.force(t, element.branch(places), element.approach(velocities))
        forces[element.a] = vec.plus(forces[element.a], force)
        if element.b >= 0:
            forces[element.b] = vec.minus(forces[element.b], force)
