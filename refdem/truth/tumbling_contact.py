"""A box whose corners press on an inclined plane (linear law, sliding friction), as a system that
switches.

Axes of the slope: x down it, z its normal, the plane is z = 0; to space they turn by the angle
`slope` about y. State: quaternion (4), angular momentum L (3), position (3), velocity (3), clock. A
corner with arm s = R c has the gap g = z + s_z and the velocity u = v + w x s; it presses with N =
-k g - c g', friction mu N acts against (u_x, u_y), and both end where N would pull (cutoff
zero_force).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from flint import arb

from refdem.truth.events.system import Entry, Guard, Mode, State, along
from refdem.truth.reals import root
from refdem.truth.traced_field import NONE, Field, Node, Program, Trace
from refdem.truth.vectors import Vector, cross, dot

PRESSES = "p"
"""The mark of a corner that presses, in the name of a mode."""
IDLES = "i"
"""The mark of a corner that is below the plane and does not press, as its dashpot would pull."""
SIGNS = tuple((x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
"""The corners of the box, by the signs of their coordinates in body axes."""

Stops = Callable[[State], arb | None]
"""A bound of the time [s] until a corner stops, from balls of a state; None if none is proved."""


@dataclass(frozen=True)
class Slope:
    """Exact parameters of the body and the plane, in SI units.

    `slope` is the angle [rad], `squares` are those of the sides of the box.
    """

    mass: Fraction
    inertia: tuple[Fraction, ...]
    squares: tuple[Fraction, ...]
    gravity: Fraction
    slope: Fraction
    stiffness: Fraction
    damping: Fraction
    friction: Fraction

    def field(self, pressing: frozenset[int]) -> Field:
        """The rates of the state while these corners (by number) press.

        q' = q omega_body/2, L' = sum of s x F, x' = v, v' = F/m + gravity.
        """

        return lambda y: self.rates(y, pressing, {})

    def rates(self, y: Vector, pressing: frozenset[int], forces: Mapping[int, Vector]) -> list[Any]:
        """The rates of the state y while these corners press; `forces` (3) are on corners where
        they are not those of the law.
        """
        body = BodyState(self, y)
        # The angle as a number of the trace, which has sin and cos.
        angle = y[0] * 0 + self.slope
        # The weight m g (sin(slope), 0, -cos(slope)).
        force: list[Any] = [
            angle.sin() * self.gravity * self.mass,
            0,
            -angle.cos() * self.gravity * self.mass,
        ]
        torque: list[Any] = [0, 0, 0]
        for corner in sorted(pressing):
            corner_force = forces.get(corner) or body.force_on(corner)
            # L' = sum of s x F, m v' = weight + sum of F, over the corners that press.
            corner_torque = cross(body.arm(corner), corner_force)
            force = [a + b for a, b in zip(force, corner_force, strict=True)]
            torque = [a + b for a, b in zip(torque, corner_torque, strict=True)]
        velocity = y[10:13]
        acceleration = [f / self.mass for f in force]
        clock_rate = 1
        return [*body.attitude_rate(), *torque, *velocity, *acceleration, clock_rate]

    @cached_property
    def window(self) -> Fraction:
        """The window [s] of a search for events: about a third of a contact, sqrt(m/k)."""
        return Fraction(float(self.mass / self.stiffness) ** 0.5)


class BodyState:
    """A state y of the body, with the quantities of its corners that follow from it.

    `rows` is the rotation matrix R, from body axes to those of the slope; `omega_body` is J^-1 R^T
    L, `omega` R of that.
    """

    def __init__(self, system: Slope, y: Vector) -> None:
        self.system = system
        self.y = y
        self.rows = rotation(y[:4])
        columns = zip(*self.rows, strict=True)
        momentum = y[4:7]
        self.omega_body = [
            dot(column, momentum) / moment
            for column, moment in zip(columns, system.inertia, strict=True)
        ]
        self.omega = [dot(row, self.omega_body) for row in self.rows]

    def arm(self, corner: int) -> list[Any]:
        """The vector s = R c (3) from the centre to a corner, in the axes of the slope."""
        half_sides = [side(self.y[0] * 0 + square / 4) for square in self.system.squares]
        arm_body = [half * sign for half, sign in zip(half_sides, SIGNS[corner], strict=True)]
        return [dot(row, arm_body) for row in self.rows]

    def attitude_rate(self) -> list[Any]:
        """The rate q' = q omega_body/2 (4) of the attitude."""
        w, x, y, z = self.y[:4]
        a, b, c = self.omega_body
        # (w, r)(0, o) = (-r . o, w o + r x o) for r = (x, y, z) and o = omega_body = (a, b, c).
        w_rate = (-x * a - y * b - z * c) / 2
        x_rate = (w * a + y * c - z * b) / 2
        y_rate = (w * b + z * a - x * c) / 2
        z_rate = (w * c + x * b - y * a) / 2
        return [w_rate, x_rate, y_rate, z_rate]

    def velocity(self, corner: int) -> list[Any]:
        """The velocity u = v + omega x s (3) of a corner, in the axes of the slope."""
        by_turning = cross(self.omega, self.arm(corner))
        return [v + w for v, w in zip(self.y[10:13], by_turning, strict=True)]

    def gap(self, corner: int) -> Any:
        """The signed gap g = z + s_z between a corner and the plane."""
        return self.y[9] + self.arm(corner)[2]

    def pressure(self, corner: int) -> Any:
        """The normal force N = -k g - c g' on a corner."""
        gap_rate = self.velocity(corner)[2]
        return -self.system.stiffness * self.gap(corner) - self.system.damping * gap_rate

    def force_on(self, corner: int) -> list[Any]:
        """The force (3) on a corner that presses: N along z, and friction mu N against (u_x,
        u_y).
        """
        pressure = self.pressure(corner)
        if not self.system.friction:
            return [0, 0, pressure]
        x, y, _ = self.velocity(corner)
        # F = N (-mu u_x/|u_t|, -mu u_y/|u_t|, 1), u_t = (u_x, u_y)
        friction_per_speed = pressure * self.system.friction / (x * x + y * y).sqrt()
        return [-friction_per_speed * x, -friction_per_speed * y, pressure]


