"""Spheres over a floor in gravity under the linear law: one that bounces, two squeezed between
walls.

Linear equations between the switches, each followed by validated integration; a flight ends at the
root of its parabola. Floor y = 0, gravity along -y, t >= 0; the force of a contact ends with its
overlap. Quantities r, v, omega of each sphere by axis.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import Size
from refdem.truth.contact_phases import dyadic_root
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, State
from refdem.truth.events.truth import HybridFlow
from refdem.truth.reals import Number, near, pi, root


@dataclass(frozen=True, kw_only=True)
class Floor:
    """Parameters of a sphere above a floor, in SI units."""

    mass: Number
    radius: Fraction
    stiffness: Fraction
    damping: Number
    gravity: Fraction

    @property
    def window(self) -> Fraction:
        """About the law's own time [s]."""
        return dyadic_root(near(self.mass) / (3 * self.stiffness))


class OnFloor(HybridFlow):
    """A hybrid flow whose spheres have all nine quantities; those that its motion does not name are
    exactly zero.
    """

    witness = "damped sines and parabolas in closed form with their switches found anew"
    spheres: Sequence[str] = ("",)

    def at(self, t: Fraction) -> dict[str, Ball]:
        """Every quantity of the case at time t, as balls."""
        if t < 0:
            raise NotCertifiedError("impact-benchmarks: t < 0 is before the start")
        still = (
            f"{kind}{i}.{axis}"
            for i in self.spheres
            for kind in ("r", "v", "omega")
            for axis in "xyz"
        )
        return {name: Ball(Fraction(0), Fraction(0)) for name in still} | super().at(t)


class Bounce(OnFloor):
    """y' = v; v' = -g in flight, k d/m - c v/m - g in contact, d = R - y; state (y - R, v,
    clock).
    """

    def __init__(
        self,
        scale: Mapping[str, Size],
        floor: Floor,
        *,
        height: Fraction,
        restitution: Fraction,
        bounces: int,
    ) -> None:
        self.floor = floor
        self.until = time_of_bounces(floor, height, restitution, bounces)
        start = (height - floor.radius, Fraction(0), Fraction(0))
        radius = floor.radius
        super().__init__(
            self.modes_of(floor),
            start,
            lambda y: Entry("fly"),
            lambda y: {"r.y": y[0] + radius, "v.y": y[1]},
            scale,
            state=("r.y", "v.y"),
            moved=(0, 1),
        )

    @staticmethod
    def modes_of(floor: Floor) -> dict[str, Mode]:
        """The two modes of the motion, flight and contact, by name."""
        k = floor.stiffness / floor.mass
        c = floor.damping / floor.mass
        g = floor.gravity
        land = Guard("land", lambda y: y[0], lambda y: Entry("press", on_floor, {"part": 1}))
        part = Guard("part", lambda y: -y[0], lambda y: Entry("fly", on_floor, {"land": 1}))
        return {
            "fly": Mode(lambda y: [y[1], -g, 1], (land,), partial(falls, g)),
            "press": Mode(
                lambda y: [y[1], -y[0] * k - y[1] * c - g, 1], (part,), window=floor.window
            ),
        }

    def scalars(self) -> dict[str, Ball]:
        """apex_n [m]: height of the centre at the top of the flight after bounce n, for the bounces
        before `until` [s].
        """

        def found(motion: HybridMotion) -> dict[str, arb]:
            motion.at(arb_of(self.until))
            ups = [
                event
                for event in motion.events
                if event.name == "part" and event.time < arb_of(self.until)
            ]
            twice = arb_of(2 * self.floor.gravity)
            return {
                f"apex_{n + 1}": arb_of(self.floor.radius) + up.state[1] ** 2 / twice
                for n, up in enumerate(ups)
            }

        return self.climbed(found, "apexes")


def time_of_bounces(floor: Floor, height: Fraction, restitution: Fraction, bounces: int) -> Number:
    """About the time [s] of the top of the flight after so many bounces: of a hard sphere's
    flights, and half a swing a contact.

    A flight with the speed e^n sqrt(2 g (h - R)) rises for e^n sqrt(2 (h - R)/g).
    """
    fall = root(2 * (height - floor.radius) / floor.gravity)
    flights = (
        1 + 2 * sum((restitution**n for n in range(1, bounces)), Fraction(0)) + restitution**bounces
    )
    contact = pi() * root(floor.mass / floor.stiffness)
    lasts: Number = fall * flights + bounces * contact
    return lasts


def on_floor(y: Any) -> list[Any]:
    """The same state with no overlap, exactly."""
    return [0, y[1], y[2]]


def falls(g: Fraction, y: State) -> tuple[str, arb]:
    """The event that ends a flight, and the time [s] until it."""
    return "land", (y[1] + (y[1] * y[1] + 2 * arb_of(g) * y[0]).sqrt()) / arb_of(g)


class Stack(OnFloor):
    """Two spheres of one radius between the floor and a ceiling: three springs that press; state
    (y1, v1, y2, v2, clock).
    """

    spheres = ("1", "2")

    def __init__(
        self,
        scale: Mapping[str, Size],
        floor: Floor,
        *,
        upper_mass: Number,
        ceiling: Fraction,
        starts: Sequence[Fraction],
    ) -> None:
        zero = Fraction(0)
        radius = floor.radius

        def overlaps(y: Sequence[Any]) -> list[Any]:
            return [radius - y[0], 2 * radius - (y[2] - y[0]), y[2] + radius - ceiling]

        def field(y: Sequence[Any]) -> list[Any]:
            rates = (-y[1], y[1] - y[3], y[3])
            low, middle, high = (
                a * floor.stiffness + u * floor.damping
                for a, u in zip(overlaps(y), rates, strict=True)
            )
            up = (
                (low - middle) / floor.mass - floor.gravity,
                (middle - high) / upper_mass - floor.gravity,
            )
            return [y[1], up[0], y[3], up[1], 1]

        def opens(i: int) -> Guard:
            return Guard(f"contact {i} opens", lambda y: overlaps(y)[i], lambda y: Entry(None))

        guards = tuple(opens(i) for i in range(3))
        super().__init__(
            {"squeezed": Mode(field, guards, window=floor.window)},
            (starts[0], zero, starts[1], zero, zero),
            lambda y: Entry("squeezed"),
            lambda y: {"r1.y": y[0], "v1.y": y[1], "r2.y": y[2], "v2.y": y[3]},
            scale,
            state=("r1.y", "v1.y", "r2.y", "v2.y"),
            moved=(0, 1, 2, 3),
        )
