"""Mass, centre of mass and inertia of bodies: point clouds, polygons and polyhedra, and how
translation and rotation change them.

Matuttis and Chen 2014, chapter 1, (1.14) to (1.31). With the second moment M = integral x x^T dm
about a point, the inertia tensor about it is trace(M) 1 - M. Polyhedra are signed sums of
tetrahedra, polygons of triangles.
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
        """The inertia tensor (3, 3) about another point (3,) [m], by the parallel axis theorem
        (1.28): J + m (|a|^2 1 - a a^T), a from the centre of mass to the point.
        """
        return self.inertia + _of_point(self.mass, np.asarray(point, float) - self.centre)

    def turned(self, turn: Array) -> Self:
        """The body after the rotation R = `turn` (3, 3) about the origin: centre R c, tensor R J
        R^T (1.30).
        """
        return type(self)(self.mass, turn @ self.centre, turn @ self.inertia @ turn.T)

    def __add__(self, other: Self) -> Self:
        """The mass properties of both bodies together."""
        # M = m_1 + m_2,   C = (m_1 c_1 + m_2 c_2)/M; both tensors are taken about C.
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return type(self)(mass, centre, self.about(centre) + other.about(centre))

    def __sub__(self, hollow: Self) -> Self:
        """The body without a hollow part: a part of negative mass is added (1.31)."""
        return self + type(self)(-hollow.mass, hollow.centre, -hollow.inertia)

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) in rising order, and right-handed principal axes (3, 3) as
        columns.
        """
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        return moments, axes


def principal_moments(inertia: Array) -> Array:
    """Principal moments (3,) [kg m^2] in rising order: the eigenvalues of a tensor (3, 3)."""
    moments, _ = np.linalg.eigh(inertia)
    return moments


def _of_point(mass: float, arm: Array) -> Array:
    """Inertia tensor m (|a|^2 1 - a a^T) (3, 3) [kg m^2] of a point mass at `arm` a (3,) [m]."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def of_points(mass: ArrayLike, position: ArrayLike) -> MassProperties:
    """Mass properties of N points: mass (N,) [kg], position (N, 3) [m] (1.14)."""
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
    """Mass properties of a solid with flat faces, convex or not.

    vertices (V, 3) [m]; faces list vertices counter-clockwise seen from outside; density [kg/m^3].

    Each triangle (p, q, r) of a face spans a tetrahedron with the mean of the vertices as origin.
    Its signed mass is density p . (q x r)/6, so that what lies outside cancels. Over a tetrahedron
    with corners 0, p, q, r the mean of x is s/4 and the mean of x x^T is (p p^T + q q^T + r r^T + s
    s^T)/20, with s = p + q + r.
    """
    corners = np.asarray(vertices, float)
    origin = corners.mean(axis=0)
    # Each face as a fan of triangles: its first corner with every side that does not contain it.
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
    # M = sum m (p p^T + q q^T + r r^T + s s^T)/20 about the origin; - m c c^T about the centre.
    second_moment = sum(np.einsum("i,ij,ik->jk", mass, a, a) for a in (p, q, r, s)) / 20
    return MassProperties(
        total, origin + centre, _tensor(second_moment - total * np.outer(centre, centre))
    )


def _tensor(moment: Array) -> Array:
    """The inertia tensor trace(M) 1 - M (3, 3) [kg m^2] from the second moment M of the mass about
    the same point.
    """
    inertia: Array = np.trace(moment) * np.eye(3) - moment
    return inertia


def of_polygon(vertices: ArrayLike, density: float) -> MassProperties:
    """Mass properties of a simple polygon in x-y, convex or not; `inertia[2, 2]` is its polar
    moment.

    vertices (V, 2) [m] counter-clockwise, density [kg/m^2]. Each side (p, q) spans a triangle with
    the mean of the vertices as origin, of signed mass density (p x q)/2. Over a triangle with
    corners 0, p, q the mean of x is s/3 and the mean of x x^T is (p p^T + q q^T + s s^T)/12, with s
    = p + q.
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
    # M = sum m (p p^T + q q^T + s s^T)/12 about the origin; - m c c^T about the centre.
    second_moment = sum(np.einsum("i,ij,ik->jk", mass, a, a) for a in (p, q, s)) / 12
    centred_moment = np.zeros((3, 3))
    centred_moment[:2, :2] = second_moment - total * np.outer(centre, centre)
    return MassProperties(total, np.append(origin + centre, 0.0), _tensor(centred_moment))


def of_ellipsoid(half_axes: Sequence[float], density: float) -> MassProperties:
    """Mass properties of an ellipsoid about the origin: half axes (3,) [m], density [kg/m^3]; J_x =
    m (b^2 + c^2)/5.
    """
    a = np.asarray(half_axes, float)
    mass = float(4 / 3 * np.pi * np.prod(a) * density)
    # J_x = m (a^2 + b^2 + c^2 - a^2)/5, and so on.
    squares = a * a
    inertia = mass / 5 * np.diag(np.sum(squares) - squares)
    return MassProperties(mass, np.zeros(3), inertia)


def of_cylinder(half_axes: Sequence[float], height: float, density: float) -> MassProperties:
    """Mass properties of an elliptical cylinder about the origin: half axes (2,) in x and y, height
    [m] along z, density [kg/m^3].
    """
    a, b = half_axes
    mass = float(np.pi * a * b * height * density)
    # The means of x^2, y^2 and z^2 over the cylinder; J_x = m (<y^2> + <z^2>), and so on.
    squares = np.array([a**2 / 4, b**2 / 4, height**2 / 12])
    inertia = mass * np.diag(np.sum(squares) - squares)
    return MassProperties(mass, np.zeros(3), inertia)