def side(square: Any) -> Any:
    """The root of a number of a trace; an exact constant where it is rational."""
    if isinstance(square, Node):
        exact = square.exact()
        if exact is not None and isinstance(root(exact), Fraction):
            return square.trace.constant(root(exact))
    return square.sqrt()


StopsOf = Callable[[Slope, frozenset[int], Sequence[Guard]], Stops | None]


class Modes(dict[str, Mode]):
    """Modes by name, made as they are entered.

    A name has each corner that touches, with p where it presses and i where it idles: `3p 5i`.
    `stops` gives the proof that a corner stops (refdem/truth/tumbling_stop.py) from the system, the
    corners that press and the guards.
    """

    def __init__(self, system: Slope, stops: StopsOf) -> None:
        super().__init__()
        self.system = system
        self.stops = stops

    def __missing__(self, name: str) -> Mode:
        marks = {int(part[:-1]): part[-1] for part in name.split()}
        guards: list[Guard] = []
        for corner in range(len(SIGNS)):
            guards += self.guards(corner, marks)
        pressing = frozenset(corner for corner, mark in marks.items() if mark == PRESSES)
        self[name] = Mode(
            self.system.field(pressing),
            tuple(guards),
            window=self.system.window,
            stops=self.stops(self.system, pressing, guards),
        )
        return self[name]

    def guards(self, corner: int, marks: dict[int, str]) -> list[Guard]:
        """The guards that end a corner's flight, pressure or idling, in the mode in which the
        corners that touch have these marks.
        """

        def gap(y: Vector) -> Any:
            return BodyState(self.system, y).gap(corner)

        def pressure(y: Vector) -> Any:
            return BodyState(self.system, y).pressure(corner)

        def entry(mark: str, *vanishing: str) -> Callable[[State], Entry]:
            """The entry into the mode with another mark of the corner (none: it flies), in which
            these guards of the corner vanish at first.
            """
            others = {other: kept for other, kept in marks.items() if other != corner}
            if mark:
                others[corner] = mark
            name = " ".join(f"{number}{kept}" for number, kept in sorted(others.items()))
            touching = {f"{guard}{corner}": 1 for guard in vanishing}
            return lambda _: Entry(name, None, touching)

        mark = marks.get(corner)
        is_damped = self.system.damping > 0
        if mark is None:
            # A dashpot presses at once; a spring's force begins at zero.
            if is_damped:
                touched = entry(PRESSES)
            else:
                touched = entry(PRESSES, "release")
            return [Guard(f"touch{corner}", gap, touched)]
        if mark == PRESSES:
            # A damped corner is still below the plane where its force ends.
            if is_damped:
                released = entry(IDLES, "press")
            else:
                released = entry("", "touch")
            return [Guard(f"release{corner}", pressure, released)]
        return [
            Guard(f"leave{corner}", lambda y: -gap(y), entry("", "touch")),
            Guard(f"press{corner}", lambda y: -pressure(y), entry(PRESSES, "release")),
        ]


def rotation(q: Vector) -> list[list[Any]]:
    """The matrix R of a unit quaternion, from body axes to those of the slope."""
    w, x, y, z = q
    first = [w * w + x * x - y * y - z * z, (x * y - w * z) * 2, (x * z + w * y) * 2]
    second = [(x * y + w * z) * 2, w * w - x * x + y * y - z * z, (y * z - w * x) * 2]
    third = [(x * z - w * y) * 2, (y * z + w * x) * 2, w * w - x * x - y * y + z * z]
    return [first, second, third]


def lean_rates(guard: Guard, mode: Mode, size: int, directions: range = NONE) -> list[Program]:
    """Programs of a guard's value and of its first rate, with only the operations that each needs.

    All zeros of these guards are simple: no higher rate is needed.
    """
    trace = Trace(size, directions)
    y = [trace.node("in", i) for i in range(size)]
    value = guard.value(y)
    rates = [trace.constant(rate) for rate in mode.field(y)]
    return [Program([lean(node)]) for node in (value, along(value, rates))]


def lean(node: Node) -> Node:
    """The same node in a new trace that has only the operations which its value needs."""
    operations = node.trace.operations
    needed = set()
    waiting = [node.index]
    while waiting:
        index = waiting.pop()
        if index not in needed:
            needed.add(index)
            kind, *parts = operations[index]
            waiting += parts[CONSTANTS.get(kind, 0) :]
    # In rising order every operand has its new number before it is used.
    fresh = Trace()
    new_index = dict[int, int]()
    for index in sorted(needed):
        kind, *parts = operations[index]
        count = CONSTANTS.get(kind, 0)
        operands = [new_index[part] for part in parts[count:]]
        new_index[index] = fresh.node(kind, *parts[:count], *operands).index
    return Node(fresh, new_index[node.index])


CONSTANTS = {"in": 1, "constant": 1, "scale": 1}
"""The number of parts of an operation, by its kind, that are no numbers of earlier operations."""
