"""The bodies of a scene: one by one in JSON, columns (N, ...) in memory."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import SceneError
from refdem.scene.dimension import Attitude, Inertia, Mass, Omega, Position, Velocity
from refdem.scene.shapes import Point, Polyhedron, Shape, Sphere

Array = NDArray[np.float64]


class Body(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One body: principal `inertia` (zeros for a point), `attitude` (w, x, y, z) body to space,
    `omega` in space axes.
    """

    mass: Mass
    inertia: Inertia = (0.0, 0.0, 0.0)
    position: Position = (0.0, 0.0, 0.0)
    velocity: Velocity = (0.0, 0.0, 0.0)
    attitude: Attitude = (1.0, 0.0, 0.0, 0.0)
    omega: Omega = (0.0, 0.0, 0.0)
    shape: Shape = Point()
    fixed: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Bodies:
    """Columns of N bodies: mass (N,) [kg], inertia (N, 3) [kg m^2], position, velocity (N, 3),
    attitude (N, 4), omega (N, 3).
    """

    mass: Array
    inertia: Array
    position: Array
    velocity: Array
    attitude: Array
    omega: Array
    shape: tuple[Shape, ...]
    fixed: NDArray[np.bool_]

    def __post_init__(self) -> None:
        for column in COLUMNS:
            getattr(self, column).setflags(write=False)
        for number in np.flatnonzero(_suspect(self)).tolist():
            _refuse_unphysical(self, number)

    @classmethod
    def of(cls, bodies: "list[Body] | tuple[Body, ...]") -> "Bodies":
        """The columns of single bodies, in their order."""
        if not bodies:
            raise SceneError("scene.bodies is empty; expected at least one body")
        columns: dict[str, Any] = {}
        for name in COLUMNS:
            values = [getattr(body, name) for body in bodies]
            columns[name] = np.array(values, float)
        return cls(
            shape=tuple(body.shape for body in bodies),
            fixed=np.array([body.fixed for body in bodies]),
            **columns,
        )

    def single(self) -> list[Body]:
        """The bodies one by one, as JSON has them."""
        columns: Any = [getattr(self, name).tolist() for name in COLUMNS]
        bodies = []
        for row in zip(*columns, self.shape, self.fixed.tolist(), strict=True):
            mass, inertia, position, velocity, attitude, omega, shape, fixed = row
            body = Body(
                mass=mass,
                inertia=tuple(inertia),
                position=tuple(position),
                velocity=tuple(velocity),
                attitude=tuple(attitude),
                omega=tuple(omega),
                shape=shape,
                fixed=fixed,
            )
            bodies.append(body)
        return bodies

    def with_state(self, **columns: Array) -> "Bodies":
        """The same bodies with other positions, velocities, attitudes or omegas."""
        changed: dict[str, Any] = {name: np.array(value, float) for name, value in columns.items()}
        return replace(self, **changed)

    def __len__(self) -> int:
        return len(self.mass)

    @cached_property
    def radius(self) -> Array:
        """Radius (N,) [m], not to be written to; zero for a body that is no sphere."""
        of_shape = []
        for shape in self.shapes:
            if isinstance(shape, Sphere):
                of_shape.append(shape.radius)
            else:
                of_shape.append(0.0)
        radius = np.array(of_shape)[self.shape_number]
        radius.setflags(write=False)
        return radius

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The different objects among the shapes, in the order in which they come."""
        return self._numbered[0]

    @property
    def shape_number(self) -> NDArray[np.int64]:
        """The index of each body's shape (N,) in `shapes`."""
        return self._numbered[1]

    @cached_property
    def _numbered(self) -> tuple[tuple[Shape, ...], NDArray[np.int64]]:
        """The different shapes, and for each body (N,) the number of its shape among them."""
        # Most scenes of many bodies have one shape: this case needs no loop in Python.
        has_one_shape = self.shape[:1] and self.shape.count(self.shape[0]) == len(self.shape)
        if has_one_shape:
            return self.shape[:1], np.zeros(len(self.shape), np.int64)
        shapes = {id(shape): shape for shape in self.shape}
        numbers = {key: number for number, key in enumerate(shapes)}
        of_bodies = (numbers[id(shape)] for shape in self.shape)
        return tuple(shapes.values()), np.fromiter(of_bodies, np.int64, len(self.shape))


COLUMNS = ("mass", "inertia", "position", "velocity", "attitude", "omega")


def _suspect(bodies: Bodies) -> NDArray[np.bool_]:
    """True (N,) for bodies that must be checked one by one.

    All unphysical bodies are among them, and perhaps others: the test is fast and a little stricter
    than `_refuse_unphysical`.
    """
    with np.errstate(all="ignore"):
        wrong = ~(bodies.mass > 0) | np.any(bodies.inertia < 0, axis=1)
        # No moment of inertia exceeds the sum of the other two.
        total = bodies.inertia.sum(axis=1, keepdims=True)
        wrong |= np.any(2 * bodies.inertia > total, axis=1)
        wrong |= ~(np.abs(np.linalg.norm(bodies.attitude, axis=1) - 1) < 5e-10)
        for name in COLUMNS:
            is_finite = np.isfinite(getattr(bodies, name)).reshape(len(wrong), -1)
            wrong |= ~is_finite.all(axis=1)
    doubtful = [isinstance(shape, Polyhedron) or not _is_sound(shape) for shape in bodies.shapes]
    return np.asarray(wrong | np.array(doubtful)[bodies.shape_number])


def _is_sound(shape: Shape) -> bool:
    """True for a point, or for a sphere with a radius > 0."""
    return not isinstance(shape, Sphere) or 0 < shape.radius < float("inf")


@np.errstate(over="ignore")
def _refuse_unphysical(bodies: Bodies, number: int) -> None:
    """Raises SceneError for an unphysical body; the message shows numbers beyond binary64 as
    inf.
    """
    where = f"scene.bodies.{number}"
    for name in COLUMNS:
        value = getattr(bodies, name)[number]
        if not np.all(np.isfinite(value)):
            raise SceneError(
                f"{where}.{name} is {np.asarray(value).tolist()}; expected finite numbers"
            )
    mass = bodies.mass[number]
    inertia = bodies.inertia[number]
    if not mass > 0:
        raise SceneError(f"{where}.mass is {mass}; expected > 0")
    if np.any(inertia < 0):
        raise SceneError(f"{where}.inertia is {inertia.tolist()}; expected three moments >= 0")
    if np.any(2 * inertia > inertia.sum() * (1 + 1e-12)):
        raise SceneError(
            f"{where}.inertia is {inertia.tolist()}; it violates the triangle inequality: "
            "no principal moment may exceed the sum of the other two"
        )
    norm = float(np.linalg.norm(bodies.attitude[number]))
    if abs(norm - 1) > 1e-9:
        raise SceneError(
            f"{where}.attitude has norm {norm}; expected a unit quaternion (w, x, y, z)"
        )
    _refuse_shape(bodies.shape[number], where)


def _refuse_shape(shape: Shape, where: str) -> None:
    """Raises SceneError for a sphere without radius or a polyhedron whose faces name no
    vertices.
    """
    if isinstance(shape, Sphere) and not 0 < shape.radius < float("inf"):
        raise SceneError(f"{where}.shape.radius is {shape.radius}; expected > 0")
    if isinstance(shape, Polyhedron):
        count = len(shape.vertices)
        if count < 4 or any(not 0 <= v < count for face in shape.faces for v in face):
            raise SceneError(
                f"{where}.shape: {count} vertices and faces that name others; expected at least 4,"
                f" faces naming 0..{count - 1}"
            )
