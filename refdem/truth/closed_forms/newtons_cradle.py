"""Certified motion of spheres on a line with impacts of pairs: impact_sequence.py in one dimension.

Between impacts every sphere moves uniformly, so that two neighbours with the gap d and the closing
speed c = v1 - v2 > 0 touch after d/c. With rational parameters all times and velocities are
rational, so that the list of impacts is exact.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.exact import number, vector
from refdem.truth.impact_scalars import impact_scalars
from refdem.truth.impact_sequence import (
    OF_BODY,
    Encounter,
    ImpactList,
    ImpactSequence,
    motions,
)
from refdem.truth.refiner import Size
from refdem.truth.rigid_impact import ImpactLaw, Motion, RoundBody, impact_of

METHOD = "times and velocities of all impacts in rational arithmetic, in their order"
WITNESS = (
    "speeds from the balance equations of each pair by elimination, the next impact of all pairs"
    " found anew in balls (refdem/truth/witnesses/lines_of_impacts.py)"
)
MOST_IMPACTS = 120
"""The largest number of times of impact that are computed: spheres that lose much energy may
collide infinitely often in a finite time (McNamara and Young 1992).
"""
MOST_BITS = 2**14
"""Bits of an exact time of impact: each impact adds those of the masses."""
SOLID = Fraction(2, 5)
"""J/(m R^2) of the balls, which never turn."""


@dataclass(frozen=True)
class MeetInLine:
    """Two neighbours on the x axis meet where their centres are `reach` = R1 + R2 [m] apart."""

    reach: Fraction

    def time(self, states: Sequence[Motion]) -> Fraction | None:
        """The time [s] until two neighbours meet; None if they do not approach each other."""
        # t = (x2 - x1 - reach)/(v1 - v2).
        first, second = states
        closing: Fraction = first.v[0] - second.v[0]
        if closing <= 0:
            return None
        gap: Fraction = second.r[0] - first.r[0] - self.reach
        return gap / closing

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit vector (3,) from centre to centre: errors along the line do not change it."""
        # 0 and 1 in numbers of the kind of the places.
        zero = places[0][0] * 0
        return [zero + 1, zero, zero]


class Cradle:
    """The family of balls in a line."""

    method = METHOD
    witness = WITNESS

    def constants(self, motion: ImpactSequence) -> dict[str, arb]:
        """The number of impacts, the time of the last one [s], the energy lost in all [J], and the
        list of them.
        """
        moments = motion.impacts.all()
        if len(moments) == motion.impacts.most:
            raise endless()
        lost = arb(0)
        for k in range(len(moments)):
            lost += motion.energy_lost(k)
        return {
            # Impacts of different pairs at one time are one moment and count one by one.
            "impacts": arb(sum(len(moment.encounters) for moment in moments)),
            "last_impact_time": arb_of(moments[-1].time),
            "energy_lost": lost,
            **impact_scalars(motion, len(moments)),
        }

    def refuse_unlisted(self, motion: ImpactSequence, t: arb) -> None:
        """Raises UndecidedError: the list was cut off."""
        raise endless()


def start_of(p: Mapping[str, Any]) -> list[Fraction]:
    """r, v, omega of all balls at the start, exactly.

    They lie on the x axis in order, gap g_k between the surfaces of balls k and k + 1; the first
    centre is at the origin.
    """
    count = int(number(p, "balls"))
    radii = vector(p, "radii")
    gaps = vector(p, "gaps")
    velocities = vector(p, "velocities")
    nothing = [Fraction(0)] * 2
    spin = [Fraction(0)] * 3
    place = Fraction(0)
    start: list[Fraction] = []
    for k in range(count):
        if k > 0:
            # x_k = x_(k-1) + R_(k-1) + g_(k-1) + R_k.
            place += radii[k - 1] + gaps[k - 1] + radii[k]
        start += [place, *nothing, velocities[k], *nothing, *spin]
    return start


def impact_list(p: Mapping[str, Any]) -> ImpactList:
    """The impacts of neighbours, in their order."""
    count = int(number(p, "balls"))
    columns = zip(vector(p, "masses"), vector(p, "radii"), strict=True)
    bodies = [RoundBody(mass=m, inertia_factor=SOLID, radius=r) for m, r in columns]
    law = ImpactLaw(
        restitution=number(p, "restitution"),
        tangential_restitution=Fraction(0),
        friction=Fraction(0),
    )
    encounters = []
    for k in range(count - 1):
        pair = bodies[k : k + 2]
        reach = pair[0].radius + pair[1].radius
        encounters.append(Encounter((k, k + 1), impact_of(pair, law), MeetInLine(reach)))
    return ImpactList(encounters, start_of(p), gravity=None, most=MOST_IMPACTS)


SHAPING = ("balls", "masses", "radii", "gaps", "velocities", "restitution")
"""The parameters that the impacts depend on."""


@dataclass(frozen=True)
class Course:
    """The impacts as a case needs them before it is run: their times [s], in order, the largest
    speed of a ball [m/s], and the shortest time [s] between two impacts of one ball (None: no ball
    has two).
    """

    times: tuple[Fraction, ...]
    fastest: Fraction
    shortest_wait: Fraction | None


def course_of(p: Mapping[str, Any]) -> Course:
    """The course of the impacts; UndecidedError where their order is not decided or they do not
    end.
    """
    return _course(tuple(p[name] for name in SHAPING))


@lru_cache(maxsize=64)
def _course(values: tuple[Any, ...]) -> Course:
    """The course by the values of the parameters that it depends on."""
    impacts = impact_list(dict(zip(SHAPING, values, strict=True)))
    while (moment := impacts.number(len(impacts.moments))) is not None:
        assert isinstance(moment.time, Fraction)
        if moment.time.denominator.bit_length() > MOST_BITS:
            raise UndecidedError(
                f"after {len(impacts.moments)} impacts exact times have more than {MOST_BITS} bits",
                code="time",
                final=True,
            )
    moments = impacts.moments
    if len(moments) == MOST_IMPACTS:
        raise endless()
    times = []
    waits = []
    speeds = [abs(state.v[0]) for state in motions(impacts.start)]
    last_impact: dict[int, Fraction] = {}
    for moment in moments:
        assert isinstance(moment.time, Fraction)
        times.append(moment.time)
        speeds += [abs(state.v[0]) for state in moment.parted]
        # The time between two impacts of one ball.
        for body in [body for encounter in moment.encounters for body in encounter.bodies]:
            if body in last_impact:
                waits.append(moment.time - last_impact[body])
            last_impact[body] = moment.time
    return Course(tuple(times), max(speeds), min(waits, default=None))


def endless() -> UndecidedError:
    """The error of balls that meet too often."""
    return UndecidedError(
        f"the balls meet at more than {MOST_IMPACTS} times: they lose so much that they may meet"
        " without end in finite time",
        code="time",
        final=True,
    )


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The truth of case newtons-cradle; `scale` of the place and the velocity of each, in order."""
    impacts = impact_list(p)
    count = len(impacts.start) // OF_BODY
    coordinates = []
    for body in range(count):
        # x and v_x of a body in (r, v, omega).
        coordinates += [OF_BODY * body, OF_BODY * body + 3]
    return ImpactSequence.of(scale, impacts, coordinates, Cradle())
