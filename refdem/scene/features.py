"""What a scene needs, read off its content; every layer that skips work asks here."""

from typing import TYPE_CHECKING

import numpy as np

from refdem.scene.element import Link
from refdem.scene.shapes import Point, Polyhedron, Sphere

if TYPE_CHECKING:
    from refdem.scene.scene import Scene


ALIGNED = 1e-14
"""Sine of the angle between omega and J omega up to which rounding alone may have parted them."""


def features(scene: "Scene") -> frozenset[str]:
    """Names of what an engine must carry: element kinds, laws, `rotation`, `tumbling`, shapes,
    `dimension:1|2|3`.
    """
    names: set[str] = set()
    for element in scene.elements:
        names |= element.features()
    if scene.has_shapes() and "contact" in names:
        for shape in scene.bodies.shapes:
            if isinstance(shape, Sphere):
                names.add("shape:sphere")
            elif isinstance(shape, Polyhedron):
                names.add("shape:polyhedron")
    if _turns(scene):
        names.add("rotation")
        if _tumbles(scene):
            names.add("tumbling")
    if scene.bodies.fixed.any():
        names.add("fixed")
    names.add(f"dimension:{_dimension(scene)}")
    return frozenset(names)


def _turns(scene: "Scene") -> bool:
    """Some body spins, or something can exert a torque on it."""
    bodies = scene.bodies
    has_inertia = bodies.inertia.any(axis=1) & ~bodies.fixed
    if np.any(bodies.omega[has_inertia]):
        return True
    for element in scene.elements:
        if isinstance(element, Link):
            ends = ((element.a, element.anchor_a), (element.b, element.anchor_b))
            if any(body >= 0 and any(anchor) and has_inertia[body] for body, anchor in ends):
                return True
        if "contact:friction" in element.features() and scene.has_shapes():
            return True
    has_contact = any(element.kind == "contact" for element in scene.elements)
    return has_contact and any(isinstance(shape, Polyhedron) for shape in bodies.shapes)


def _tumbles(scene: "Scene") -> bool:
    """Some spinning body's axis of rotation is not one about which omega stays: Euler's equations
    are needed.
    """
    from refdem.mechanics.quaternion import conjugate, rotated

    bodies = scene.bodies
    body_omega = rotated(conjugate(bodies.attitude), bodies.omega)
    momentum = bodies.inertia * body_omega
    # The gyroscopic torque omega x J omega vanishes about a principal axis.
    torque = np.linalg.norm(np.cross(body_omega, momentum), axis=1)
    size = np.linalg.norm(body_omega, axis=1) * np.linalg.norm(momentum, axis=1)
    return bool(np.any(torque > ALIGNED * size))


def _dimension(scene: "Scene") -> int:
    """1 if all motion is along x, 2 if it is in x-y with turns about z, else 3."""
    bodies = scene.bodies
    vectors = [bodies.position, bodies.velocity]
    for element in scene.elements:
        for name in ("g", "normal", "axis", "anchor_a", "anchor_b"):
            if hasattr(element, name):
                vectors.append(np.asarray(getattr(element, name), float)[None, :])
    stacked = np.concatenate(vectors)
    if np.any(stacked[:, 2]) or np.any(bodies.omega[:, :2]) or np.any(bodies.attitude[:, 1:3]):
        return 3
    if (
        np.any(stacked[:, 1])
        or np.any(bodies.omega)
        or not all(isinstance(s, Point | Sphere) for s in bodies.shapes)
    ):
        return 2
    return 1
