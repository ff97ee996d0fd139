"""Mass, centre of mass and inertia of bodies: point clouds, polygons and polyhedra, and what moving
and turning does to them.

Matuttis and Chen 2014, chapter 1, (1.14) to (1.31); a polyhedron is the signed sum of the
tetrahedra between its faces and a point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MassProperties:
    """`mass` [kg], `centre` of mass (3,) [m], and the `inertia` tensor (3, 3) [kg m^2] about it."""

    mass: float
    centre: Array
    inertia: Array

    def about(self, point: ArrayLike) -> Array:
        """The tensor (3, 3) about another point (3,) [m]: the parallel axis theorem (1.28)."""
        return self.inertia + _of_point(self.mass, np.asarray(point, float) - self.centre)

    def turned(self, turn: Array) -> Self:
        """The same body after the rotation matrix `turn` (3, 3) about the origin: R J R^T
        (1.30).
        """
        return type(self)(self.mass, turn @ self.centre, turn @ self.inertia @ turn.T)

    def __add__(self, other: Self) -> Self:
        """The mass properties of both bodies as one."""
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return type(self)(mass, centre, self.about(centre) + other.about(centre))

    def __sub__(self, hollow: Self) -> Self:
        """The body without a part of it (1.31)."""
        return self + type(self)(-hollow.mass, hollow.centre, -hollow.inertia)

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) in rising order, and the right-handed axes (3, 3) as columns."""
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        return moments, axes


def _of_point(mass: float, arm: Array) -> Array:
    """`mass` (|a|^2 1 - a a^T), (3, 3) [kg m^2]."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def of_points(mass: ArrayLike, position: ArrayLike) -> MassProperties:
    """The mass properties of N points: mass (N,) [kg], position (N, 3) [m] (1.14)."""
    mass = np.asarray(mass, float)
    position = np.asarray(position, float)
    total = float(np.sum(mass))
    centre = mass @ position / total
    arms = position - centre
    inertia = np.sum([_of_point(m, arm) for m, arm in zip(mass, arms, strict=True)], axis=0)
    return MassProperties(total, centre, inertia)


def of_polyhedron(
    vertices: ArrayLike, faces: Sequence[Sequence[int]], density: float
) -> MassProperties:
    """The mass properties of a solid with flat faces, convex or not: vertices (V, 3) [m], faces
    counter-clockwise from outside, density [kg/m^3].

    Each triangle of a face spans a tetrahedron with the mean of the vertices. Its volume has a
    sign, so what lies outside cancels. Over a tetrahedron with corners 0, p, q, r the mean of x x^T
    is (sum of the corners' own + s s^T)/20, s = p + q + r.
    """
    corners = np.asarray(vertices, float)
    origin = corners.mean(axis=0)
    # Triangles of each face: its first corner with every later side.
    triangles: list[tuple[int, int, int]] = []
    for face in faces:
        triangles += [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
    first, second, third = (list(index) for index in zip(*triangles, strict=True))
    p = corners[first] - origin
    q = corners[second] - origin
    r = corners[third] - origin
    # m = density p . (q x r)/6, and the mean of x is s/4.
    mass = density * np.einsum("ij,ij->i", p, np.cross(q, r)) / 6
    total = float(np.sum(mass))
    s = p + q + r
    centre = mass @ s / (4 * total)
    moment = sum(np.einsum("i,ij,ik->jk", mass, a, a) for a in (p, q, r, s)) / 20
    return MassProperties(
        total, origin + centre, _tensor(moment - total * np.outer(centre, centre))
    )


def _tensor(moment: Array) -> Array:
    """The inertia tensor trace(M) 1 - M (3, 3) [kg m^2] of the second moment M of the mass about
    the same point.
    """
    inertia: Array = np.trace(moment) * np.eye(3) - moment
    return inertia


def of_polygon(vertices: ArrayLike, density: float) -> MassProperties:
    """The mass properties of a simple polygon in x-y, convex or not: vertices (V, 2) [m] counter-
    clockwise, density [kg/m^2]; `inertia[2, 2]` is its J.

    A triangle with corners p, q and the mean of the vertices has m (p.p + p.q + q.q)/6 about the
    latter, with the sign of p x q.
    """
    corners = np.asarray(vertices, float)
    origin = corners.mean(axis=0)
    p = corners - origin
    q = np.roll(p, -1, axis=0)
    # m = density (p x q)/2, and the mean of x is s/3.
    mass = density * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / 2
    total = float(np.sum(mass))
    s = p + q
    centre = mass @ s / (3 * total)
    moment = sum(np.einsum("i,ij,ik->jk", mass, a, a) for a in (p, q, s)) / 12
    flat = np.zeros((3, 3))
    flat[:2, :2] = moment - total * np.outer(centre, centre)
    return MassProperties(total, np.append(origin + centre, 0.0), _tensor(flat))


def of_ellipsoid(half_axes: Sequence[float], density: float) -> MassProperties:
    """The mass properties of an ellipsoid about the origin, half axes (3,) [m], density [kg/m^3]: a
    ball, stretched.
    """
    a = np.asarray(half_axes, float)
    mass = float(4 / 3 * np.pi * np.prod(a) * density)
    # J_x = m (b^2 + c^2)/5, and so on.
    squares = a * a
    inertia = mass / 5 * np.diag(np.sum(squares) - squares)
    return MassProperties(mass, np.zeros(3), inertia)


def of_cylinder(half_axes: Sequence[float], height: float, density: float) -> MassProperties:
    """The mass properties of an elliptical cylinder about the origin, half axes (2,) in x and y,
    height [m] along z, density [kg/m^3].
    """
    a, b = half_axes
    mass = float(np.pi * a * b * height * density)
    # The means of x^2, y^2 and z^2 over the cylinder.
    squares = np.array([a**2 / 4, b**2 / 4, height**2 / 12])
    inertia = mass * np.diag(np.sum(squares) - squares)
    return MassProperties(mass, np.zeros(3), inertia)
