"""Sliding friction without a tangential spring: does the slip stay on one line, so that its end is
a zero that it passes?
"""

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _particles

Array = NDArray[np.float64]

ASKEW = 1e-12
"""Part of a vector that may point off the plane: round-off of a scene turned into some other
direction.
"""


def unsupported(scene: Scene) -> str | None:
    """None unless slip may end, or begin, out of any plane: its direction there is no smooth
    function of time, and no method that takes it for one keeps an order above 2."""
    law = _particles.contact_of(scene)
    if law is None or law.friction == 0 or law.tangential_stiffness > 0 or _in_a_plane(scene):
        return None
    return (
        "friction without a tangential spring on a slip that leaves its plane, where its end is no"
        " smooth point of the motion"
    )


def _in_a_plane(scene: Scene) -> bool:
    """Some plane holds normals, motion and loads of all pairs, with every spin across it."""
    spins = scene.bodies.omega[scene.bodies.radius > 0]
    loads = _directions(scene)
    normals = _normals(scene)
    vectors = [vector for vector in (*normals, *loads) if np.any(vector)]
    flat: list[Array] = [vector / float(np.linalg.norm(vector)) for vector in vectors]
    across = np.cross(flat[0], flat)
    widest = across[np.argmax(np.linalg.norm(across, axis=1))]
    if np.linalg.norm(widest) <= ASKEW:  # all on one line: the spins say across which plane
        turning: list[Array] = [spin - float(spin @ flat[0]) * flat[0] for spin in spins]
        widest = max(turning, key=lambda spin: float(np.linalg.norm(spin)))
        if np.linalg.norm(widest) <= ASKEW * max(float(np.linalg.norm(spins)), 1e-300):
            return True
    normal = widest / np.linalg.norm(widest)
    aside = np.linalg.norm(spins - np.outer(spins @ normal, normal), axis=1)
    is_flat = np.all(np.abs(flat @ normal) <= ASKEW)
    spins_across = np.all(aside <= ASKEW * np.linalg.norm(spins))
    return bool(is_flat and spins_across)


def _normals(scene: Scene) -> list[Array]:
    """The normals (3,) of every pair that may meet, from body to body, and of planes."""
    places = scene.bodies.position
    planes = scene.all(Plane)
    found = []
    for i, j in _particles.pairs(scene):
        if j < 0:
            found.append(np.array(planes[-1 - j].normal))
        else:
            found.append(places[j] - places[i])
    return found


def _directions(scene: Scene) -> list[Array]:
    """Along which pairs move, and loads pull."""
    bodies = scene.bodies
    found = []
    for i, j in _particles.pairs(scene):
        if j < 0:
            other = 0.0
        else:
            other = bodies.velocity[j]
        found.append(bodies.velocity[i] - other)
    for spring in scene.all(Spring):
        if spring.b < 0:
            end = np.array(spring.anchor_b)
        else:
            end = bodies.position[spring.b]
        found.append(bodies.position[spring.a] - end)
    found += [np.array(gravity.g) for gravity in scene.all(UniformGravity)]
    if scene.all(CentralField):
        found += list(bodies.position)
    return found
