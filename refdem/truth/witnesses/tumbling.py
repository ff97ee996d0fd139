"""Witness of the box on a slope: Euler's equations in body axes with the nine entries of R as
coordinates; contacts are found by a scan and bisection.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses import rotations
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of Euler's equations in body axes, contacts by a scan and bisection"
    " (refdem/truth/witnesses/tumbling.py)"
)
SCAN = 1 / 8192
"""Step [s] in which the motion is searched for events."""
OFF, PRESSES, IDLES = range(3)
"""Modes of a corner: above the plane; below it with a force F > 0; below it with the force 0,
because k depth - c v.n would be negative.
"""


def moving(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states of the member: a free box, or a box on the slope.

    The free box is a free rigid body whose centre moves uniformly. On the slope the equations of
    motion are integrated from one change of a corner's mode to the next.
    """
    if p["member"] == "free":
        for t, values in rotations.free(p, times, claimed):
            position = {}
            if t is not None:
                for axis, v in zip("xyz", vector(p, "velocity"), strict=True):
                    position[axis] = arb_of(v * t)
            yield t, {**values, **position}
        return
    box = Box(p)
    begin = arb(0)
    waiting = list(times)
    state = box.start()
    modes = [OFF] * 8
    while waiting:
        phase = Solution(partial(box.rates, tuple(modes)), state, begin=begin)
        event = box.event(phase, modes, float(begin), float(waiting[-1]))
        while waiting and (event is None or arb_of(waiting[0]) < event[0]):
            t = waiting.pop(0)
            yield t, box.seen(phase.at(t))
        if event is None:
            return
        begin, corner, next_mode = event
        modes[corner] = next_mode
        state = phase.at(begin)


