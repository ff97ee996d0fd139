"""Symmetries of mechanics: the same scene shifted, rotated, boosted, mirrored, relabelled, in other
units, started later.

With units mass mu, length l and time tau, orthogonal Q, shift d, boost u and delay t0, a state at t
is mapped to that at t' by

    x' = l (Q x + d + u t),   v' = (l/tau) (Q v + u),   omega' = det(Q) Q omega / tau,
    t' = tau t + t0,          m' = mu m.

A code must give the same motion, whatever the truth is: `applied` maps the motion, `undone` maps
the trajectory of the mapped motion back.
"""

from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Any
from weakref import WeakKeyDictionary

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory, different_rows
from refdem.mechanics.quaternion import matrix, product
from refdem.scene import Scene
from refdem.scene.bodies import Bodies
from refdem.scene.dimension import Acceleration, Dimension, Direction, Omega, Position
from refdem.scene.element import Element, Link, types_of
from refdem.scene.shapes import Polyhedron, Shape, Sphere

Array = NDArray[np.float64]

NAMES = ("shifted", "rotated", "boosted", "mirrored", "relabelled", "rescaled", "delayed")
UNITS = (1 / sqrt(11.0), sqrt(51.0), 3.0 + 2.0**-24)
"""Units of mass, length and time in which no number stays round: a code that stores a number with
too few digits rounds it differently in them.

The unit of time has 26 bits: too many for single precision, and few enough that a clock summed in
double precision stays exact.
"""
REFLECTION = np.array([1.0, 1.0, -1.0, -1.0])
"""Signs by which a reflection of x changes an attitude (w, x, y, z): R' = M R M, M = diag(-1, 1,
1).
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class Symmetry:
    """One symmetry of mechanics as a map of motions; see the head of this module.

    `turn` is the unit quaternion of the rotation, `mirrored` reflects x before it, `shift` is d
    [m], `boost` u [m/s], `reverse` numbers the bodies backwards, `units` are the factors of mass,
    length and time, `delay` is t0 [s].
    """

    turn: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    mirrored: bool = False
    shift: Array = field(default_factory=lambda: np.zeros(3))
    boost: Array = field(default_factory=lambda: np.zeros(3))
    reverse: bool = False
    units: tuple[float, float, float] = (1.0, 1.0, 1.0)
    delay: float = 0.0

    @property
    def q(self) -> Array:
        """The orthogonal matrix Q (3, 3): the rotation, after the reflection of x if mirrored."""
        rotation: Array = matrix(self.turn)
        if self.mirrored:
            return rotation @ np.diag([-1.0, 1.0, 1.0])
        return rotation

    def applied(self, motion: Motion) -> Motion:
        """The image of a motion: its scene and times mapped by the symmetry."""
        scene = Scene(
            self._bodies(motion.scene.bodies),
            tuple(self._element(e, len(motion.scene.bodies)) for e in motion.scene.elements),
        )
        return Motion(scene, self.units[2] * motion.times + self.delay)

    def undone(self, run: Trajectory) -> Trajectory:
        """The trajectory of the original motion, from the trajectory `run` of the mapped one.

        The inverse of the map in the module's head: t = (t' - t0)/tau,
        x = Q^T (x'/l - d - u t), v = Q^T (v' tau/l - u), omega = det(Q) Q^T omega' tau.
        """
        _, length, time = self.units
        q = self.q
        if self.reverse:
            order = slice(None, None, -1)
        else:
            order = slice(None)
        t = (run.t - self.delay) / time
        # Rows are vectors: r @ Q is Q^T r.
        position = (
            run.position[:, order] / length - self.shift - self.boost * t[:, None, None]
        ) @ q
        velocity = (run.velocity[:, order] * (time / length) - self.boost) @ q
        attitude = different_rows(run.attitude)[:, order]
        omega = different_rows(run.omega)[:, order] * time @ q
        # A reflection reverses the sense of every rotation: det(Q) = -1.
        if self.mirrored:
            omega = -omega
            attitude = attitude * REFLECTION
        else:
            attitude = product(self.turn * np.array([1.0, -1.0, -1.0, -1.0]), attitude)
        return Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            attitude=np.broadcast_to(attitude, run.attitude.shape),
            omega=np.broadcast_to(omega, run.omega.shape),
        )

    def _bodies(self, bodies: Bodies) -> Bodies:
        """The bodies as the symmetry maps them, column by column; a point keeps its attitude."""
        mass, length, time = self.units
        speed = length / time
        # A reflection reverses omega, an axial vector.
        has_inertia = np.any(bodies.inertia, axis=1, keepdims=True)
        if self.mirrored:
            sense = -1.0
            attitude = bodies.attitude * REFLECTION
        else:
            sense = 1.0
            attitude = product(self.turn, bodies.attitude)
        # r -> l (Q r + d),  v -> (l/tau) (Q v + u),  omega -> det(Q) Q omega/tau.
        position = length * (bodies.position @ self.q.T + self.shift)
        velocity = speed * (bodies.velocity @ self.q.T + self.boost)
        omega = bodies.omega @ self.q.T / time * sense
        # Bodies refer to a shape by its number in `shapes`, so each shape is mapped once.
        mapped_shapes = [self._shape(shape) for shape in bodies.shapes]
        columns: dict[str, Any] = {
            "mass": bodies.mass * mass,
            "inertia": bodies.inertia * (mass * length**2),
            "position": position,
            "velocity": velocity,
            "attitude": np.where(has_inertia, attitude, bodies.attitude),
            "omega": omega,
            "fixed": bodies.fixed.copy(),
        }
        shapes = tuple(mapped_shapes[number] for number in bodies.shape_number.tolist())
        if self.reverse:
            columns = {name: column[::-1].copy() for name, column in columns.items()}
            shapes = shapes[::-1]
        # Columns that the symmetry does not change are shared with the original bodies, to save
        # memory: there are many images.
        for name, column in columns.items():
            unmapped = getattr(bodies, name)
            if column.tobytes() == unmapped.tobytes():
                columns[name] = unmapped
        return replace(bodies, shape=shapes, **columns)

    def _shape(self, shape: Shape) -> Shape:
        """A shape in other units, and mirrored."""
        length = self.units[1]
        if isinstance(shape, Sphere):
            return Sphere(radius=shape.radius * length)
        if isinstance(shape, Polyhedron):
            if self.mirrored:
                sign = -1.0
                # The vertices of a face must be counter-clockwise seen from outside. A reflection
                # makes them clockwise, so their order is reversed.
                faces = tuple(face[::-1] for face in shape.faces)
            else:
                sign = 1.0
                faces = shape.faces
            vertices = tuple(
                (sign * x * length, y * length, z * length) for x, y, z in shape.vertices
            )
            return Polyhedron(vertices=vertices, faces=faces)
        return shape

    def _number(self, value: float, dimension: Dimension) -> float:
        """A number in the units of the symmetry: value mu^a l^b tau^c for the dimension (a, b, c).

        0 stays 0 in all units, also where the factor is out of range.
        """
        if not value:
            return 0.0
        factor = np.prod(np.array(self.units) ** np.array(dimension))
        return value * float(factor)

    def _element(self, element: Element, count: int) -> Element:
        """An element with every field mapped as its annotated type requires.

        A Position is mapped as a point, a Direction is rotated, an Acceleration and an Omega are
        rotated and scaled, and an Omega changes sign in a reflection. `a` and `b` are numbers of
        bodies, of which there are `count`. Every other number has the dimension of its annotation.
        """
        changed: dict[str, Any] = {}
        hints = types_of(type(element))
        for name in element.__struct_fields__:
            value = getattr(element, name)
            hint = hints[name]
            if hint == Position:
                # A link's anchors are in body axes, but for one at the world (b = -1).
                if isinstance(element, Link):
                    in_space = name == "anchor_b" and element.b < 0
                else:
                    in_space = True
                changed[name] = self._place(value, space=in_space)
            elif hint in (Direction, Acceleration, Omega):
                factor = self._vector_factor(hint)
                changed[name] = tuple((self.q @ np.array(value) * factor).tolist())
            elif name in ("a", "b") and self.reverse and value >= 0:
                changed[name] = count - 1 - value
            elif isinstance(value, float) and (dimension := element.dimension(name)) is not None:
                changed[name] = self._number(value, dimension)
        return msgspec.structs.replace(element, **changed).delayed(self.delay)

    def _vector_factor(self, hint: Any) -> float:
        """The factor of a vector of that type after Q: its unit, and det(Q) for an Omega."""
        _, length, time = self.units
        if hint == Acceleration:
            return length / time**2
        if hint == Omega and self.mirrored:
            return -1.0 / time
        if hint == Omega:
            return 1.0 / time
        return 1.0

    def _place(self, value: tuple[float, float, float], *, space: bool) -> tuple[float, ...]:
        """A point [m] mapped: l (Q x + d) of one in space; l x, reflected, of one in body axes."""
        length = self.units[1]
        if space:
            mapped = length * (self.q @ np.array(value) + self.shift)
            return tuple(mapped.tolist())
        x, y, z = value
        if self.mirrored:
            x = -x
        return (x * length, y * length, z * length)


def of(instance: Instance, name: str) -> Symmetry:
    """The symmetry called `name`, one of NAMES, for an instance.

    Shift and boost are a few times its length and speed scales, in the dimensions in which it
    moves. Their factors are powers of 2, so that they add no rounding of their own.
    """
    scales = instance.scales
    features = instance.scene.features
    # 1 for every axis along which the instance may move: x, x-y or x-y-z.
    movable = np.array([1.0, "dimension:1" not in features, "dimension:3" in features])
    # A unit quaternion: a rotation about a skew axis, or about z in the plane.
    if "dimension:3" in features:
        rotation = np.array([1.0, 2.0, 3.0, 4.0]) / np.sqrt(30.0)
    else:
        rotation = np.array([2.0, 0.0, 0.0, 1.0]) / np.sqrt(5.0)
    # r' = r + d for the shift d;   r' = r + u t and v' = v + u for the boost u.
    shift = scales.length * np.array([8.0, -4.0, 2.0]) * movable
    boost = scales.speed * np.array([0.5, -0.25, 0.125]) * movable
    symmetries = {
        "shifted": Symmetry(shift=shift),
        "rotated": Symmetry(turn=rotation),
        "boosted": Symmetry(boost=boost),
        "mirrored": Symmetry(mirrored=True),
        "relabelled": Symmetry(reverse=True),
        "rescaled": Symmetry(units=UNITS),
        "delayed": Symmetry(delay=16 * instance.problem.interval),
    }
    return symmetries[name]


_IMAGES: WeakKeyDictionary[Instance, dict[str, tuple[Symmetry, Motion]]] = WeakKeyDictionary()
"""The mapped motions of every instance by the symmetry's name; they live as long as it does."""


