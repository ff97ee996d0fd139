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
from refdem.truth.refiner import Refiner, Size


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
        """A dyadic number near sqrt(m/(3 k)) [s]: switches are searched in windows as long."""
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
    # Until when apexes are scalars.
    until = time_of_bounces(floor, height, restitution, bounces)
    moving = ("r.y", "v.y")
    return HybridFlow(
        flight_and_contact(floor),
        (height - radius, Fraction(0), Fraction(0)),
        lambda y: Entry("fly"),
        lambda y: {"r.y": y[0] + radius, "v.y": y[1]},
        Refiner.of(scale),
        state=moving,
        moved=(0, 1),
        witness=WITNESS,
        still=quantities_of(("",)),
        extremes=partial(apexes, floor, until),
    )


def flight_and_contact(floor: Floor) -> dict[str, Mode]:
    """The modes of a sphere that bounces: flight and contact.

    Each ends where y - R comes to 0, which is a simple zero of the guard of the other.
    """
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
    """apex_n [m], the height of the centre at the top of the flight after bounce n: R + v^2/(2 g).

    v is its speed where it parts from the floor; of the bounces before `until` [s].
    """

    def heights(motion: HybridMotion) -> dict[str, arb]:
        # The motion is followed as far as requested.
        motion.at(arb_of(until))
        departures = [
            event for event in motion.events if event.name == "part" and event.time < arb_of(until)
        ]
        double_gravity = arb_of(2 * floor.gravity)
        apexes = {}
        for n, departure in enumerate(departures):
            speed = departure.state[1]
            apexes[f"apex_{n + 1}"] = arb_of(floor.radius) + speed**2 / double_gravity
        return apexes

    return flow.proof.climbed(heights, "apexes")


def time_of_bounces(floor: Floor, height: Fraction, restitution: Fraction, bounces: int) -> Number:
    """About the time [s] of the top of the flight after the last of `bounces` bounces.

    It is that of a hard sphere's flights, and pi sqrt(m/k), half a swing, for each contact. The
    flight after bounce n, with the speed e^n sqrt(2 g (h - R)), rises for e^n sqrt(2 (h - R)/g) and
    falls as long.
    """
    fall_time = root(2 * (height - floor.radius) / floor.gravity)
    whole_flights = sum((restitution**n for n in range(1, bounces)), Fraction(0))
    fall_times = 1 + 2 * whole_flights + restitution**bounces
    contact_time = pi() * root(floor.mass / floor.stiffness)
    time: Number = fall_time * fall_times + bounces * contact_time
    return time


def on_floor(y: Any) -> list[Any]:
    """The same state with no overlap, exactly."""
    return [0, y[1], y[2]]


def falls(g: Fraction, y: State) -> tuple[str, arb]:
    """The event that ends a flight, and the time [s] until it, (v + sqrt(v^2 + 2 g y))/g."""
    height, rate = y[:2]
    time = (rate + (rate * rate + 2 * arb_of(g) * height).sqrt()) / arb_of(g)
    return "land", time


def stack(
    scale: Mapping[str, Size],
    floor: Floor,
    *,
    upper_mass: Number,
    ceiling: Fraction,
    starts: Sequence[Fraction],
) -> HybridFlow:
    """Two spheres of one radius squeezed between the floor and a ceiling.

    Three contacts press with k d + c d'; the state is (y1, v1, y2, v2, clock), `starts` the exact
    heights of the centres, at rest. The motion is followed until a contact opens.
    """
    numbers = {"upper_mass": upper_mass, "ceiling": ceiling, "starts": starts}
    refuse_rounded_arguments(stack, (scale, floor), numbers)
    zero = Fraction(0)
    radius = floor.radius

    def overlaps(y: Sequence[Any]) -> list[Any]:
        """The overlaps with the floor, between the spheres, and with the ceiling."""
        y1, _, y2 = y[:3]
        return [radius - y1, 2 * radius - (y2 - y1), y2 + radius - ceiling]

    def field(y: Sequence[Any]) -> list[Any]:
        _, v1, _, v2 = y[:4]
        overlap_rates = (-v1, v1 - v2, v2)
        low, middle, high = (
            overlap * floor.stiffness + rate * floor.damping
            for overlap, rate in zip(overlaps(y), overlap_rates, strict=True)
        )
        acceleration1 = (low - middle) / floor.mass - floor.gravity
        acceleration2 = (middle - high) / upper_mass - floor.gravity
        return [v1, acceleration1, v2, acceleration2, 1]

    def opens(i: int) -> Guard:
        return Guard(f"contact {i} opens", lambda y: overlaps(y)[i], lambda y: Entry(None))

    guards = tuple(opens(i) for i in range(3))
    moving = ("r1.y", "v1.y", "r2.y", "v2.y")
    return HybridFlow(
        {"squeezed": Mode(field, guards, window=floor.window)},
        (starts[0], zero, starts[1], zero, zero),
        lambda y: Entry("squeezed"),
        lambda y: dict(zip(moving, y, strict=False)),
        Refiner.of(scale),
        state=moving,
        moved=(0, 1, 2, 3),
        witness=WITNESS,
        still=quantities_of(("1", "2")),
    )
