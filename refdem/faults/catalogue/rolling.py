"""A body that slides until it rolls: moments of inertia, lever arms, the sign and the end of
friction, and what keeps it rolling.
"""

from functools import partial
from typing import Any

from refdem.faults import rolling
from refdem.faults.change import (
    Inside,
    of_arguments,
    of_bodies,
    of_elements,
    of_parts,
    of_results,
    scaled,
    within,
)
from refdem.faults.fault import Fault
from refdem.mechanics import vectors as vec
from refdem.scene.elements.contact import Contact

roll = partial(Fault, kind="rolling")


def _of_rolling(**parts: Any) -> Inside:
    """Parts of a body that slides and rolls replaced by other functions."""
    return within("rolling", of_parts(**parts))


def _resisted(along: Any, inverse_mass: Any, turn: Any) -> Any:
    """The friction that keeps the slip at 0, larger by a thousandth."""
    return vec.times(1.001, rolling.holding(along, inverse_mass, turn))


FAULTS = (
    roll(
        name="rolling-wrong-inertia",
        sentence="Moments of inertia are 1 % too large.",
        on=("skid", "ramp"),
        sees=("contact-line", "moment"),
        before=of_bodies(inertia=scaled(1.01)),
    ),
    roll(
        name="rolling-inertia-of-the-diameter",
        sentence="Moments of inertia are computed with the diameter instead of the radius.",
        on=("skid", "ramp"),
        sees=("error", "omega"),
        before=of_bodies(inertia=scaled(4.0)),
    ),
    roll(
        name="rolling-lever-of-the-diameter",
        sentence="The lever arm of friction is the diameter.",
        on=("skid", "ramp"),
        sees=("contact-line", "moment"),
        inside=of_arguments(torque_on=lambda arm, normal, force: (2 * arm, normal, force)),
    ),
    roll(
        name="rolling-lever-one-in-a-thousand",
        sentence=(
            "The lever arm of friction is shorter than the radius by one part in a thousand."
        ),
        on=("skid", "ramp"),
        sees=("error", "omega"),
        inside=of_arguments(torque_on=lambda arm, normal, force: (0.999 * arm, normal, force)),
    ),
    roll(
        name="rolling-without-spin-up",
        sentence="Friction decelerates the centre, but exerts no torque.",
        on=("skid", "ramp", "chute"),
        sees=("contact-line", "moment"),
        inside=of_parts(torque_on=lambda arm, normal, force: vec.ZERO),
    ),
    roll(
        name="rolling-spins-backwards",
        sentence="The torque of friction has the wrong sign.",
        on=("skid", "chute"),
        sees=("contact-line", "moment"),
        inside=of_results(torque_on=scaled(-1.0)),
    ),
    roll(
        name="rolling-friction-against-the-centre",
        sentence=(
            "Friction opposes the velocity of the centre instead of that of the point of contact."
        ),
        on=("skid",),
        levels=4,
        sees=("error", "vx"),
        inside=of_arguments(slip=lambda velocity, spin, normal: (velocity, vec.ZERO, normal)),
    ),
    roll(
        name="rolling-friction-without-end",
        sentence="Friction keeps its full size after the slip has ended.",
        on=("skid", "ramp"),
        sees=("error", "vx"),
        inside=_of_rolling(slips_on=lambda slip, direction: 1.0),
    ),
    roll(
        name="rolling-friction-of-the-weight",
        sentence="Friction is mu times the weight instead of mu times the normal force.",
        on=("chute",),
        sees=("error", "vx"),
        inside=_of_rolling(pressing=lambda force, normal: vec.size(force)),
    ),
    roll(
        name="rolling-slides-down",
        sentence="A rolling body accelerates down the slope like a block without friction.",
        on=("ramp",),
        sees=("error", "vx"),
        inside=_of_rolling(holding=lambda along, inverse_mass, turn: vec.ZERO),
    ),
    roll(
        name="rolling-held-as-a-block",
        sentence="A body does not roll where friction would not hold a block.",
        on=("ramp",),
        sees=("error", "omega"),
        inside=_of_rolling(grips=lambda law, force, needed: False),
    ),
    roll(
        name="rolling-friction-one-in-ten-thousand",
        sentence="The coefficient of friction is too large by one part in 1e4.",
        on=("skid", "chute"),
        sees=("error", "omega"),
        before=of_elements(Contact, friction=scaled(1 + 1e-4)),
    ),
    roll(
        name="rolling-below-a-threshold",
        sentence="A slip velocity below 1/16 m/s counts as zero.",
        on=("skid",),
        levels=6,
        sees=("event-times", "stick"),
        inside=_of_rolling(slips_on=lambda slip, direction: vec.dot(slip, direction) - 1 / 16),
    ),
    roll(
        name="rolling-held-too-much",
        sentence=(
            "Friction on a rolling body exceeds what rolling requires by one part in a thousand."
        ),
        on=("ramp",),
        sees=("error", "vx"),
        inside=_of_rolling(holding=_resisted),
    ),
)
