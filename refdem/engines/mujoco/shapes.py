"""Shapes that meet: spheres, boxes and planes as geoms, and which pairs of them there are."""

from collections.abc import Iterator
from itertools import chain, combinations
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
    half = np.abs(vertices[0])
    corners = {tuple(corner) for corner in np.sign(vertices)}
    is_box = (
        len(vertices) == len(corners) == 8
        and bool(half.all())
        and np.array_equal(np.abs(vertices), np.tile(half, (8, 1)))
    )
    if is_box:
        sides: Array = 2 * half
        return sides
    return None


def pairs(scene: Scene) -> Iterator[float]:
    """The effective mass [kg] of each pair of shapes that may meet, planes included."""
    bodies = scene.bodies
    inverse = np.where(bodies.fixed, 0.0, 1 / bodies.mass)
    shaped = [n for n, shape in enumerate(bodies.shape) if not isinstance(shape, Point)]
    with_planes = (inverse[i] for i in shaped for _ in scene.all(Plane))
    for total in chain((inverse[i] + inverse[j] for i, j in combinations(shaped, 2)), with_planes):
        if total > 0:
            yield 1 / total


def add_shape(mujoco: Any, said: Any, shape: Any, words: dict[str, Any]) -> Any:
    """The geom of a body of MuJoCo, with its name and contact parameters."""
    if isinstance(shape, Sphere):
        return said.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(shape.radius, 0, 0), **words)
    sides = box_sides(shape)
    assert sides is not None, "refused before"
    return said.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=sides / 2, **words)


def add_plane(mujoco: Any, world: Any, plane: Plane, words: dict[str, Any]) -> Any:
    """The geom of a plane, added to the world; its z axis is the normal."""
    return world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0, 0, 1),
        pos=plane.point,
        quat=_turned_up(plane.normal),
        **words,
    )


def _turned_up(normal: tuple[float, float, float]) -> Array:
    """The quaternion of the shortest turn that takes the z axis to `normal`."""
    x, y, z = normal
    if (
        z < -0.5
    ):  # the shortest turn is ill-conditioned near half a turn: go by way of the opposite normal
        w, a, b, c = _turned_up((x, -y, -z))
        return np.array([-a, w, -c, b])
    half = np.array([1 + z, -y, x, 0.0])
    attitude: Array = half / np.linalg.norm(half)
    return attitude
