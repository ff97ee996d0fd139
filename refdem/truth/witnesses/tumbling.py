"""Witness of the box on a slope: Euler's equations in body axes with R as nine numbers, contacts by
a scan and bisection.
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
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration of Euler's equations in body axes, contacts by a scan and bisection"
    " (refdem/truth/witnesses/tumbling.py)"
)
SCAN = 1 / 8192
"""Seconds between the looks for an event."""
OFF, PRESSES, IDLES = range(3)


def moving(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The free body as free rigid bodies move, with its centre; the box on the slope from contact
    to contact.
    """
    if p["member"] == "free":
        for t, values in rotations.free(p, times, claimed):
            if t is None:
                place = {}
            else:
                place = {
                    a: arb_of(v * t) for a, v in zip("xyz", vector(p, "velocity"), strict=True)
                }
            yield t, {**values, **place}
        return
    box = Box(p)
    begin = arb(0)
    waiting = list(times)
    state = box.start()
    modes = [OFF] * 8
    while waiting:
        phase = Solution(partial(box.rates, tuple(modes)), state, begin=begin)
        found = box.event(phase, modes, float(begin), float(waiting[-1]))
        while waiting and (found is None or arb_of(waiting[0]) < found[0]):
            t = waiting.pop(0)
            yield t, box.seen(phase.at(t))
        if found is None:
            return
        begin, corner, modes[corner] = found
        state = phase.at(begin)


class Box:
    """State: R row by row (body to space), omega_body, place, velocity."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        names = ("mass", "gravity", "slope", "height", "stiffness", "damping", "friction")
        self.e = {name: arb_of(number(p, name)) for name in names}
        self.p, self.inertia = p, [arb_of(j) for j in vector(p, "inertia")]
        self.normal = [self.e["slope"].sin(), arb(0), self.e["slope"].cos()]
        whole = sum(self.inertia, arb(0))
        half = [(6 * (whole - 2 * j) / self.e["mass"]).sqrt() / 2 for j in self.inertia]
        self.corners = [
            [half[i] * (1 if number >> i & 1 else -1) for i in range(3)] for number in range(8)
        ]

    def start(self) -> list[arb]:
        """The initial state: matrix, rates, position and velocity."""
        turned = rotations.quantities([arb(0)] * 3 + self.unit())
        place = [arb(0), arb(0), self.e["height"]]
        rows = [turned[f"R.{i}{j}"] for i in "xyz" for j in "xyz"]
        return [
            *rows,
            *(arb_of(w) for w in vector(self.p, "omega_body")),
            *place,
            *(arb_of(v) for v in vector(self.p, "velocity")),
        ]

    def unit(self) -> list[arb]:
        """The initial attitude (4), normalised."""
        q = [arb_of(x) for x in vector(self.p, "attitude")]
        size = sum((x * x for x in q), arb(0)).sqrt()
        return [x / size for x in q]

    def corner(self, y: Sequence[Any], number: int) -> tuple[list[Any], Any, Any, list[Any]]:
        """Arm in space, depth, push and velocity of a corner."""
        c = self.corners[number]
        (a, b, d) = y[9:12]
        swept = [b * c[2] - d * c[1], d * c[0] - a * c[2], a * c[1] - b * c[0]]
        arm, speed = ([dot(y[3 * i : 3 * i + 3], v) for i in range(3)] for v in (c, swept))
        speed = [v + w for v, w in zip(y[15:18], speed, strict=True)]
        depth = -dot([r + s for r, s in zip(y[12:15], arm, strict=True)], self.normal)
        return (
            arm,
            depth,
            depth * self.e["stiffness"] - dot(speed, self.normal) * self.e["damping"],
            speed,
        )

    def rates(self, modes: tuple[int, ...], t: Any, y: Sequence[Any]) -> list[Any]:
        """R' = R [omega], J omega' = (J omega) x omega + R^T torque, r' = v, m v' = F."""
        force = [y[0] * 0, y[0] * 0, y[0] * 0 - self.e["mass"] * self.e["gravity"]]
        torque = [y[0] * 0] * 3
        for pressing in (n for n, mode in enumerate(modes) if mode == PRESSES):
            arm, _, push, u = self.corner(y, pressing)
            along = dot(u, self.normal)
            slip = [a - n * along for a, n in zip(u, self.normal, strict=True)]
            if float(self.e["friction"]):
                rub = push * self.e["friction"] / dot(slip, slip).sqrt()
            else:
                rub = push * 0
            own = [push * n - rub * s for n, s in zip(self.normal, slip, strict=True)]
            force = [a + b for a, b in zip(force, own, strict=True)]
            torque = [a + b for a, b in zip(torque, crossed(arm, own), strict=True)]
        (a, b, c) = y[9:12]
        (j1, j2, j3) = self.inertia
        felt = [dot([y[i], y[3 + i], y[6 + i]], torque) for i in range(3)]
        spin = [
            (b * c * (j2 - j3) + felt[0]) / j1,
            (c * a * (j3 - j1) + felt[1]) / j2,
            (a * b * (j1 - j2) + felt[2]) / j3,
        ]
        turn = [x for i in range(3) for x in crossed(y[3 * i : 3 * i + 3], (a, b, c))]
        return [*turn, *spin, *y[15:18], *(f / self.e["mass"] for f in force)]

    def event(
        self, phase: Solution, modes: list[int], begin: float, last: float
    ) -> tuple[arb, int, int] | None:
        """When, at which corner, and its next mode; None if not before the last time."""
        t = begin
        while t <= last:
            t += SCAN
            found = [self.ended(phase, n, mode, begin, t) for n, mode in enumerate(modes)]
            if any(found):
                return min((one for one in found if one), key=lambda one: float(one[0]))
        return None

    def ended(
        self, phase: Solution, number: int, mode: int, begin: float, t: float
    ) -> tuple[arb, int, int] | None:
        """The event of one corner in the stretch before t: it touches, would pull, leaves, or
        presses again.
        """
        _, depth, push, _ = self.corner(phase.at(arb(t)), number)
        low = max(begin, t - SCAN) + 1e-9
        if mode == OFF and depth > 0:
            return phase.bisected(lambda y: self.corner(y, number)[1], low, t), number, PRESSES
        if mode == PRESSES and push < 0:
            return (
                phase.bisected(lambda y: -self.corner(y, number)[2], low, t),
                number,
                IDLES if self.e["damping"] > 0 else OFF,
            )
        if mode == IDLES and depth < 0:
            return phase.bisected(lambda y: -self.corner(y, number)[1], low, t), number, OFF
        if mode == IDLES and push > 0:
            return (phase.bisected(lambda y: self.corner(y, number)[2], low, t), number, PRESSES)
        return None

    def seen(self, y: Sequence[arb]) -> dict[str, arb]:
        """omega_body, omega, R and the place."""
        found = {
            f"R.{i}{j}": y[3 * m + n] for m, i in enumerate("xyz") for n, j in enumerate("xyz")
        }
        found |= {f"omega_body.{a}": w for a, w in zip("xyz", y[9:12], strict=True)}
        found |= {f"omega.{a}": dot(y[3 * i : 3 * i + 3], y[9:12]) for i, a in enumerate("xyz")}
        return found | dict(zip("xyz", y[12:15], strict=True))


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The dot product a . b of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def crossed(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The cross product a x b of two vectors (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


WITNESSES = {"neglected-gyroscopic": Witness(METHOD, moving)}
