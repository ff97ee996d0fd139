"""Certified motion of a rigid sphere that falls and bounces on a plane: impact_sequence.py under
uniform gravity.

With the height h of the lowest point above the plane, the upward velocity u and gravity g, the
first impact is at t_1 = (u + v_1)/g with v_1 = sqrt(u^2 + 2 g h). Every later flight lasts 2 v/g
with the speed v after the impact before it:

    v_n = e^(n-1) v_1 before impact n,   t_n = t_1 + (2 v_1/g) (e + e^2 + ... + e^(n-1)).

All are numbers a + b v_1 with rational a and b, so that all decisions are exact. With e < 1 the
impacts accumulate at

    T = t_1 + (2 v_1/g) e/(1 - e).

The sphere moves in the plane x-y and rotates about z, so that the slip is along x, and the impulse
of friction is exact too. S grows without bound towards T: 1/v_n enters the derivative of the time
of impact n.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_forms.hard_spheres import law_of
from refdem.truth.exact import number, vector
from refdem.truth.impact_scalars import impact_scalars
from refdem.truth.impact_sequence import Encounter, ImpactList, Impacts, ImpactSequence
from refdem.truth.refiner import Size
from refdem.truth.rigid_impact import Motion, RoundBody, impact_of
from refdem.truth.surds import Number, sign, surd

METHOD = (
    "times of all bounces in exact arithmetic of one square root, impulses in closed form, friction"
    " decided there"
)
WITNESS = (
    "each flight to the next zero of the height by bisection, impulses from the balance equations"
    " by elimination (refdem/truth/witnesses/bounces.py)"
)
MOST_BOUNCES = 64
"""The largest number of bounces that are computed."""
PLANE_MOTION = (0, 1, 3, 4, 8)
"""The indices in (r, v, omega) of x, y, v_x, v_y and omega_z, which the motion changes."""


@dataclass(frozen=True)
class MeetsFloor:
    """A sphere of `radius` [m] falls under `gravity` [m/s^2] along -y on the plane y = 0."""

    radius: Fraction
    gravity: Fraction

    def time(self, states: Sequence[Motion]) -> Number:
        """The time until the next impact on the plane [s]."""
        (sphere,) = states
        upwards: Number = sphere.v[1]
        height = sphere.r[1] - self.radius
        if sign(height) == 0:
            # A flight from the plane: u t - g t^2/2 = 0 at t = 2 u/g.
            return upwards * (2 / self.gravity)
        assert isinstance(upwards, Fraction)
        assert isinstance(height, Fraction)
        # h + u t - g t^2/2 = 0 at t = u/g + (1/g) sqrt(u^2 + 2 g h).
        squared_speed = upwards**2 + 2 * self.gravity * height
        return surd(upwards / self.gravity, 1 / self.gravity, squared_speed)

    def normal(self, places: Sequence[Sequence[Any]]) -> list[Any]:
        """The unit vector (3,) into the plane, in numbers of the kind of the places."""
        zero = places[0][1] * 0
        return [zero, zero - 1, zero]


@dataclass(frozen=True)
class Bounces:
    """The family of a sphere that bounces; `count` is the number of bounces up to the end of the
    run.
    """

    floor: MeetsFloor
    restitution: Fraction
    count: int
    method: str = METHOD
    witness: str = WITNESS

    def constants(self, motion: ImpactSequence) -> dict[str, arb]:
        """The number of bounces up to the end of the run, the time of the first one and, with e <
        1, the time at which they accumulate [s], the energy lost up to the end of the run [J], and
        the list of the bounces up to there and of the next one, which a run may see too early.
        """
        lost = arb(0)
        for k in range(self.count):
            lost += motion.energy_lost(k)
        found = {"bounces": arb(self.count), "energy_lost": lost}
        found["first_bounce"] = arb_of(motion.moment_number(0).time)
        if self.restitution < 1:
            found["accumulation_time"] = arb_of(
                accumulation_time(motion.impacts, self.floor, self.restitution)
            )
        return found | impact_scalars(motion, motion.impacts.most)

    def refuse_unlisted(self, motion: ImpactSequence, t: arb) -> None:
        """Raises UndecidedError where the bounce after the last one of the list is not after t."""
        moment = motion.moment_number(motion.impacts.most - 1)
        # The time of the last impact plus that of the flight after it.
        following = moment.time + self.floor.time(moment.parted)
        if not t < arb_of(following):
            raise UndecidedError(
                f"only the first {motion.impacts.most} bounces are followed, which end at"
                f" {arb_of(following).str(12)} s",
                code="time",
                final=True,
            )


def accumulation_time(impacts: Impacts, floor: MeetsFloor, restitution: Fraction) -> Number:
    """T = t_1 + 2 e v_1/((1 - e) g) [s], exactly, for e < 1."""
    first = impacts.number(0)
    assert first is not None
    # The speed v_1 before the first impact, and its time t_1.
    falling: Number = -first.states[0].v[1]
    begin: Number = first.time
    # T = t_1 + v_1 2 e/((1 - e) g)
    return begin + falling * (2 * restitution / ((1 - restitution) * floor.gravity))


def floor_of(p: Mapping[str, Any]) -> MeetsFloor:
    """The plane and the gravity of the parameters."""
    return MeetsFloor(number(p, "radius"), number(p, "gravity"))


def impact_list(p: Mapping[str, Any], most: int) -> ImpactList:
    """The bounces of the parameters, up to `most`."""
    body = RoundBody(
        mass=number(p, "mass"),
        inertia_factor=number(p, "inertia_factor"),
        radius=number(p, "radius"),
    )
    encounter = Encounter((0,), impact_of([body], law_of(p)), floor_of(p))
    nothing = Fraction(0)
    start = [
        # (r, v, omega): the height is that of the lowest point, a radius below the centre.
        *(nothing, number(p, "height") + body.radius, nothing),
        *(*vector(p, "velocity"), nothing),
        *(nothing, nothing, number(p, "spin")),
    ]
    gravity = [nothing, -number(p, "gravity"), nothing]
    return ImpactList([encounter], start, gravity, most)


def times_of_bounces(p: Mapping[str, Any], most: int) -> list[Number]:
    """The times [s] of the first bounces, up to `most`, exactly."""
    return [moment.time for moment in impact_list(p, most).all()]


def is_before_accumulation(p: Mapping[str, Any], t: Fraction) -> bool:
    """True if bounces accumulate after t [s], or never."""
    restitution = number(p, "restitution")
    if restitution == 1:
        return True
    end = accumulation_time(impact_list(p, 1), floor_of(p), restitution)
    return sign(end - t) > 0


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The truth of case bouncing-ball; `scale` of x, y, vx, vy, omega, in order."""
    count = bounces_of_run(p)
    # S and samples need at most one bounce after the end of the run.
    impacts = impact_list(p, count + 1)
    family = Bounces(floor_of(p), number(p, "restitution"), count)
    return ImpactSequence.of(scale, impacts, PLANE_MOTION, family)


def bounces_of_run(p: Mapping[str, Any]) -> int:
    """The number of bounces up to `duration` [s], at most MOST_BOUNCES.

    It is the parameter `bounces` if there is no duration.
    """
    duration = p["duration"]
    if duration is None:
        return int(number(p, "bounces"))
    impacts = impact_list(p, MOST_BOUNCES)
    count = 0
    while (moment := impacts.number(count)) is not None:
        if sign(moment.time - duration) > 0:
            break
        count += 1
    return count
