"""Scenes in which one rigid sphere lies on one plane: the slip of its point of contact.

Notation: n is the normal of the plane, R the radius, and R n x m v + J omega the angular momentum
about the point of contact, through which every contact force passes.
"""

import numpy as np

from refdem.core.check import Array
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

ROUNDED = 1e-12
"""Bound on the distance of a sphere from its plane, relative to the largest length, and on its
velocity across the plane, relative to its speed, that are 0 but for rounding. It allows for the
rounding of a scene that was rotated.
"""


def gravity_of(scene: Scene) -> Array:
    """The sum of all uniform gravity (3,) [m/s^2]."""
    fields = [np.array(field.g) for field in scene.all(UniformGravity)]
    total: Array = np.sum([np.zeros(3), *fields], axis=0)
    return total


def starts_on_plane(scene: Scene) -> bool:
    """One sphere touches one plane under the rigid law, does not move across it, and gravity alone
    presses it there.
    """
    kinds = sorted({element.kind for element in scene.elements})
    if kinds != ["contact", "plane", "uniform_gravity"] or len(scene.bodies) != 1:
        return False
    laws = scene.all(Contact)
    planes = scene.all(Plane)
    bodies = scene.bodies
    if len(laws) != 1 or laws[0].law != "rigid" or len(planes) != 1 or not bodies.radius[0] > 0:
        return False
    normal = np.array(planes[0].normal)
    height = float((bodies.position[0] - np.array(planes[0].point)) @ normal)
    size = max(float(np.abs(bodies.position).max()), float(bodies.radius[0]))
    touches = abs(height - float(bodies.radius[0])) <= ROUNDED * size
    speed = float(np.linalg.norm(bodies.velocity[0]))
    stays = abs(float(bodies.velocity[0] @ normal)) <= ROUNDED * speed
    return bool(touches and stays and gravity_of(scene) @ normal < 0)


def slip_at_start(scene: Scene) -> tuple[Array, Array]:
    """The slip s = v + omega x (-R n) (3,) [m/s] at the start and, while it lasts, its rate (3,)
    [m/s^2].

    s' = g_t - mu g_n (1 + m R^2/J) s/|s|, with gravity's parts g_t along the plane and g_n on it.
    """
    # s = v - R omega x n,  g_n = -g.n,  g_t = g + g_n n
    bodies = scene.bodies
    law = scene.all(Contact)[0]
    normal = np.array(scene.all(Plane)[0].normal)
    radius = float(bodies.radius[0])
    slip: Array = bodies.velocity[0] - radius * np.cross(bodies.omega[0], normal)
    gravity = gravity_of(scene)
    pressing = -float(gravity @ normal)
    along: Array = gravity + pressing * normal
    size = float(np.linalg.norm(slip))
    if size == 0.0:
        return slip, along
    # s' = g_t - mu g_n (1 + m R^2/J) s/|s|: friction acts on v, and by its torque on omega.
    leverage = 1 + float(bodies.mass[0]) * radius**2 / float(bodies.inertia[0, 0])
    return slip, along - law.friction * pressing * leverage * slip / size


def moment(scene: Scene, velocity: Array, omega: Array) -> Array:
    """R n x m v + J (omega - (omega.n) n) (T, 3) [kg m^2/s] of velocities and spins (T, 3): the
    angular momentum about the point of contact without its component along the normal.
    """
    bodies = scene.bodies
    normal = np.array(scene.all(Plane)[0].normal)
    mass = float(bodies.mass[0])
    orbital = float(bodies.radius[0]) * mass * np.cross(normal, velocity)
    across = omega - (omega @ normal)[:, None] * normal
    total: Array = orbital + float(bodies.inertia[0, 0]) * across
    return total


def moment_of_gravity(scene: Scene) -> Array:
    """The rate R n x m g (3,) [N m] of the moment, to which contact forces do not contribute."""
    bodies = scene.bodies
    normal = np.array(scene.all(Plane)[0].normal)
    rate: Array = float(bodies.radius[0] * bodies.mass[0]) * np.cross(normal, gravity_of(scene))
    return rate
