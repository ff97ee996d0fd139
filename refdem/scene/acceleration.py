"""Accelerations of points by the forces of a scene, as an integrator of one's own asks for them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Scene
from refdem.scene.element import Element, Link
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
Acceleration = Callable[[float, Array, Array], Array]
"""a(t, r, v) (N, 3) [m/s^2] of all bodies, at a time t [s], places r (N, 3) [m] and velocities v
(N, 3) [m/s]."""
LINKS = (Spring, Dashpot, RotatingDashpot, Drag, Force)
FIELDS = (CentralField, UniformGravity, PiecewiseField)


def lacking(scene: Scene) -> str | None:
    """None if every force of the scene acts on points and depends on t, r and v alone, else what
    does not.
    """
    if "rotation" in scene.features:
        return "bodies that turn"
    for element in scene.elements:
        if not isinstance(element, (*LINKS, *FIELDS)):
            return f"the element {element.kind}"
        if isinstance(element, Link) and not element.has_central_anchors():
            return f"a {element.kind} off the centre of a body"
    return None


def acceleration(scene: Scene) -> Acceleration:
    """The accelerations of a scene of which nothing is `lacking`; fixed bodies have none."""
    mass = scene.bodies.mass[:, None]
    moves = ~scene.bodies.fixed[:, None]

    def of(t: float, r: Array, v: Array) -> Array:
        force = np.zeros_like(r)
        for element in scene.elements:
            _add(element, force, mass, t, r, v)
        return np.where(moves, force / mass, 0.0)

    return of


def _add(element: Element, force: Array, mass: Array, t: float, r: Array, v: Array) -> None:
    """Adds the force of one element to those (N, 3) [N] on all bodies."""
    if isinstance(element, UniformGravity):
        force += mass * np.array(element.g)
    elif isinstance(element, CentralField):
        # F = -gm m r/|r|^3.
        force -= element.gm * mass * r / np.linalg.norm(r, axis=1, keepdims=True) ** 3
    elif isinstance(element, PiecewiseField):
        axis = np.array(element.axis)
        s = (r - np.array(element.point)) @ axis
        force += element.force(s)[:, None] * axis
    elif isinstance(element, Link):
        on_a = _on_first(element, t, r, v)
        force[element.a] += on_a
        if element.b >= 0:
            force[element.b] -= on_a


def _on_first(link: Link, t: float, r: Array, v: Array) -> Array:
    """The force (3,) [N] of a link on its first body; d is the branch from its other end, w the
    velocity against it.
    """
    d = r[link.a] - np.array(link.anchor_b)
    w = v[link.a]
    if link.b >= 0:
        d = r[link.a] - r[link.b]
        w = w - v[link.b]
    distance = np.linalg.norm(d)
    force = np.zeros(3)
    if isinstance(link, Spring) and distance > 0:  # without a length it has no direction
        force = -link.pull(np.array(distance - link.length)) * d / distance
    elif isinstance(link, Dashpot):
        force = -(link.damping + link.van_der_pol * distance**2) * w
    elif isinstance(link, RotatingDashpot):
        force = -link.damping * (w - np.cross(np.array(link.rate), d))
    elif isinstance(link, Drag):
        force = -link.coefficient * np.linalg.norm(w) * w
    elif isinstance(link, Force):
        force = link.strength(np.array(t)) * np.array(link.axis)
    return force
