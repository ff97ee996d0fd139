"""Symmetries of mechanics: the same scene shifted, rotated, boosted, mirrored, relabelled, in other
units, started later.

x' = lambda (Q x + d + u t), t' = tau t + t0, masses times mu: a code must give the same motion,
whatever the truth is.
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
from refdem.core.trajectory import Trajectory
from refdem.mechanics.quaternion import matrix, product
from refdem.scene import Scene
from refdem.scene.bodies import Bodies
from refdem.scene.dimension import Acceleration, Dimension, Direction, Position
from refdem.scene.element import Element, Link, types_of
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.shapes import Polyhedron, Shape, Sphere

Array = NDArray[np.float64]

NAMES = ("shifted", "rotated", "boosted", "mirrored", "relabelled", "rescaled", "delayed")
UNITS = (1 / sqrt(11.0), sqrt(51.0), 3.0 + 2.0**-24)
"""Units of mass, length and time in which no number stays round: what a code keeps in too few
digits is rounded anew.

That of time has 26 bits: too many for single precision, and few enough for a clock that is summed
plainly in double precision.
"""
REFLECTION = np.array([1.0, 1.0, -1.0, -1.0])
"""What a reflection of x does to an attitude (w, x, y, z): R' = M R M with M = diag(-1, 1, 1)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Symmetry:
    """One map: unit quaternion `turn`, reflection of x, shift d [m], boost u [m/s], order of
    bodies, units, delay [s].
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
        """The orthogonal matrix Q (3, 3)."""
        turned: Array = matrix(self.turn)
        if self.mirrored:
            return turned @ np.diag([-1.0, 1.0, 1.0])
        return turned

    def applied(self, motion: Motion) -> Motion:
        """The motion as the symmetry shows it."""
        scene = Scene(
            self._bodies(motion.scene.bodies),
            tuple(self._element(e, len(motion.scene.bodies)) for e in motion.scene.elements),
        )
        return Motion(scene, self.units[2] * motion.times + self.delay)

    def undone(self, run: Trajectory) -> Trajectory:
        """The trajectory of the motion itself, from that of the motion as the symmetry shows it."""
        _, length, time = self.units
        if self.reverse:
            order = slice(None, None, -1)
        else:
            order = slice(None)
        t = (run.t - self.delay) / time
        position = (
            run.position[:, order] / length - self.shift - self.boost * t[:, None, None]
        ) @ self.q
        velocity = (run.velocity[:, order] * (time / length) - self.boost) @ self.q
        attitude = run.attitude[:, order]
        # A reflection turns the sense of every rotation.
        if self.mirrored:
            sense = -1.0
            attitude = attitude * REFLECTION
        else:
            sense = 1.0
            attitude = product(self.turn * np.array([1.0, -1.0, -1.0, -1.0]), attitude)
        omega = run.omega[:, order] * time @ self.q * sense
        columns = (position, velocity, attitude, omega)
        position, velocity, attitude, omega = (np.ascontiguousarray(values) for values in columns)
        return Trajectory(t=t, position=position, velocity=velocity, attitude=attitude, omega=omega)

    def _bodies(self, bodies: Bodies) -> Bodies:
        """The bodies, column by column; the attitude of a point stays."""
        mass, length, time = self.units
        speed = length / time
        # A mirror image turns the other way: omega is an axial vector.
        turns = np.any(bodies.inertia, axis=1, keepdims=True)
        if self.mirrored:
            sense = -1.0
            turned = bodies.attitude * REFLECTION
        else:
            sense = 1.0
            turned = product(self.turn, bodies.attitude)
        # r -> l (Q r + shift), v -> (l/t) (Q v + boost), omega -> +-Q omega/t.
        position = length * (bodies.position @ self.q.T + self.shift)
        velocity = speed * (bodies.velocity @ self.q.T + self.boost)
        omega = bodies.omega @ self.q.T / time * sense
        shown = [self._shape(shape) for shape in bodies.shapes]
        columns: dict[str, Any] = {
            "mass": bodies.mass * mass,
            "inertia": bodies.inertia * (mass * length**2),
            "position": position,
            "velocity": velocity,
            "attitude": np.where(turns, turned, bodies.attitude),
            "omega": omega,
            "fixed": bodies.fixed.copy(),
        }
        shapes = tuple(shown[number] for number in bodies.shape_number.tolist())
        if self.reverse:
            columns = {name: column[::-1].copy() for name, column in columns.items()}
            shapes = shapes[::-1]
        return replace(bodies, shape=shapes, **columns)

    def _shape(self, shape: Shape) -> Shape:
        """A shape in other units, and mirrored."""
        length = self.units[1]
        if isinstance(shape, Sphere):
            return Sphere(radius=shape.radius * length)
        if isinstance(shape, Polyhedron):
            if self.mirrored:
                side = -1.0
            else:
                side = 1.0
            if self.mirrored:
                faces = tuple(face[::-1] for face in shape.faces)
            else:
                faces = shape.faces
            return Polyhedron(
                vertices=tuple(
                    (side * x * length, y * length, z * length) for x, y, z in shape.vertices
                ),
                faces=faces,
            )
        return shape

    def _number(self, value: float, dimension: Dimension) -> float:
        """A number in the units of the symmetry; 0 is 0 in all of them."""
        if not value:
            return 0.0
        return value * float(np.prod(np.array(self.units) ** np.array(dimension)))

    def _element(self, element: Element, count: int) -> Element:
        """An element with every field as its type says: places, directions, numbers with a
        dimension, bodies by number.
        """
        changed: dict[str, Any] = {}
        hints = types_of(type(element))
        for name in element.__struct_fields__:
            value = getattr(element, name)
            hint = hints[name]
            if hint == Position:
                changed[name] = self._place(
                    value,
                    space=not isinstance(element, Link) or (name == "anchor_b" and element.b < 0),
                )
            elif hint in (Direction, Acceleration):
                if hint == Acceleration:
                    unit = self.units[1] / self.units[2] ** 2
                else:
                    unit = 1.0
                changed[name] = tuple((self.q @ np.array(value) * unit).tolist())
            elif name in ("a", "b") and self.reverse and value >= 0:
                changed[name] = count - 1 - value
            elif isinstance(value, float) and (dimension := element.dimension(name)) is not None:
                changed[name] = self._number(value, dimension)
        return msgspec.structs.replace(element, **changed).delayed(self.delay)

    def _place(self, value: tuple[float, float, float], *, space: bool) -> tuple[float, ...]:
        """A place in space, or an anchor in body axes."""
        length = self.units[1]
        if space:
            return tuple((length * (self.q @ np.array(value) + self.shift)).tolist())
        x, y, z = value
        if self.mirrored:
            x = -x
        return (x * length, y * length, z * length)


def of(instance: Instance, name: str) -> Symmetry:
    """The symmetry of that name for an instance, within the dimensions in which it moves; sizes of
    the order of its scales.
    """
    scales = instance.scales
    features = instance.scene.features
    flat = np.array([1.0, "dimension:1" not in features, "dimension:3" in features])
    if "dimension:3" in features:
        turn = np.array([1.0, 2.0, 3.0, 4.0]) / np.sqrt(30.0)
    else:
        turn = np.array([2.0, 0.0, 0.0, 1.0]) / np.sqrt(5.0)
    shift = scales.length * np.array([8.0, -4.0, 2.0]) * flat
    boost = scales.speed * np.array([0.5, -0.25, 0.125]) * flat
    known = {
        "shifted": Symmetry(shift=shift),
        "rotated": Symmetry(turn=turn),
        "boosted": Symmetry(boost=boost),
        "mirrored": Symmetry(mirrored=True),
        "relabelled": Symmetry(reverse=True),
        "rescaled": Symmetry(units=UNITS),
        "delayed": Symmetry(delay=16 * instance.problem.interval),
    }
    return known[name]


_PICTURES: WeakKeyDictionary[Instance, dict[str, tuple[Symmetry, Motion]]] = WeakKeyDictionary()


def picture(instance: Instance, name: str) -> tuple[Symmetry, Motion]:
    """The symmetry of that name and the instance's motion as it shows it; made once, for every
    method is shown the same.
    """
    made = _PICTURES.setdefault(instance, {})
    if name not in made:
        view = of(instance, name)
        made[name] = view, view.applied(instance.motion)
    return made[name]


def broken(scene: Scene, name: str) -> str | None:
    """None if the scene has the symmetry, else what breaks it."""
    centred = any(isinstance(element, CentralField) for element in scene.elements)
    if name == "rotated" and any(isinstance(element, PeriodicBox) for element in scene.elements):
        return "the periodic box has fixed axes"
    if name == "relabelled" and len(scene.bodies) < 2:
        return "the scene has only one body"
    if name in ("shifted", "boosted") and centred:
        return "the central field fixes an origin"
    if name == "boosted" and (
        scene.bodies.fixed.any()
        or any(e.external and e.kind != "uniform_gravity" for e in scene.elements)
    ):
        return "some part of the scene is fixed in space"
    return None


def size(instance: Instance, symmetry: Symmetry) -> float:
    """How many times the scale the numbers become larger: round-off grows with them."""
    scales = instance.scales
    bodies = instance.scene.bodies
    own = (
        np.abs(bodies.position).max() / scales.length,
        np.abs(bodies.velocity).max() / scales.speed,
    )  # of the start itself
    far = np.linalg.norm(symmetry.shift) + np.linalg.norm(symmetry.boost) * scales.duration
    return float(
        max(1.0, *own) + far / scales.length + np.linalg.norm(symmetry.boost) / scales.speed
    )


def rounded_rates(instance: Instance) -> float:
    """Error of a turn [rad] at the end, in roundings of the moments: much for a needle, by (J_b -
    J_c)/J_a in Euler's equations.
    """
    bodies = instance.scene.bodies
    turns = instance.scales.duration / instance.scales.tau
    moments = bodies.inertia[np.all(bodies.inertia > 0, axis=1) & ~bodies.fixed]
    return float(
        np.max((moments.sum(axis=1) - moments.min(axis=1)) / moments.min(axis=1), initial=0.0)
        * turns
    )