def image(instance: Instance, name: str) -> tuple[Symmetry, Motion]:
    """The symmetry called `name` and the instance's motion mapped by it.

    They are computed once for each instance, since they are the same for every method.
    """
    images = _IMAGES.setdefault(instance, {})
    if name not in images:
        symmetry = of(instance, name)
        images[name] = symmetry, symmetry.applied(instance.motion)
    return images[name]


def broken(scene: Scene, name: str) -> str | None:
    """None if the scene has the symmetry, else what breaks it."""
    if name == "relabelled" and len(scene.bodies) < 2:
        return "the scene has only one body"
    if name == "boosted" and scene.bodies.fixed.any():
        return "some part of the scene is fixed in space"
    reasons = (element.breaks(name) for element in scene.elements)
    return next((reason for reason in reasons if reason is not None), None)


def size(instance: Instance, symmetry: Symmetry) -> float:
    """Size of the mapped motion's coordinates and velocities in units of their scales, at least 1.

    Round-off is relative to the numbers that are rounded, so it grows by this factor:
    max(1, |x|/L, |v| tau/L) of the start + (|d| + |u| T)/L + |u| tau/L.
    """
    # max(1, |x|/L, |v| tau/L) + (|d| + |u| T)/L + |u| tau/L.
    scales = instance.scales
    bodies = instance.scene.bodies
    at_start = (
        np.abs(bodies.position).max() / scales.length,
        np.abs(bodies.velocity).max() / scales.speed,
    )
    boost = np.linalg.norm(symmetry.boost)
    displacement = np.linalg.norm(symmetry.shift) + boost * scales.duration
    return float(max(1.0, *at_start) + displacement / scales.length + boost / scales.speed)


def rounded_rates(instance: Instance) -> float:
    """Rotation angle [rad] at the end per unit relative error of the moments of inertia.

    Euler's equations, omega_a' = (J_b - J_c)/J_a omega_b omega_c, turn relative errors eps of the
    moments into an error of up to eps (J_b + J_c)/J_a in the rate, which is large for a needle.
    Over the duration it adds up to eps (J_b + J_c)/J_a T/tau, J_a the smallest moment of any free
    body.
    """
    bodies = instance.scene.bodies
    phase = instance.scales.duration / instance.scales.tau
    rotates = np.all(bodies.inertia > 0, axis=1) & ~bodies.fixed
    moments = bodies.inertia[rotates]
    # (J_b + J_c)/J_a T/tau, J_a the smallest moment.
    smallest = moments.min(axis=1)
    ratio = (moments.sum(axis=1) - smallest) / smallest
    return float(np.max(ratio, initial=0.0) * phase)
