"""Contact between the scene's shapes: geoms, planes, and what each pair of them is told of the
law.
"""

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


def add(mujoco: Any, spec: Any, scene: Scene, said: list[Any], step: float, *, tuned: bool) -> None:
    """Gives the bodies of MuJoCo their geoms, the world its planes, and both the scene's contact
    law, if it has one; as shipped, its coefficient of friction and no more.
    """
    for law in scene.all(Contact):
        friction = tuned and rubs(scene, law)
        if not tuned:
            words = {"friction": (law.friction, *TORSION_AND_ROLLING)}
        elif friction:
            words = {}
        else:
            words = solver.contact(scene, law, step, _size(scene))
        geoms = [
            shapes.add_shape(mujoco, body, shape, words | {"name": f"shape {number}"})
            for number, (body, shape) in enumerate(zip(said, scene.bodies.shape, strict=True))
            if not isinstance(shape, Point)
        ]
        planes = [
            shapes.add_plane(mujoco, spec.worldbody, plane, words | {"name": f"plane {number}"})
            for number, plane in enumerate(scene.all(Plane))
        ]
        if not friction:
            continue
        if law.law == "linear":
            pair = solver.linear_rubbing(scene, law, step)
        else:
            pair = solver.rubbing(law.friction, step, _size(scene))
        for one, other in chain(combinations(geoms, 2), product(geoms, planes)):
            spec.add_pair(geomname1=one.name, geomname2=other.name, **pair)


def rubs(scene: Scene, law: Contact) -> bool:
    """Shapes may slide on one another: something moves, or gravity acts along a plane."""
    if not law.friction > 0 or not scene.has_shapes():
        return False
    pulls = [np.array(gravity.g) for gravity in scene.all(UniformGravity)]
    along = [
        np.linalg.norm(np.cross(plane.normal, g)) > solver.ROUNDING * np.linalg.norm(g)
        for plane in scene.all(Plane)
        for g in pulls
    ]
    return any(along) or bool(scene.bodies.velocity.any() or scene.bodies.omega.any())


def impedance_of(scene: Scene, law: Contact) -> float:
    """The impedance that the contacts of this law are given."""
    if law.law == "linear":
        return solver.ANY
    if rubs(scene, law):
        return solver.SLIDING
    return solver.HARDEST


def _size(scene: Scene) -> float:
    """How far from the origin [m] anything of a body is."""
    return float(np.linalg.norm(scene.bodies.position, axis=1).max()) + max(
        extent(shape) for shape in scene.bodies.shape
    )
