"""Spheres, boxes and planes as geoms of MuJoCo, and the effective masses of pairs that may meet."""

from collections.abc import Iterator
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Point, Polyhedron, Scene, Sphere
from refdem.scene.elements.plane import Plane

Array = NDArray[np.float64]


def box_sides(shape: Polyhedron) -> Array | None:
    """Side lengths (3,) [m] of a box about the body's centre along its axes, or None for any other
    polyhedron.
    """
    vertices = np.array(shape.vertices)
    # A box has the eight vertices (+-a/2, +-b/2, +-c/2), each choice of signs once.
    half_sides = np.abs(vertices[0])
    octants = {tuple(signs) for signs in np.sign(vertices)}
    is_box = (
        len(vertices) == len(octants) == 8
        and bool(half_sides.all())
        and np.array_equal(np.abs(vertices), np.tile(half_sides, (8, 1)))
    )
    if not is_box:
        return None
    sides: Array = 2 * half_sides
    return sides


def effective_masses(scene: Scene) -> Iterator[float]:
    """The effective masses 1/(1/m_i + 1/m_j) [kg] of all pairs of shapes that may meet, one by one:
    of two bodies, and of a body and a plane, whose mass is infinite.

    Pairs of which neither part can move are left out.
    """
    bodies = scene.bodies
    inverse_mass = np.where(bodies.fixed, 0.0, 1 / bodies.mass)
    shaped = [n for n, shape in enumerate(bodies.shape) if not isinstance(shape, Point)]
    for i, j in combinations(shaped, 2):
        if inverse_mass[i] + inverse_mass[j] > 0:
            yield 1 / (inverse_mass[i] + inverse_mass[j])
    for i, _ in product(shaped, scene.all(Plane)):
        if inverse_mass[i] > 0:
            yield 1 / inverse_mass[i]


def add_shape(mujoco: Any, mj_body: Any, shape: Any, attributes: dict[str, Any]) -> Any:
    """Adds the geom of a shape to a body of MuJoCo (MjsBody), and returns it.

    `attributes` are its name and its contact parameters, as MuJoCo names them.
    """
    if isinstance(shape, Sphere):
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        return mj_body.add_geom(type=sphere, size=(shape.radius, 0, 0), **attributes)
    sides = box_sides(shape)
    assert sides is not None, "refused before"
    return mj_body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=sides / 2, **attributes)


def add_plane(mujoco: Any, world: Any, plane: Plane, attributes: dict[str, Any]) -> Any:
    """Adds the geom of a plane to the world, its z axis along the normal, and returns it."""
    return world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0, 0, 1),
        pos=plane.point,
        quat=_turned_up(plane.normal),
        **attributes,
    )


def _turned_up(normal: tuple[float, float, float]) -> Array:
    """The quaternion of the shortest turn that takes the z axis to `normal`."""
    x, y, z = normal
    # The shortest turn is ill-conditioned near half a turn: turn to (x, -y, -z) first, then half a
    # turn about x, whose quaternion is (0, 1, 0, 0).
    if z < -0.5:
        w, a, b, c = _turned_up((x, -y, -z))
        return np.array([-a, w, -c, b])
    # q = (1 + z . n, z x n)/|...| turns z to n by the angle between them.
    unnormalised = np.array([1 + z, -y, x, 0.0])
    attitude: Array = unnormalised / np.linalg.norm(unnormalised)
    return attitude
