"""Certified break of a rack of discs or spheres by a cue ball: impact_sequence.py with the list of
impacts of impacts_in_balls.py.

All centres stay in the plane z = 0 and all spins point along z. The apex of the rack is at the
origin, n rows of 1, 2, ..., n balls follow along +x. With the pitch s = 2 R + gap of the balls of a
row, ball j of row k has its centre at

    x = 7/8 k s,   y = (j - k/2) s,   0 <= j <= k < n.

7/8 is sqrt(3)/2 rounded up, so that all places are rational: neighbours of two rows are 0.8 %
farther apart than those of one row.

With the relative position d, the relative velocity w and the sum R of the radii, two balls approach
while d.w < 0, and they touch at the first root of |d + w t| = R,

    t = (d^2 - R^2)/(-d.w + sqrt(q))   with   q = (d.w)^2 - w^2 (d^2 - R^2) > 0,

where two positive numbers are added in the denominator, so that no digits cancel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from math import inf
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.closed_forms.hard_spheres import difference, law_of
from refdem.truth.exact import number, vector
from refdem.truth.impact_scalars import impact_scalars
from refdem.truth.impact_sequence import OF_BODY, Encounter, ImpactSequence
from refdem.truth.impacts_in_balls import GrazingError, ImpactsInBalls
from refdem.truth.refiner import FIRST_BITS, Size
from refdem.truth.rigid_impact import Motion, RoundBody, impact_of
from refdem.truth.surds import sign
from refdem.truth.vectors import dot

METHOD = "every impact in balls, in an order that is proved, impulses in closed form"
WITNESS = (
    "impulses from the balance equations by elimination, times by bisection of the gaps of all"
    " pairs (refdem/truth/witnesses/breaks.py)"
)
MOST_IMPACTS = 200
"""The largest number of impacts: balls that lose much energy collide infinitely often in a finite
time.
"""
MOST_BITS = 2**12
"""The largest precision [bit] at which the order of impacts is decided before a case is run."""
IN_PLANE: tuple[int, ...] = (0, 1, 3, 4)
"""The indices of x, y, v_x, v_y in (r, v, omega), which plane impacts without friction change."""
IN_PLANE_AND_SPIN = (*IN_PLANE, 8)
"""The same with omega_z, which friction changes."""
ROW_PITCH = Fraction(7, 8)
"""The distance of rows in pitches of the balls of a row: sqrt(3)/2 rounded up."""


@dataclass(frozen=True)
class BallsMayMeet:
    """Two free balls, which meet where their centres are `reach` = R1 + R2 [m] apart, if ever."""

    reach: Fraction

    def time(self, states: Sequence[Motion]) -> arb | None:
        """The time until contact [s]; None if there is none. GrazingError where it is undecided."""
        first, second = states
        apart = difference(second.r, first.r)
        relative = difference(second.v, first.v)
        nearing = -dot(apart, relative)
        if sign(nearing) <= 0:
            return None
        # q = (d.w)^2 - w^2 (d^2 - R^2),  t = (d^2 - R^2)/(-d.w + sqrt(q))
        reach = arb_of(self.reach)
        gap = dot(apart, apart) - reach * reach
        square = dot(relative, relative)
        q = nearing * nearing - square * gap
        if q < 0:
            return None
        if not q > 0:
            # If there is a root, the first one, (-d.w - sqrt(q))/w^2, is not before this time.
            raise GrazingError((nearing - q.abs_upper().sqrt()) / square)
        wait: arb = gap / (nearing + q.sqrt())
        return wait

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit vector (3,) from centre to centre, in balls or in balls with derivatives."""
        apart = difference(places[1], places[0])
        distance = dot(apart, apart).sqrt()
        return [x / distance for x in apart]


@dataclass(frozen=True)
class Break:
    """The family of a rack and a cue ball."""

    method: str = METHOD
    witness: str = WITNESS

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
            "impacts": arb(len(moments)),
            "last_impact_time": arb_of(moments[-1].time),
            "energy_lost": lost,
            **impact_scalars(motion, len(moments)),
        }

    def refuse_unlisted(self, motion: ImpactSequence, t: arb) -> None:
        """Raises UndecidedError: the list was cut off."""
        raise endless()


