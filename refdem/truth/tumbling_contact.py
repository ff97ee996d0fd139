"""A box whose corners press on an inclined plane (linear law, sliding friction), as a system that
switches.

Axes of the slope: x down it, z its normal, the plane is z = 0; to space they turn by the angle
`slope` about y. State: quaternion, spin L, place, velocity, clock. A corner with arm s = R c has
the gap g = z + s_z and the velocity u = v + w x s; it presses with N = -k g - c g' and rubs with
friction N against (u_x, u_y), and no more once N would pull (cutoff zero_force).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from refdem.truth.events.system import Entry, Guard, Mode, along
from refdem.truth.reals import root
from refdem.truth.traced_field import Field, Node, Program, Trace

PRESSES = "p"
IDLES = "i"
SIGNS = tuple((x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
Vector = Sequence[Any]


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
        """Rates of the state while these corners press."""

        def rates(y: Vector) -> list[Any]:
            seen = Seen(self, y)
            angle = y[0] * 0 + self.slope
            force: list[Any] = [
                angle.sin() * self.gravity * self.mass,
                0,
                -angle.cos() * self.gravity * self.mass,
            ]
            torque: list[Any] = [0, 0, 0]
            for corner in sorted(pressing):
                push = seen.push(corner)
                force = [a + b for a, b in zip(force, push, strict=True)]
                torque = [a + b for a, b in zip(torque, cross(seen.arm(corner), push), strict=True)]
            return [*seen.turning(), *torque, *y[10:13], *(f / self.mass for f in force), 1]

        return rates

    @cached_property
    def window(self) -> Fraction:
        """About a third of a contact [s]."""
        return Fraction(float(self.mass / self.stiffness) ** 0.5)


class Seen:
    """What follows from a state: quantities that corners need."""

    def __init__(self, system: Slope, y: Vector) -> None:
        self.system = system
        self.y = y
        self.rows = rotation(y[:4])
        self.omega_body = [
            dot(column, y[4:7]) / j
            for column, j in zip(zip(*self.rows, strict=True), system.inertia, strict=True)
        ]
        self.omega = [dot(row, self.omega_body) for row in self.rows]

    def arm(self, corner: int) -> list[Any]:
        """The vector s (3) from the centre to a corner, in space axes."""
        half = [side(self.y[0] * 0 + square / 4) for square in self.system.squares]
        return [
            dot(row, [h * sign for h, sign in zip(half, SIGNS[corner], strict=True)])
            for row in self.rows
        ]

    def turning(self) -> list[Any]:
        """The rate q' = q omega_body / 2 of the attitude."""
        w, x, y, z = self.y[:4]
        a, b, c = self.omega_body
        return [
            (-x * a - y * b - z * c) / 2,
            (w * a + y * c - z * b) / 2,
            (w * b + z * a - x * c) / 2,
            (w * c + x * b - y * a) / 2,
        ]

    def velocity(self, corner: int) -> list[Any]:
        """The velocity u (3) of a corner in space axes."""
        return [
            v + w for v, w in zip(self.y[10:13], cross(self.omega, self.arm(corner)), strict=True)
        ]

    def gap(self, corner: int) -> Any:
        """The signed gap g between a corner and the plane."""
        return self.y[9] + self.arm(corner)[2]

    def pressure(self, corner: int) -> Any:
        """The normal force N on a corner."""
        return (
            -self.system.stiffness * self.gap(corner)
            - self.system.damping * self.velocity(corner)[2]
        )

    def push(self, corner: int) -> list[Any]:
        """The force on a corner that presses."""
        pressure = self.pressure(corner)
        if not self.system.friction:
            return [0, 0, pressure]
        x, y, _ = self.velocity(corner)
        rub = pressure * self.system.friction / (x * x + y * y).sqrt()
        return [-rub * x, -rub * y, pressure]


def side(square: Any) -> Any:
    """The root of a constant; exact where it is rational."""
    if isinstance(square, Node):
        exact = square.exact()
    else:
        exact = None
    if exact is None:
        found = None
    else:
        found = root(exact)
    if isinstance(found, Fraction):
        return square.trace.constant(found)
    return square.sqrt()


