"""The list of impacts of a certified motion as scalars, which checks read: of impact number k, from
1 on, `impact_k` [s] is when it comes, `impact_k_closing` [m/s] the closing speed right before it,
`impact_k_body` and `impact_k_other` are the numbers of the bodies that meet. One that meets a wall
has no other.

Impacts at one time are listed in the order of their bodies.
"""

from collections.abc import Iterator

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.impact_sequence import Encounter, ImpactSequence


def impact_scalars(motion: ImpactSequence, moments: int) -> dict[str, arb]:
    """The impacts of the first `moments` moments at the current precision."""
    found: dict[str, arb] = {}
    for number, (moment, encounter) in enumerate(_listed(motion, moments), start=1):
        name = f"impact_{number}"
        meeting = encounter.of(motion.before(moment))
        normal = encounter.meeting.normal([state.r for state in meeting])
        closing, _ = encounter.impact.in_numbers(arb_of).approach(normal, meeting)
        found[name] = arb_of(motion.moment_number(moment).time)
        found[f"{name}_closing"] = closing
        for role, body in zip(("body", "other"), encounter.bodies, strict=False):
            found[f"{name}_{role}"] = arb(body)
    return found


def _listed(motion: ImpactSequence, moments: int) -> Iterator[tuple[int, Encounter]]:
    """Every impact with the number of its moment, in order."""
    for moment in range(moments):
        for encounter in motion.moment_number(moment).encounters:
            yield moment, encounter
