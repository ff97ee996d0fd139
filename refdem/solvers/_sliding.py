"""Sliding friction without a tangential spring: tests whether the slip stays in one plane.

In a plane the slip velocity passes through zero when it ends. Otherwise its direction changes
as it ends, and it is not a smooth function of time there.
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
"""Largest relative component off the plane: round-off of a scene that was rotated."""


def unsupported(scene: Scene) -> str | None:
    """The reason if a slip may begin or end outside of any plane, so that no method keeps an order
    above 2; else None.
    """
    law = _particles.contact_of(scene)
    if law is None or law.friction == 0 or law.tangential_stiffness > 0 or _in_a_plane(scene):
        return None
    return (
        "friction without a tangential spring on a slip that leaves its plane, where its end is no"
        " smooth point of the motion"
    )


def _in_a_plane(scene: Scene) -> bool:
    """True if one plane contains the normals, relative velocities and loads of all pairs, and all
    spins are perpendicular to it.
    """
    spins = scene.bodies.omega[scene.bodies.radius > 0]
    loads = _directions(scene)
    normals = _normals(scene)
    vectors = [vector for vector in (*normals, *loads) if np.any(vector)]
    directions: list[Array] = [vector / float(np.linalg.norm(vector)) for vector in vectors]
    perpendicular = np.cross(directions[0], directions)
    longest = perpendicular[np.argmax(np.linalg.norm(perpendicular, axis=1))]
    if np.linalg.norm(longest) <= ASKEW:
        # All directions are collinear. The plane then contains that line, and its normal is the
        # direction of the spins across it.
        perpendicular_spins: list[Array] = [
            spin - float(spin @ directions[0]) * directions[0] for spin in spins
        ]
        longest = max(perpendicular_spins, key=lambda spin: float(np.linalg.norm(spin)))
        # The spins are along the line too, so that any plane through the line can be chosen.
        if np.linalg.norm(longest) <= ASKEW * max(float(np.linalg.norm(spins)), 1e-300):
            return True
    normal = longest / np.linalg.norm(longest)
    in_plane_spin = np.linalg.norm(spins - np.outer(spins @ normal, normal), axis=1)
    is_flat = np.all(np.abs(directions @ normal) <= ASKEW)
    spins_across = np.all(in_plane_spin <= ASKEW * np.linalg.norm(spins))
    return bool(is_flat and spins_across)


def _normals(scene: Scene) -> list[Array]:
    """Normals (3,) of every pair that may be in contact, not normalised, and of planes."""
    position = scene.bodies.position
    planes = scene.all(Plane)
    normals = []
    for i, j in _particles.pairs(scene):
        if j < 0:
            normals.append(np.array(planes[-1 - j].normal))
        else:
            normals.append(position[j] - position[i])
    return normals


def _directions(scene: Scene) -> list[Array]:
    """Relative velocities of all pairs, and directions of the loads, each (3,), not normalised."""
    bodies = scene.bodies
    directions = []
    for i, j in _particles.pairs(scene):
        if j < 0:
            other_velocity = 0.0
        else:
            other_velocity = bodies.velocity[j]
        directions.append(bodies.velocity[i] - other_velocity)
    for spring in scene.all(Spring):
        if spring.b < 0:
            end = np.array(spring.anchor_b)
        else:
            end = bodies.position[spring.b]
        directions.append(bodies.position[spring.a] - end)
    directions += [np.array(gravity.g) for gravity in scene.all(UniformGravity)]
    if scene.all(CentralField):
        directions += list(bodies.position)
    return directions