class Modes(dict[str, Mode]):
    """Modes by name, made as they are entered: each corner that touches, with p where it presses
    and i where it idles: `3p 5i`.
    """

    def __init__(self, system: Slope) -> None:
        super().__init__()
        self.system = system

    def __missing__(self, name: str) -> Mode:
        touching = {int(part[:-1]): part[-1] for part in name.split()}
        guards = [guard for corner in range(len(SIGNS)) for guard in self.guards(corner, touching)]
        pressing = frozenset(corner for corner, how in touching.items() if how == PRESSES)
        self[name] = Mode(self.system.field(pressing), tuple(guards), window=self.system.window)
        return self[name]

    def guards(self, corner: int, touching: dict[int, str]) -> list[Guard]:
        """What ends a corner's flight, pressure or idling."""

        def seen(y: Vector) -> Seen:
            return Seen(self.system, y)

        def entry(how: str, *vanishing: str) -> Any:
            if how:
                after = {**touching, corner: how}
            else:
                after = {c: h for c, h in touching.items() if c != corner}
            name = " ".join(f"{c}{h}" for c, h in sorted(after.items()))
            return lambda _: Entry(name, None, {f"{what}{corner}": 1 for what in vanishing})

        how = touching.get(corner)
        damped = self.system.damping > 0
        if how is None:
            return [
                Guard(
                    f"touch{corner}",
                    lambda y: seen(y).gap(corner),
                    entry(PRESSES, *([] if damped else ["release"])),
                )
            ]
        if how == PRESSES:
            if damped:
                after = entry(IDLES, "press")
            else:
                after = entry("", "touch")
            return [Guard(f"release{corner}", lambda y: seen(y).pressure(corner), after)]
        return [
            Guard(f"leave{corner}", lambda y: -seen(y).gap(corner), entry("", "touch")),
            Guard(f"press{corner}", lambda y: -seen(y).pressure(corner), entry(PRESSES, "release")),
        ]


def rotation(q: Vector) -> list[list[Any]]:
    """R of a unit quaternion, body to space."""
    w, x, y, z = q
    first = [w * w + x * x - y * y - z * z, (x * y - w * z) * 2, (x * z + w * y) * 2]
    second = [(x * y + w * z) * 2, w * w - x * x + y * y - z * z, (y * z - w * x) * 2]
    third = [(x * z - w * y) * 2, (y * z + w * x) * 2, w * w - x * x - y * y + z * z]
    return [first, second, third]


def dot(a: Vector, b: Vector) -> Any:
    """a . b of three numbers each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> list[Any]:
    """The cross product a x b of two vectors (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def lean_rates(guard: Guard, mode: Mode, size: int) -> list[Program]:
    """The first of the rates of a guard, whose zeros are simple, alone, and only the operations
    that it needs.
    """
    trace = Trace()
    y = [trace.node("in", i) for i in range(size)]
    value = guard.value(y)
    rates = [trace.constant(rate) for rate in mode.field(y)]
    return [Program([lean(node)]) for node in (value, along(value, rates))]


def lean(node: Node) -> Node:
    """The same node in a trace of nothing but what makes it."""
    fresh = Trace()
    kept = dict[int, int]()
    waiting = [node.index]
    needed = set()
    while waiting:
        index = waiting.pop()
        if index not in needed:
            needed.add(index)
            waiting += node.trace.operations[index][
                OPERANDS.get(node.trace.operations[index][0], 1) :
            ]
    for index in sorted(needed):
        kind, *parts = node.trace.operations[index]
        first = OPERANDS.get(kind, 1) - 1
        kept[index] = fresh.node(
            kind, *parts[:first], *(kept[part] for part in parts[first:])
        ).index
    return Node(fresh, kept[node.index])


OPERANDS = {"in": 2, "constant": 2, "scale": 2}
"""Where the numbers of earlier operations begin in an operation, if not right after its name."""
