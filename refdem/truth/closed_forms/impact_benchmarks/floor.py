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
from refdem.truth.balls import arb_of
from refdem.truth.contact_phases import dyadic_root
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, State
from refdem.truth.events.truth import HybridFlow
from refdem.truth.exact import refuse_rounded_arguments
from refdem.truth.reals import Number, near, pi, root
from refdem.truth.refiner import Size


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


WITNESS = "damped sines and parabolas in closed form with their switches found anew"


def quantities_of(spheres: Sequence[str]) -> list[str]:
    """The nine quantities of each sphere; those that its motion does not name are exactly 0."""
    return [
        f"{kind}{sphere}.{axis}"
        for sphere in spheres
        for kind in ("r", "v", "omega")
        for axis in "xyz"
    ]


def bounce(
    scale: Mapping[str, Size],
    floor: Floor,
    *,
    height: Fraction,
    restitution: Fraction,
    bounces: int,
) -> HybridFlow:
    """A sphere that bounces from rest at a height of its centre.

    y' = v; v' = -g in flight, k d/m - c v/m - g in contact, d = R - y; state (y - R, v, clock).
    """
    numbers = {"height": height, "restitution": restitution, "bounces": bounces}
    refuse_rounded_arguments(bounce, (scale, floor), numbers)
    radius = floor.radius
    until = time_of_bounces(floor, height, restitution, bounces)
    moving = ("r.y", "v.y")
    return HybridFlow(
        flight_and_contact(floor),
        (height - radius, Fraction(0), Fraction(0)),
        lambda y: Entry("fly"),
        lambda y: {"r.y": y[0] + radius, "v.y": y[1]},
        scale,
        state=moving,
        moved=(0, 1),
        witness=WITNESS,
        still=quantities_of(("",)),
        extremes=partial(apexes, floor, until),
    )


def flight_and_contact(floor: Floor) -> dict[str, Mode]:
    """The modes of a sphere that bounces."""
    k = floor.stiffness / floor.mass
    c = floor.damping / floor.mass
    g = floor.gravity
    land = Guard("land", lambda y: y[0], lambda y: Entry("press", on_floor, {"part": 1}))
    part = Guard("part", lambda y: -y[0], lambda y: Entry("fly", on_floor, {"land": 1}))
    return {
        "fly": Mode(lambda y: [y[1], -g, 1], (land,), partial(falls, g)),
        "press": Mode(lambda y: [y[1], -y[0] * k - y[1] * c - g, 1], (part,), window=floor.window),
    }


def apexes(floor: Floor, until: Number, flow: HybridFlow) -> dict[str, Ball]:
    """apex_n [m]: height of the centre at the top of the flight after bounce n, for the bounces
    before `until` [s].
    """

    def found(motion: HybridMotion) -> dict[str, arb]:
        motion.at(arb_of(until))
        ups = [
            event for event in motion.events if event.name == "part" and event.time < arb_of(until)
        ]
        twice = arb_of(2 * floor.gravity)
        # It rises by v^2/(2 g).
        return {
            f"apex_{n + 1}": arb_of(floor.radius) + up.state[1] ** 2 / twice
            for n, up in enumerate(ups)
        }

    return flow.proof.climbed(found, "apexes")


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


def stack(
    scale: Mapping[str, Size],
    floor: Floor,
    *,
    upper_mass: Number,
    ceiling: Fraction,
    starts: Sequence[Fraction],
) -> HybridFlow:
    """Two spheres of one radius between the floor and a ceiling: three springs that press; state
    (y1, v1, y2, v2, clock).
    """
    numbers = {"upper_mass": upper_mass, "ceiling": ceiling, "starts": starts}
    refuse_rounded_arguments(stack, (scale, floor), numbers)
    zero = Fraction(0)
    radius = floor.radius

    def overlaps(y: Sequence[Any]) -> list[Any]:
        return [radius - y[0], 2 * radius - (y[2] - y[0]), y[2] + radius - ceiling]

    def field(y: Sequence[Any]) -> list[Any]:
        rates = (-y[1], y[1] - y[3], y[3])
        low, middle, high = (
            a * floor.stiffness + u * floor.damping for a, u in zip(overlaps(y), rates, strict=True)
        )
        up = (
            (low - middle) / floor.mass - floor.gravity,
            (middle - high) / upper_mass - floor.gravity,
        )
        return [y[1], up[0], y[3], up[1], 1]

    def opens(i: int) -> Guard:
        return Guard(f"contact {i} opens", lambda y: overlaps(y)[i], lambda y: Entry(None))

    guards = tuple(opens(i) for i in range(3))
    moving = ("r1.y", "v1.y", "r2.y", "v2.y")
    return HybridFlow(
        {"squeezed": Mode(field, guards, window=floor.window)},
        (starts[0], zero, starts[1], zero, zero),
        lambda y: Entry("squeezed"),
        lambda y: dict(zip(moving, y, strict=False)),
        scale,
        state=moving,
        moved=(0, 1, 2, 3),
        witness=WITNESS,
        still=quantities_of(("1", "2")),
    )
