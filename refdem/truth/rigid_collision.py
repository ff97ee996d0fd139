"""Certified motion of rigid round bodies through one impact.

Theorem: the bodies fly along straight lines, get the impulses of rigid_impact.py where they touch,
and fly on along straight lines. impact_sequence.py follows it, and proves S.

Hypotheses, and where each is checked:

* the bodies meet, and do not only graze: the meeting of the family (hard_spheres.py, hard_wall.py),
  which ends as `grazing`;
* whether friction is cut is decided exactly (`Impact.excess`): the time of the impact, the places
  and the normal there lie in a field Q(sqrt(q)) (surds.py). With friction that is not cut the
  velocities afterwards lie in it too.

Formula: the time of the impact is a root of a quadratic (Meeting), the impulses are those of
rigid_impact.py.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.impact_sequence import (
    OF_BODY,
    Encounter,
    ImpactList,
    ImpactSequence,
    Meeting,
    work_lost,
)
from refdem.truth.refiner import Size
from refdem.truth.rigid_impact import ImpactLaw, RoundBody, impact_of
from refdem.truth.vectors import dot

METHOD = (
    "time of impact by the quadratic, impulses in closed form; friction is decided in exact"
    " arithmetic of one square root"
)
WITNESS = (
    "impulses from the balance equations of both bodies by elimination, time of impact by bisection"
    " (refdem/truth/witnesses/rigid_impacts.py)"
)


class RigidCollision:
    """The family of one impact of one or two bodies."""

    method = METHOD
    witness = WITNESS

    def constants(self, motion: ImpactSequence) -> dict[str, arb]:
        """impact_time [s], the impulses along and across the normal [N s], and the energy lost
        [J].
        """
        moment = motion.moment_number(0)
        encounter = moment.encounters[0]
        impact = encounter.impact.in_numbers(arb_of)
        states = motion.before()
        normal = encounter.meeting.normal([state.r for state in states])
        closing, slip = impact.approach(normal, states)
        is_cut = moment.sides[0] > 0
        k = impact.tangential_factor(closing, slip, is_cut=is_cut)
        # p = (1 + e) m_n c and k |s|, the parts of P = -p n - k s (rigid_impact.py).
        return {
            "impact_time": arb_of(moment.time),
            "normal_impulse": impact.normal_impulse(closing),
            "tangential_impulse": k * root(dot(slip, slip)),
            "energy_lost": work_lost(encounter, states, is_cut=is_cut),
        }

    def refuse_unlisted(self, motion: ImpactSequence, t: arb) -> None:
        """Returns at once: bodies that meet once fly on for ever."""


def rigid_collision(
    scale: Mapping[str, Size],
    bodies: Sequence[RoundBody],
    law: ImpactLaw,
    meeting: Meeting,
    start: Sequence[Fraction],
) -> ImpactSequence:
    """The motion through one impact; the state and the quantities are r, v, omega of each body."""
    everybody = tuple(range(len(bodies)))
    encounter = Encounter(everybody, impact_of(bodies, law), meeting)
    impacts = ImpactList([encounter], start, gravity=None, most=1)
    return ImpactSequence.of(scale, impacts, range(OF_BODY * len(bodies)), RigidCollision())


def root(square: arb) -> arb:
    """The root of a square; of one that may be 0 all roots that it may have."""
    if square > 0:
        return square.sqrt()
    return arb(0).union(square.abs_upper().sqrt())