def centres(p: Mapping[str, Any]) -> list[tuple[Fraction, Fraction]]:
    """The centres (x, y) [m] of the cue ball and of the rack, row by row, exactly."""
    cue_radius, radius = vector(p, "radii")
    reach = cue_radius + radius
    pitch = 2 * radius + number(p, "gap")
    # The cue ball is given in units of the sum of both radii.
    places = [(-number(p, "distance") * reach, number(p, "offset") * reach)]
    for row in range(int(number(p, "rows"))):
        for ball in range(row + 1):
            # x = 7/8 k s,  y = (j - k/2) s.
            across = ball - Fraction(row, 2)
            places.append((ROW_PITCH * row * pitch, across * pitch))
    return places


def start_of(p: Mapping[str, Any]) -> list[Fraction]:
    """r, v, omega of all balls at the start, exactly: the cue ball first."""
    nothing = Fraction(0)
    velocity = vector(p, "velocity")
    spin = number(p, "spin")
    start: list[Fraction] = []
    for x, y in centres(p):
        start += [x, y, nothing, *velocity, nothing, nothing, nothing, spin]
        # Only the cue ball moves at the start.
        velocity = (nothing, nothing)
        spin = nothing
    return start


def impact_list(p: Mapping[str, Any]) -> ImpactsInBalls:
    """The impacts of all pairs, in their order."""
    start = start_of(p)
    count = len(start) // OF_BODY
    cue_mass, mass = vector(p, "masses")
    cue_radius, radius = vector(p, "radii")
    factor = number(p, "inertia_factor")
    bodies = [RoundBody(mass=cue_mass, inertia_factor=factor, radius=cue_radius)]
    bodies += [RoundBody(mass=mass, inertia_factor=factor, radius=radius)] * (count - 1)
    law = law_of(p)
    encounters = []
    for pair in combinations(range(count), 2):
        meeting = [bodies[body] for body in pair]
        reach = meeting[0].radius + meeting[1].radius
        encounters.append(Encounter(pair, impact_of(meeting, law), BallsMayMeet(reach)))
    return ImpactsInBalls(encounters, start, MOST_IMPACTS)


SHAPING = (
    *("rows", "masses", "radii", "inertia_factor", "gap", "distance", "offset", "velocity", "spin"),
    *("restitution", "tangential_restitution", "friction"),
)
"""The parameters that the impacts depend on."""


@dataclass(frozen=True)
class Course:
    """The rounded times [s] of the impacts, in order, which a case needs before it is run.

    `waits` [s] has for each impact the time since the last one of either of its balls, infinite if
    they had none.
    """

    times: tuple[float, ...]
    waits: tuple[float, ...]


def course_of(p: Mapping[str, Any]) -> Course:
    """The course of the impacts; UndecidedError where their order is not decided or they do not
    end.
    """
    return _course(tuple(p[name] for name in SHAPING))


@lru_cache(maxsize=64)
def _course(values: tuple[Any, ...]) -> Course:
    """The course by the values of the parameters that it depends on."""
    impacts = impact_list(dict(zip(SHAPING, values, strict=True)))
    bits = FIRST_BITS
    while True:
        with precision(bits):
            try:
                moments = impacts.all()
                break
            except UndecidedError:
                if bits >= MOST_BITS:
                    raise
        bits *= 2
    if len(moments) == MOST_IMPACTS:
        raise endless()
    times = []
    waits = []
    last_impact: dict[int, float] = {}
    for moment in moments:
        time = float(arb_of(moment.time).mid())
        bodies = moment.encounters[0].bodies
        times.append(time)
        # A ball without an earlier impact has waited for an infinite time.
        waits.append(min(time - last_impact.get(body, -inf) for body in bodies))
        last_impact.update(dict.fromkeys(bodies, time))
    return Course(tuple(times), tuple(waits))


def endless() -> UndecidedError:
    """The error of balls that meet too often."""
    return UndecidedError(
        f"the balls meet more than {MOST_IMPACTS - 1} times: they lose so much that they may meet"
        " without end in finite time",
        code="time",
        final=True,
    )


def turns(p: Mapping[str, Any]) -> bool:
    """True if any ball's spin can change: with friction."""
    return number(p, "friction") > 0


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The truth of case billiard-break; `scale` of x, y, vx, vy of each ball, with friction also of
    omega, in order.
    """
    impacts = impact_list(p)
    told = IN_PLANE
    if turns(p):
        told = IN_PLANE_AND_SPIN
    coordinates = []
    for body in range(len(impacts.start) // OF_BODY):
        coordinates += [OF_BODY * body + place for place in told]
    return ImpactSequence.of(scale, impacts, coordinates, Break())
