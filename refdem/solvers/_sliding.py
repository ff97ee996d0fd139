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


def refusal(scene: Scene) -> str | None:
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
    flat: list[Array] = [
        vector / float(np.linalg.norm(vector)) for vector in (*normals, *loads) if np.any(vector)
    ]
    across = np.cross(flat[0], flat)
    widest = across[np.argmax(np.linalg.norm(across, axis=1))]
    if np.linalg.norm(widest) <= ASKEW:  # all on one line: the spins say across which plane
        turning: list[Array] = [spin - float(spin @ flat[0]) * flat[0] for spin in spins]
        widest = max(turning, key=lambda spin: float(np.linalg.norm(spin)))
        if np.linalg.norm(widest) <= ASKEW * max(float(np.linalg.norm(spins)), 1e-300):
            return True
    normal = widest / np.linalg.norm(widest)
    aside = np.linalg.norm(spins - np.outer(spins @ normal, normal), axis=1)
    return bool(
        np.all(np.abs(flat @ normal) <= ASKEW) and np.all(aside <= ASKEW * np.linalg.norm(spins))
    )


def _normals(scene: Scene) -> list[Array]:
    """From body to body, and of planes, of every pair that may meet."""
    places = scene.bodies.position
    planes = scene.all(Plane)
    return [
        np.array(planes[-1 - j].normal) if j < 0 else places[j] - places[i]
        for i, j in _particles.pairs(scene)
    ]


def _directions(scene: Scene) -> list[Array]:
    """Along which pairs move, and loads pull."""
    bodies = scene.bodies
    moving = [
        bodies.velocity[i] - (0.0 if j < 0 else bodies.velocity[j])
        for i, j in _particles.pairs(scene)
    ]
    pulls = [
        bodies.position[s.a] - (np.array(s.anchor_b) if s.b < 0 else bodies.position[s.b])
        for s in scene.all(Spring)
    ]
    falls = [np.array(gravity.g) for gravity in scene.all(UniformGravity)]
    return [*moving, *pulls, *falls, *(bodies.position if scene.all(CentralField) else ())]
