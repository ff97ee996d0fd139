"""A block on a slope: exactly at rest if friction >= tan(angle), else s = g (sin a - mu cos a)
t^2/2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.closed_forms.newtons_first_law import Still
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Norm, SteadyGrowth, narrow
from refdem.truth.line_growth import linear
from refdem.truth.refiner import Refiner

MOST_BITS = 16384
"""The most bits of the comparison of friction and tangent: only parameters that are chosen for it
agree to thousands of digits.
"""


@dataclass(frozen=True, kw_only=True)
class Slide(ClosedForm):
    """s [m] and v [m/s] of a block that slides from rest; the tangent of the slope is exact, or the
    angle is.
    """

    method = "closed form"
    witness = "work of gravity and friction: v^2/2 = a s"
    state = ("s", "v")

    friction: Fraction
    gravity: Fraction
    slope: Fraction
    angle: Fraction | None
    s0: Fraction = Fraction(0)
    v0: Fraction = Fraction(0)

    # Friction still points uphill from a neighbouring start.
    displaced = displaced_fields("s0", "v0")

    @per_precision
    def growth(self) -> Grows:
        """S at constant acceleration: errors obey e_s' = e_v, e_v' = 0, as in uniform motion."""
        ratio = arb_of(self.scale["s"] / self.scale["v"])
        return SteadyGrowth(partial(linear, arb(0), 0, ratio), Norm([1, 1]), narrow(1 / ratio))

    def evaluate(self, t: arb) -> dict[str, arb]:
        """s = s0 + v0 t + a t^2/2 and v = v0 + a t with a = g (sin - mu cos) of the angle."""
        if self.angle is not None:
            sine, cosine = arb_of(self.angle).sin_cos()
        else:
            # cos = 1/sqrt(1 + tan^2), sin = tan cos.
            cosine = 1 / arb_of(1 + self.slope**2).sqrt()
            sine = arb_of(self.slope) * cosine
        # a = g (sin - mu cos).
        a = arb_of(self.gravity) * (sine - arb_of(self.friction) * cosine)
        v0 = arb_of(self.v0)
        return {"s": arb_of(self.s0) + v0 * t + a * t * t / 2, "v": v0 + a * t}


def slides(friction: Fraction, slope: Fraction, angle: Fraction | None) -> bool:
    """True if friction < tan(angle), where the tangent is `slope` or the angle [rad] is given.

    The comparison is exact for a slope. For an angle it is made in balls, which decide it since no
    rational number but 0 has a rational tangent.
    """
    if angle is None:
        return friction < slope
    if angle == 0:
        return friction < 0
    bits = 64
    while bits <= MOST_BITS:
        with precision(bits):
            difference = arb_of(angle).tan() - arb_of(friction)
            if difference > 0 or difference < 0:
                return bool(difference > 0)
        bits *= 2
    raise UndecidedError("friction and the tangent of the angle agree to thousands of digits")


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters friction, gravity, slope or angle."""
    angle = p["angle"]
    assert angle is None or isinstance(angle, Fraction)
    given = numbers(p, "friction", "gravity", "slope")
    if slides(given["friction"], given["slope"], angle):
        return Slide(refiner=Refiner.of(scale), **given, angle=angle)
    return Still(("s", "v"))
