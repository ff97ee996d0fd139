"""A scene as plain numbers of one precision, and its initial state."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from typing import Any

import msgspec
import numpy as np

from refdem.faults.sphere_on_plane import starts_on_plane
from refdem.faults.state import State
from refdem.mechanics.vectors import ZERO, Number, Vector
from refdem.scene import Scene
from refdem.scene.bodies import Bodies
from refdem.scene.element import Element, Field, Link
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.wedge import Wedge
from refdem.scene.shapes import Polyhedron

ELEMENTS: dict[str, type[Element]] = {
    "sliders": Slider,
    "rods": Rod,
    "planes": Plane,
    "tents": PiecewiseField,
    "walls": Wedge,
    "hooks": Catch,
    "strings": StringOverWheel,
    "joints": BallJoint,
}
"""Fields of a world that have all elements of one kind, with numbers in its precision."""
SUPPORTED: tuple[type[Element], ...] = (Contact, *ELEMENTS.values())
"""Kinds of elements that the engine implements, beside those that define their own force."""
SOURCES = (
    "links",
    "fields",
    "pairs",
    "lying",
    "tents",
    "walls",
    "joints",
    "sliders",
)
"""Fields of a world that act on bodies, in the order of their loads. Joints and sliders come last,
because their loads depend on those of all others.
"""


@dataclass(frozen=True)
class World:
    """The constants of a motion: bodies and elements, with all numbers of the precision `number`.

    `links` and `fields` have the elements that define their own force; `lying` has the pairs of a
    rigid sphere and the plane on which it rests.
    """

    number: Callable[[float], Number]
    mass: list[Number]
    inertia: list[Vector]
    radius: list[Number]
    fixed: list[bool]
    links: list[Any]
    fields: list[Any]
    sliders: list[Any]
    rods: list[Any]
    planes: list[Any]
    law: Any
    pairs: list[tuple[int, int]]
    corners: list[Vector | None]
    lying: list[int]
    tents: list[Any]
    walls: list[Any]
    hooks: list[Any]
    strings: list[Any]
    string_lengths: list[Number]
    joints: list[Any]

    @cached_property
    def turns(self) -> list[bool]:
        """True for each body that has moments of inertia."""
        return [inertia[0] > 0 for inertia in self.inertia]

    @cached_property
    def sources(self) -> tuple[str, ...]:
        """The names of those SOURCES that are not empty, in their order."""
        return tuple(name for name in SOURCES if getattr(self, name))

    @cached_property
    def depends_on_velocity(self) -> bool:
        """True if some force depends on velocities."""
        rubs = any(slider.law != "coulomb" for slider in self.sliders)
        is_rough = bool(self.pairs) and (self.law.damping > 0 or self.law.friction > 0)
        resists = any(element.reads_velocity for element in (*self.links, *self.fields))
        return resists or rubs or is_rough

    @cached_property
    def reads_clock(self) -> bool:
        """True if some force depends on the time."""
        return any(element.reads_clock for element in (*self.links, *self.fields))

    @cached_property
    def is_rigid(self) -> bool:
        """True if contacts are impacts of the rigid law."""
        return self.law is not None and self.law.law == "rigid"

    @cached_property
    def is_smooth(self) -> bool:
        """True if the scene has no contacts, sliders, walls, piecewise fields or hooks, and so no
        events.
        """
        return not self.pairs and not self.sliders and not (self.walls or self.tents or self.hooks)


def world_of(scene: Scene, number: Callable[[float], Number]) -> World:
    """The scene with numbers of one precision. Elements that depend on the time keep doubles, and
    their force is rounded.
    """
    bodies = scene.bodies
    elements = {name: _all(scene, kind, number) for name, kind in ELEMENTS.items()}
    laws = _all(scene, Contact, number)
    touching = _touching(scene, number)
    joints = elements["joints"]
    inertia = [_moments(i, bodies, joints, number) for i in range(len(bodies))]
    links = [_of_precision(e, number) for e in scene.all(Link) if e.has_force]
    fields = [
        _of_precision(e, number) for e in scene.all(Field) if not isinstance(e, PiecewiseField)
    ]
    lengths = [_length(string, bodies, number) for string in elements["strings"]]
    mass = [number(m) for m in bodies.mass]
    radius = [number(r) for r in bodies.radius]
    fixed = [bool(is_fixed) for is_fixed in bodies.fixed]
    law = next(iter(laws), None)
    pairs = [pair for pair, _ in touching]
    corners = [corner for _, corner in touching]
    if starts_on_plane(scene):
        lying = [0]
    else:
        lying = []
    return World(
        number=number,
        mass=mass,
        inertia=inertia,
        radius=radius,
        fixed=fixed,
        links=links,
        fields=fields,
        law=law,
        pairs=pairs,
        corners=corners,
        lying=lying,
        string_lengths=lengths,
        **elements,
    )


Touching = tuple[tuple[int, int], Vector | None]
"""Two bodies (i, j) that can touch, or a body and plane n as (i, -1 - n); and the corner of body i
in body axes, for a polyhedron.
"""


def _touching(scene: Scene, number: Callable[[float], Number]) -> list[Touching]:
    """All pairs of a scene that can touch; none without a contact law."""
    if not scene.all(Contact):
        return []
    bodies = scene.bodies
    planes = [-1 - n for n in range(len(scene.all(Plane)))]
    round_bodies = [i for i, radius in enumerate(bodies.radius) if radius > 0]
    candidates: list[Touching] = [(pair, None) for pair in combinations(round_bodies, 2)]
    for i in round_bodies:
        candidates += [((i, plane), None) for plane in planes]
    for i, shape in enumerate(bodies.shape):
        if not isinstance(shape, Polyhedron):
            continue
        corners = [_tuple(corner, number) for corner in shape.vertices]
        candidates += [((i, plane), corner) for plane, corner in product(planes, corners)]
    return candidates


def _length(string: StringOverWheel, bodies: Bodies, number: Callable[[float], Number]) -> Number:
    """Length [m] of a string over a wheel without radius at the start."""
    # |r_a - c| + |r_b - c|.
    centre = np.array(string.centre)
    return sum(
        number(float(np.linalg.norm(bodies.position[i] - centre))) for i in (string.a, string.b)
    )


def _moments(
    i: int, bodies: Bodies, joints: list[Any], number: Callable[[float], Number]
) -> Vector:
    """Principal moments of a body, about its joint if it has one."""
    moments: Vector = _tuple(bodies.inertia[i], number)
    for joint in joints:
        if joint.a == i:
            moments = about_tip(moments, number(bodies.mass[i]), joint.anchor_a)
    return moments


def about_tip(inertia: Vector, mass: Number, anchor: Vector) -> Vector:
    """Principal moments about an anchor on a principal axis, by the parallel axis theorem."""
    x, y, z = anchor
    # J_i + m (|anchor|^2 - anchor_i^2).
    about_x = inertia[0] + mass * (y * y + z * z)
    about_y = inertia[1] + mass * (x * x + z * z)
    about_z = inertia[2] + mass * (x * x + y * y)
    return about_x, about_y, about_z


def start_of(scene: Scene, world: World, to_body: Callable[..., Vector]) -> State:
    """The state at the start, with omega in body axes by `to_body`; its modes are not set yet."""
    bodies = scene.bodies
    number = world.number
    attitude = _rows(bodies.attitude, number)
    omega = _rows(bodies.omega, number)
    omega_body = [to_body(q, w) for q, w in zip(attitude, omega, strict=True)]
    pairs = len(world.pairs)
    state = State(
        r=_rows(bodies.position, number),
        v=_rows(bodies.velocity, number),
        q=attitude,
        w=omega_body,
        stretch=[ZERO] * pairs,
        work=number(0.0),
    )
    # Modes, which are found before the first step.
    state.acting = [False] * pairs
    state.pressing = [False] * pairs
    state.sliding = [False] * pairs
    state.side = [0] * len(world.sliders)
    state.caught = [None] * len(world.hooks)
    return state


def _rows(column: Any, number: Callable[[float], Number]) -> list[Any]:
    """The rows of a column of the bodies, each a tuple of numbers in one precision."""
    return [_tuple(row, number) for row in column]


def _tuple(values: Any, number: Callable[[float], Number]) -> Any:
    """The values as a tuple of numbers in one precision."""
    return tuple(number(float(value)) for value in values)


def _all(scene: Scene, kind: type[Element], number: Callable[[float], Number]) -> list[Any]:
    """The elements of one kind with all their numbers in one precision."""
    return [_rounded(element, number) for element in scene.all(kind)]


def _of_precision(element: Element, number: Callable[[float], Number]) -> Any:
    """The element with its numbers in one precision, or unchanged if it depends on the time:
    rounding a phase before the cosine would add an error larger than the rounding of the force.
    """
    if element.reads_clock:
        return element
    return _rounded(element, number)


def _rounded(element: Any, number: Callable[[float], Number]) -> Any:
    """The element with all its numbers in one precision."""
    changed = {}
    for name in element.__struct_fields__:
        value = getattr(element, name)
        if isinstance(value, float):
            changed[name] = number(value)
        elif isinstance(value, tuple):
            changed[name] = _tuple(value, number)
    return msgspec.structs.replace(element, **changed)


PRECISIONS: dict[str, Callable[[float], Number]] = {"double": float, "single": np.float32}
