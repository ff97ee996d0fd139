"""Tests of scenes in which a rigid sphere lies on a plane, for the transparent engine."""

import numpy as np

from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

ASKEW = 1e-12
"""Largest relative component of a slip across the slope, or of a position off the plane, that is
round-off of a rotated scene.
"""


def starts_on_plane(scene: Scene) -> bool:
    """True if one sphere under the rigid law touches one plane at the start, has no velocity along
    the normal, and is pressed on the plane by gravity.
    """
    laws = scene.all(Contact)
    planes = scene.all(Plane)
    bodies = scene.bodies
    if len(laws) != 1 or laws[0].law != "rigid" or len(planes) != 1 or len(bodies) != 1:
        return False
    normal = np.array(planes[0].normal)
    gravity = np.sum([np.zeros(3), *(np.array(g.g) for g in scene.all(UniformGravity))], axis=0)
    # The sphere touches where (r - p) . n = R, and is pressed on the plane if g . n < 0.
    height = float((bodies.position[0] - np.array(planes[0].point)) @ normal)
    size = max(float(np.abs(bodies.position).max()), float(bodies.radius[0]))
    touches = abs(height - float(bodies.radius[0])) <= ASKEW * size
    speed = float(np.linalg.norm(bodies.velocity[0]))
    crosses = abs(float(bodies.velocity[0] @ normal)) > ASKEW * speed
    return bool(bodies.radius[0] > 0 and touches and not crosses and gravity @ normal < 0)


def leaves_its_line(scene: Scene) -> bool:
    """True if the slip of a sphere on a slope has a component across the slope. Its direction then
    changes, and no mode with a constant direction of friction describes it.
    """
    bodies = scene.bodies
    normal = np.array(scene.all(Plane)[0].normal)
    gravity = np.sum([np.array(g.g) for g in scene.all(UniformGravity)], axis=0)
    # Along the plane, gravity is g - (g . n) n, and the slip at the point of contact -R n is v -
    # (v . n) n - R omega x n.
    along = gravity - (gravity @ normal) * normal
    velocity = bodies.velocity[0]
    surface = float(bodies.radius[0]) * np.cross(bodies.omega[0], normal)
    slip = velocity - (velocity @ normal) * normal - surface
    speeds = float(np.linalg.norm(velocity) + np.linalg.norm(surface))
    steep = float(np.linalg.norm(along))
    is_level = steep <= ASKEW * float(np.linalg.norm(gravity))
    across = float(np.linalg.norm(np.cross(slip, along)))
    return not is_level and across > ASKEW * steep * speeds
