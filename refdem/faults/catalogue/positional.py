"""Forces of place and orientation: Hertz's power and its factors, the flanks of a field, a law that
depends on the velocity.
"""

from functools import partial
from typing import Any

from refdem.faults.change import Inside, of_arguments, of_elements, of_parts, scaled, within
from refdem.faults.fault import Fault
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.wedge import Wedge

positional = partial(Fault, kind="positional")


def _of_field(force: Any) -> Inside:
    """The force of a piecewise field replaced by another function."""
    return within("positional", of_parts(field_force=force))


def _one_slope(field: Any, s: Any) -> Any:
    """The field k1 (-|s| - x1), at least 0: the slope of the first flank on both sides."""
    return max(field.k1 * (min(s, -s) - field.x1), 0.0)


FAULTS = (
    positional(
        name="hertz-linear",
        sentence="The power of the overlap is 1 instead of 3/2.",
        on=("hertz",),
        sees=("error", "overlap"),
        # The power 1 for 3/2, about as stiff at some overlap.
        inside=of_parts(normal_force=lambda law, depth, rate: law.stiffness * 0.2 * depth),
    ),
    positional(
        name="hertz-factor",
        sentence="The factor 4/3 of Hertz's stiffness is applied twice.",
        on=("hertz",),
        sees=("error", "v"),
        before=of_elements(Contact, stiffness=scaled(4 / 3)),
    ),
    positional(
        name="field-one-slope",
        sentence="The force decreases with the slope with which it increases.",
        on=("tent",),
        sees=("energy-return", "gain"),
        levels=5,
        inside=_of_field(_one_slope),
    ),
    positional(
        name="field-two-percent",
        sentence="The work of the field is 2 % too small.",
        on=("tent",),
        sees=("energy-return", "gain"),
        levels=6,
        before=of_elements(PiecewiseField, k1=scaled(0.98), k2=scaled(0.98)),
    ),
    positional(
        name="wedge-by-sign",
        sentence=(
            "Approach and separation are distinguished by the sign of the velocity instead of the"
            " orientation."
        ),
        on=("wedge",),
        sees=("energy-return", "return"),
        inside=within(
            "positional",
            of_arguments(wedge_force=lambda wall, depth, edge, rate: (wall, depth, rate > 0, rate)),
        ),
    ),
    positional(
        name="wedge-flat-softer",
        sentence="The flat side is 5 % too soft.",
        on=("wedge",),
        sees=("energy-return", "gain"),
        levels=5,
        before=of_elements(Wedge, stiffness=scaled(0.95)),
    ),
)
