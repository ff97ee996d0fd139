"""Velocity Verlet with steps of one size for spheres that touch without friction, as DEM codes take
them: a contact begins and ends within a step.

The reference's method of that name ends its steps where a contact begins or ends, and errs less.
"""

from collections.abc import Callable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from refdem.core.trajectory import Trajectory
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.scene import Scene
from refdem.scene.shapes import Sphere

Array = NDArray[np.float64]
Forces = Callable[[Array, Array], Array]
"""F(r, v) (N, 3) [N] at places and velocities (N, 3)."""
TAKEN = (Contact, Plane, UniformGravity)
"""Elements whose forces are computed here."""


def unsupported_feature(scene: Scene) -> str | None:
    """None if the scene is of spheres that do not turn, under normal forces and weight; else what
    it has besides.
    """
    if not all(isinstance(shape, Sphere) for shape in scene.bodies.shape):
        return "bodies that are no spheres"
    if any(isinstance(element, Contact) and element.friction > 0 for element in scene.elements):
        return "friction"
    if np.any(scene.bodies.omega):
        return "spin"
    others = [element.kind for element in scene.elements if not isinstance(element, TAKEN)]
    if others:
        return f"the element {others[0]}"
    return None


def run(scene: Scene, times: Array, steps: int) -> Trajectory:
    """The motion at equidistant times (T,) [s], with so many steps between two, of a scene
    without an `unsupported_feature`.

        v += h/2 F(r, v)/m,   r += h v,   v += h/2 F(r, v)/m        (Swope et al. 1982)

    The force after the drift takes the velocity of the half step, and serves the next step too, as
    in LAMMPS.
    """
    bodies = scene.bodies
    step = float(times[1] - times[0]) / steps
    # h/(2 m); fixed bodies are not kicked.
    half = np.where(bodies.fixed, 0.0, step / 2 / bodies.mass)[:, None]
    forces = _forces(scene)
    r, v = bodies.position.copy(), bodies.velocity.copy()
    acting = forces(r, v)
    places, velocities = [r.copy()], [v.copy()]
    for _ in range(len(times) - 1):
        for _ in range(steps):
            v += half * acting
            r += step * v
            acting = forces(r, v)
            v += half * acting
        places.append(r.copy())
        velocities.append(v.copy())
    return Trajectory.of_points(times, np.array(places), np.array(velocities))


def _forces(scene: Scene) -> Forces:
    """The forces of weight, pairs and walls."""
    bodies = scene.bodies
    radii = [shape.radius for shape in bodies.shape if isinstance(shape, Sphere)]
    (law,) = (element for element in scene.elements if isinstance(element, Contact))
    walls = [_wall(element) for element in scene.elements if isinstance(element, Plane)]
    weight = bodies.mass[:, None] * _gravity(scene.elements)
    pairs = list(combinations(range(len(radii)), 2))

    def of(r: Array, v: Array) -> Array:
        total: Array = weight.copy()
        for i, j in pairs:
            apart = r[i] - r[j]
            distance = float(np.sqrt(apart @ apart))
            n = apart / distance
            push = _push(law, radii[i] + radii[j] - distance, -float((v[i] - v[j]) @ n))
            total[i] += push * n
            total[j] -= push * n
        for point, normal in walls:
            for i, radius in enumerate(radii):
                overlap = radius - float((r[i] - point) @ normal)
                total[i] += _push(law, overlap, -float(v[i] @ normal)) * normal
        return total

    return of


def _wall(plane: Plane) -> tuple[Array, Array]:
    """Point and normal (3,) of a plane."""
    return np.array(plane.point), np.array(plane.normal)


def _gravity(elements: tuple[Element, ...]) -> Array:
    """The sum (3,) [m/s^2] of all weights."""
    fields = [np.array(field.g) for field in elements if isinstance(field, UniformGravity)]
    total: Array = np.sum([np.zeros(3), *fields], axis=0)
    return total


def _push(law: Contact, overlap: float, closing: float) -> float:
    """The normal force k d^n + c d' [N] at an overlap d [m] that grows at the rate d' [m/s]; none
    without overlap, and none that pulls if the law cuts it off.
    """
    if overlap <= 0:
        return 0.0
    push: float = law.stiffness * overlap**law.exponent + law.damping * closing
    if law.cutoff == "zero_force":
        return max(push, 0.0)
    return push
