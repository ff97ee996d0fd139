"""Contact between the scene's shapes: geoms, planes, and the parameters of the law of each pair."""

from itertools import chain, combinations, product
from typing import Any

import numpy as np

from refdem.engines.mujoco import shapes, solver
from refdem.scene import Point, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.shapes import extent

TORSION_AND_ROLLING = (0.005, 0.0001)
"""MuJoCo's default coefficients [m], which count where condim is above its default of 3."""


def add(
    mujoco: Any, spec: Any, scene: Scene, mj_bodies: list[Any], step: float, *, tuned: bool
) -> None:
    """Gives the bodies of MuJoCo (MjsBody) their geoms, the world its planes, and both the scene's
    contact law, if it has one; unless tuned, its coefficient of friction and no more.

    A law with friction belongs to pairs of geoms, any other one to the geoms themselves.
    """
    for law in scene.all(Contact):
        by_pairs = tuned and rubs(scene, law)
        if not tuned:
            parameters = {"friction": (law.friction, *TORSION_AND_ROLLING)}
        elif by_pairs:
            parameters = {}
        else:
            parameters = solver.contact(scene, law, step, _size(scene))
        geoms = []
        for number, shape in enumerate(scene.bodies.shape):
            if not isinstance(shape, Point):
                attributes = parameters | {"name": f"shape {number}"}
                geoms.append(shapes.add_shape(mujoco, mj_bodies[number], shape, attributes))
        planes = []
        for number, plane in enumerate(scene.all(Plane)):
            attributes = parameters | {"name": f"plane {number}"}
            planes.append(shapes.add_plane(mujoco, spec.worldbody, plane, attributes))
        if not by_pairs:
            continue
        if law.law == "linear":
            pair = solver.linear_rubbing(scene, law, step)
        else:
            pair = solver.rubbing(law.friction, step, _size(scene))
        for one, other in chain(combinations(geoms, 2), product(geoms, planes)):
            spec.add_pair(geomname1=one.name, geomname2=other.name, **pair)


def rubs(scene: Scene, law: Contact) -> bool:
    """True if shapes may slide on one another: something moves, gravity acts along a plane, or
    anything but gravity and contact acts.
    """
    if not law.friction > 0 or not scene.has_shapes():
        return False
    if scene.bodies.velocity.any() or scene.bodies.omega.any():
        return True
    if any(not isinstance(element, Contact | Plane | UniformGravity) for element in scene.elements):
        return True
    for field in scene.all(UniformGravity):
        g = np.array(field.g)
        for plane in scene.all(Plane):
            # |n x g| is the part of gravity along the plane.
            if np.linalg.norm(np.cross(plane.normal, g)) > solver.ROUNDING * np.linalg.norm(g):
                return True
    return False


def impedance_of(scene: Scene, law: Contact) -> float:
    """The impedance that the contacts of this law are given."""
    if law.law == "linear":
        return solver.ANY
    if rubs(scene, law):
        return solver.SLIDING
    return solver.HARDEST


def _size(scene: Scene) -> float:
    """A distance from the origin [m] beyond which no part of any body is."""
    farthest = float(np.linalg.norm(scene.bodies.position, axis=1).max())
    return farthest + max(extent(shape) for shape in scene.bodies.shape)
