"""A scene as plain numbers of one precision, and the state that changes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import Any

import msgspec
import numpy as np

from refdem.faults.holding import about_tip
from refdem.faults.vectors import ZERO, Number, Quaternion, Vector
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.elements.wedge import Wedge
from refdem.scene.shapes import Polyhedron

SUPPORTED = (
    *(BallJoint, Catch, CentralField, Contact, Dashpot, Force, PiecewiseField, Plane),
    *(Rod, Slider, Spring, StringOverWheel, UniformGravity, Wedge),
)
SOURCES = (
    "springs",
    "dashpots",
    "drives",
    "fields",
    "pairs",
    "gravity",
    "tents",
    "walls",
    "joints",
    "sliders",
)
"""Fields of a world whose contents act on bodies; joints and sliders last: they answer to all else.
"""


@dataclass(slots=True)
class State:
    """Position, velocity, attitude and omega_body of every body; the spring of every pair; work
    against dissipation; the time.

    Modes, constant within a step: which pairs act, which of them press, whose tangential springs
    slide at their limit, towards which side every slider moves (0: sticks), and the line (a rod, or
    None) of every hook.
    """

    r: list[Vector]
    v: list[Vector]
    q: list[Quaternion]
    w: list[Vector]
    stretch: list[Vector]
    work: Number = 0.0
    acting: list[bool] = field(default_factory=list)
    pressing: list[bool] = field(default_factory=list)
    sliding: list[bool] = field(default_factory=list)
    side: list[int] = field(default_factory=list)
    t: float = 0.0
    caught: list[Any] = field(default_factory=list)

    def moved(
        self, r: list[Vector], v: list[Vector], q: list[Quaternion], w: list[Vector], t: float
    ) -> "State":
        """The state with other places and rates at the time t; it shares all else, and lists that
        are given as they are.

        So a list of a state that was handed on is replaced, never changed; who changes one in place
        takes a copy first.
        """
        return State(
            r,
            v,
            q,
            w,
            self.stretch,
            self.work,
            self.acting,
            self.pressing,
            self.sliding,
            self.side,
            t,
            self.caught,
        )

    def copy(self) -> "State":
        """A state that can be changed without changing this one."""
        return State(
            list(self.r),
            list(self.v),
            list(self.q),
            list(self.w),
            list(self.stretch),
            self.work,
            list(self.acting),
            list(self.pressing),
            list(self.sliding),
            list(self.side),
            self.t,
            list(self.caught),
        )


@dataclass(frozen=True)
class World:
    """What does not change: numbers of bodies and elements, all of precision `number`."""

    number: Callable[[float], Number]
    mass: list[Number]
    inertia: list[Vector]
    radius: list[Number]
    fixed: list[bool]
    springs: list[Any]
    dashpots: list[Any]
    drives: list[Any]
    sliders: list[Any]
    rods: list[Any]
    planes: list[Any]
    law: Any
    gravity: list[Vector]
    fields: list[Number]
    pairs: list[tuple[int, int]]
    corners: list[Vector | None]
    tents: list[Any]
    walls: list[Any]
    hooks: list[Any]
    strings: list[Any]
    string_lengths: list[Number]
    joints: list[Any]

    @cached_property
    def turns(self) -> list[bool]:
        """Bodies that have moments of inertia."""
        return [inertia[0] > 0 for inertia in self.inertia]

    @cached_property
    def sources(self) -> tuple[str, ...]:
        """What there is that acts, in the order in which it is added."""
        return tuple(name for name in SOURCES if getattr(self, name))

    @cached_property
    def is_smooth(self) -> bool:
        """No forces that depend on velocity and none that jump."""
        return not self.pairs and not self.sliders and not (self.walls or self.tents or self.hooks)


def world_of(scene: Scene, number: Callable[[float], Number]) -> World:
    """The scene in numbers of one precision; pairs (i, j) of bodies, or (i, -1 - n) of a body, or a
    corner of it, and plane n.
    """
    bodies = scene.bodies
    planes = scene.all(Plane)
    laws = scene.all(Contact)
    round_bodies = [i for i, radius in enumerate(bodies.radius) if radius > 0]
    if laws:
        pairs = [
            *combinations(round_bodies, 2),
            *((i, -1 - n) for i in round_bodies for n in range(len(planes))),
        ]
    else:
        pairs = []
    corners: list[Vector | None] = [None] * len(pairs)
    for i, shape in enumerate(bodies.shape) if laws else ():
        if isinstance(shape, Polyhedron):
            found = [(-1 - n, corner) for n in range(len(planes)) for corner in shape.vertices]
            pairs += [(i, plane) for plane, _ in found]
            corners += [_tuple(corner, number) for _, corner in found]
    joints, strings = (
        [_rounded(e, number) for e in scene.all(kind)] for kind in (BallJoint, StringOverWheel)
    )
    return World(
        number=number,
        mass=[number(m) for m in bodies.mass],
        inertia=[_moments(i, bodies, joints, number) for i in range(len(bodies))],
        radius=[number(radius) for radius in bodies.radius],
        fixed=[bool(fixed) for fixed in bodies.fixed],
        springs=[_rounded(e, number) for e in scene.all(Spring)],
        dashpots=[_rounded(e, number) for e in scene.all(Dashpot)],
        drives=scene.all(Force),
        sliders=[_rounded(e, number) for e in scene.all(Slider)],
        rods=[_rounded(e, number) for e in scene.all(Rod)],
        planes=[_rounded(e, number) for e in planes],
        law=_rounded(laws[0], number) if laws else None,
        gravity=[_tuple(e.g, number) for e in scene.all(UniformGravity)],
        fields=[number(e.gm) for e in scene.all(CentralField)],
        pairs=pairs,
        corners=corners,
        tents=[_rounded(e, number) for e in scene.all(PiecewiseField)],
        walls=[_rounded(e, number) for e in scene.all(Wedge)],
        hooks=[_rounded(e, number) for e in scene.all(Catch)],
        strings=strings,
        string_lengths=[
            sum(
                number(float(np.linalg.norm(bodies.position[i] - np.array(s.centre))))
                for i in (s.a, s.b)
            )
            for s in strings
        ],
        joints=joints,
    )


def _moments(i: int, bodies: Any, joints: list[Any], number: Callable[[float], Number]) -> Vector:
    """Principal moments of a body, about its joint if it has one."""
    moments: Vector = _tuple(bodies.inertia[i], number)
    for joint in joints:
        if joint.a == i:
            moments = about_tip(moments, number(bodies.mass[i]), joint.anchor_a)
    return moments


def start_of(scene: Scene, world: World, to_body: Callable[..., Vector]) -> State:
    """The state at the start; modes are not yet known."""
    bodies = scene.bodies
    number = world.number
    q: list[Any] = [_tuple(q, number) for q in bodies.attitude]
    return State(
        r=[_tuple(r, number) for r in bodies.position],
        v=[_tuple(v, number) for v in bodies.velocity],
        q=q,
        w=[
            to_body(turn, _tuple(omega, number))
            for turn, omega in zip(q, bodies.omega, strict=True)
        ],
        stretch=[ZERO] * len(world.pairs),
        work=number(0.0),
        acting=[False] * len(world.pairs),
        pressing=[False] * len(world.pairs),
        sliding=[False] * len(world.pairs),
        side=[0] * len(world.sliders),
        caught=[None] * len(world.hooks),
    )


def _tuple(values: Any, number: Callable[[float], Number]) -> Any:
    return tuple(number(float(value)) for value in values)


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