class Box:
    """A box above the plane r . n = 0 with the unit normal n, with forces at its eight corners.

    The state is R row by row (0 to 8, body to space), omega_body (9 to 11), position (12 to 14) and
    velocity (15 to 17).
    """

    def __init__(self, p: Mapping[str, Exact]) -> None:
        names = ("mass", "gravity", "slope", "height", "stiffness", "damping", "friction")
        self.e = {name: arb_of(number(p, name)) for name in names}
        self.p = p
        self.inertia = [arb_of(j) for j in vector(p, "inertia")]
        self.normal = [self.e["slope"].sin(), arb(0), self.e["slope"].cos()]
        # J_1 = m (b^2 + c^2)/12 and so on: side_i^2 = 6 (J1 + J2 + J3 - 2 J_i)/m.
        total = sum(self.inertia, arb(0))
        x, y, z = ((6 * (total - 2 * j) / self.e["mass"]).sqrt() / 2 for j in self.inertia)
        self.corners = [
            [sign_x * x, sign_y * y, sign_z * z]
            for sign_z in (-1, 1)
            for sign_y in (-1, 1)
            for sign_x in (-1, 1)
        ]

    def start(self) -> list[arb]:
        """The initial state (18): R row by row, omega_body, position, velocity."""
        of_attitude = rotations.quantities([arb(0)] * 3 + self.unit())
        matrix = [of_attitude[f"R.{i}{j}"] for i in "xyz" for j in "xyz"]
        omega_body = [arb_of(w) for w in vector(self.p, "omega_body")]
        position = [arb(0), arb(0), self.e["height"]]
        velocity = [arb_of(v) for v in vector(self.p, "velocity")]
        return [*matrix, *omega_body, *position, *velocity]

    def unit(self) -> list[arb]:
        """The initial attitude (4), normalised."""
        q = [arb_of(x) for x in vector(self.p, "attitude")]
        size = sum((x * x for x in q), arb(0)).sqrt()
        return [x / size for x in q]

    def corner(self, y: Sequence[Any], number: int) -> tuple[list[Any], Any, Any, list[Any]]:
        """The arm (3, in space), depth, normal force and velocity (3) of a corner.

        arm = R c and velocity = v + R (omega_body x c) for the corner c in body axes; depth = -(r +
        arm) . n; force = k depth - c velocity . n.
        """
        # R has the rows y[0:3], y[3:6] and y[6:9].
        arm_body = self.corners[number]
        omega_body = y[9:12]
        velocity_body = crossed(omega_body, arm_body)
        arm = [dot(y[3 * i : 3 * i + 3], arm_body) for i in range(3)]
        turning = [dot(y[3 * i : 3 * i + 3], velocity_body) for i in range(3)]
        velocity = [v + w for v, w in zip(y[15:18], turning, strict=True)]
        depth = -dot([r + s for r, s in zip(y[12:15], arm, strict=True)], self.normal)
        force = depth * self.e["stiffness"] - dot(velocity, self.normal) * self.e["damping"]
        return arm, depth, force, velocity

    def rates(self, modes: tuple[int, ...], t: Any, y: Sequence[Any]) -> list[Any]:
        """The right-hand side of the equations of motion.

            R' = R [omega_body],    J omega_body' = (J omega_body) x omega_body + R^T T,
            r' = v,                 m v' = F,    [w] a = w x a

        F is the weight and, for each corner in the mode PRESSES, f = N n - mu N slip/|slip| with
        the normal force N and slip = v - (v . n) n of the corner; T is the sum of arm x f.
        """
        force = [y[0] * 0, y[0] * 0, y[0] * 0 - self.e["mass"] * self.e["gravity"]]
        torque = [y[0] * 0] * 3
        for pressing in (n for n, mode in enumerate(modes) if mode == PRESSES):
            arm, _, push, velocity = self.corner(y, pressing)
            along = dot(velocity, self.normal)
            slip = [v - n * along for v, n in zip(velocity, self.normal, strict=True)]
            if float(self.e["friction"]):
                friction = push * self.e["friction"] / dot(slip, slip).sqrt()
            else:
                friction = push * 0
            # f = N n - mu N slip/|slip|
            at_corner = [push * n - friction * s for n, s in zip(self.normal, slip, strict=True)]
            force = [a + b for a, b in zip(force, at_corner, strict=True)]
            torque = [a + b for a, b in zip(torque, crossed(arm, at_corner), strict=True)]
        a, b, c = y[9:12]
        j1, j2, j3 = self.inertia
        # R^T torque, by the columns of R.
        torque_body = [dot([y[i], y[3 + i], y[6 + i]], torque) for i in range(3)]
        # J omega_body' = (J omega_body) x omega_body + R^T T
        omega_rate = [
            (b * c * (j2 - j3) + torque_body[0]) / j1,
            (c * a * (j3 - j1) + torque_body[1]) / j2,
            (a * b * (j1 - j2) + torque_body[2]) / j3,
        ]
        # R' = R [omega_body]: each row of R has the rate row x omega_body.
        matrix_rate = [x for i in range(3) for x in crossed(y[3 * i : 3 * i + 3], (a, b, c))]
        acceleration = [f / self.e["mass"] for f in force]
        return [*matrix_rate, *omega_rate, *y[15:18], *acceleration]

    def event(
        self, phase: Solution, modes: list[int], begin: float, last: float
    ) -> tuple[arb, int, int] | None:
        """The first event as its time, corner and next mode; None if none is before `last` [s]."""
        t = begin
        while t <= last:
            t += SCAN
            events = []
            for corner, mode in enumerate(modes):
                event = self.ended(phase, corner, mode, begin, t)
                if event is not None:
                    events.append(event)
            if events:
                return min(events, key=lambda event: float(event[0]))
        return None

    def ended(
        self, phase: Solution, number: int, mode: int, begin: float, t: float
    ) -> tuple[arb, int, int] | None:
        """The event (time, corner, next mode) of one corner in the step before t; None if none.

        OFF to PRESSES where the depth becomes positive; PRESSES to IDLES where the force becomes
        negative; IDLES to OFF where the depth becomes negative, IDLES to PRESSES where the force
        becomes positive. Without damping force and depth vanish together: PRESSES to OFF.
        """
        _, depth, push, _ = self.corner(phase.at(arb(t)), number)
        low = max(begin, t - SCAN) + 1e-9

        def depth_of(y: Sequence[arb]) -> Any:
            return self.corner(y, number)[1]

        def push_of(y: Sequence[arb]) -> Any:
            return self.corner(y, number)[2]

        if mode == OFF and depth > 0:
            return phase.bisected(depth_of, low, t), number, PRESSES
        if mode == PRESSES and push < 0:
            if self.e["damping"] > 0:
                next_mode = IDLES
            else:
                next_mode = OFF
            return phase.bisected(lambda y: -push_of(y), low, t), number, next_mode
        if mode == IDLES and depth < 0:
            return phase.bisected(lambda y: -depth_of(y), low, t), number, OFF
        if mode == IDLES and push > 0:
            return phase.bisected(push_of, low, t), number, PRESSES
        return None

    def seen(self, y: Sequence[arb]) -> dict[str, arb]:
        """The quantities omega_body, omega = R omega_body, R and the position of a state."""
        omega_body = y[9:12]
        quantities = dict(zip("xyz", y[12:15], strict=True))
        for i, axis in enumerate("xyz"):
            row = y[3 * i : 3 * i + 3]
            quantities[f"omega_body.{axis}"] = omega_body[i]
            quantities[f"omega.{axis}"] = dot(row, omega_body)
            for column, entry in zip("xyz", row, strict=True):
                quantities[f"R.{axis}{column}"] = entry
        return quantities


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The dot product a . b of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def crossed(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The cross product a x b of two vectors (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


WITNESSES = {"neglected-gyroscopic": Witness(METHOD, moving)}
