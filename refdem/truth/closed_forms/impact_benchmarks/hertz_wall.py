"""A sphere that touches the wall x = 0 from the left under Hertz's law F = k d^(3/2), with sliding friction of full size: closed form.

The normal motion is that of power_contact. Friction is mu F against the slip s = v_y + R omega while there is any; with P(t) the normal
impulse per mass so far (the fall of v_x), v_y loses mu P and R omega 5/2 mu P, so that the slip ends at P = 2|s|/(7 mu), if P comes so
far, and does not come back: rolling needs no friction on a wall with the lever R (Maw, Barber and Fawcett 1976 for the limit).
"""

from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from typing import Self

from flint import arb

from refdem.core.truth import Ball
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import Size, per_precision
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.smooth_flow import SmoothFlow

HERTZ = Fraction(3, 2)
STATE = ("r.x", "r.y", "v.x", "v.y", "omega.z")
STILL = ("r.z", "v.z", "omega.x", "omega.y")


class HertzWallImpact(SmoothFlow):
    """Place [m], velocity [m/s] and angular velocity [rad/s] at t >= 0."""

    state = STATE
    method = "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound; friction by its impulse"
    witness = "Taylor integration in w = sqrt(overlap), friction by its own law"

    def __init__(
        self, scale: Mapping[str, Size], *, mass: Fraction, radius: Fraction, stiffness: Fraction, friction: Fraction,
        normal: Fraction, across: Fraction, spin: Fraction,
    ) -> None:  # fmt: skip
        super().__init__(scale)
        self.mass, self.radius, self.stiffness, self.friction = mass, radius, stiffness, friction
        self.begin = (-radius, Fraction(0), normal, across, spin)

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        other.kept = {}
        other.begin = tuple(x + amount * (i == axis) for i, x in enumerate(self.begin))  # type: ignore[assignment]
        return other

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """S from errors of the start alone: once the slip has ended the flow has no inverse, and the contact itself is stable."""
        return [self.sensitivity(t) for t in times]

    @per_precision
    def contact(self) -> tuple[PowerContact, arb]:
        """The contact, and when it begins."""
        return touching(self.mass, self.stiffness, HERTZ, self.begin[0] + self.radius, self.begin[2])

    def slip(self) -> Fraction:
        """v_y + R omega at the start."""
        return self.begin[3] + self.radius * self.begin[4]

    def normal(self, t: arb) -> tuple[arb, arb]:
        """Overlap (negative while apart) and its rate."""
        contact, touch = self.contact()
        since = t - touch
        if since < 0:
            return arb_of(self.begin[0] + self.radius) + arb_of(self.begin[2]) * t, arb_of(self.begin[2])
        after = since - 2 * contact.half
        return (-contact.speed * after, -contact.speed) if after >= 0 else contact.state(since)

    @per_precision
    def stop(self) -> tuple[arb, arb] | None:
        """Overlap and time at the end of the slip; None if it does not end."""
        contact, touch = self.contact()
        if not self.friction or not self.slip():
            return None
        s = (arb_of(self.begin[2]) - arb_of(Fraction(2, 7) * abs(self.slip()) / self.friction)) / contact.speed
        if s < -1:
            return None
        if not s > -1:
            raise UndecidedError("whether the slip ends before the contact does")
        return contact.depth * (1 - s * s) ** contact.a, touch + contact.half - contact.unit * contact.before_turn(s)

    def evaluate(self, t: arb) -> dict[str, arb]:
        x, y, vx, vy, spin = (arb_of(value) for value in self.begin)
        depth, rate = self.normal(t)
        side = (self.slip() > 0) - (self.slip() < 0)
        push, end = arb_of(self.friction * side), self.stop()
        if end is not None and not (t < end[1] or t > end[1]):
            raise UndecidedError("whether it slips still")
        way, impulse, rest = vx * t - (depth - (x + arb_of(self.radius))), vx - rate, arb(0)
        if end is not None and t > end[1]:
            impulse = arb_of(Fraction(2, 7) * abs(self.slip()) / self.friction)
            way, rest = vx * end[1] - (end[0] - (x + arb_of(self.radius))), impulse * (t - end[1])
        now = (depth - arb_of(self.radius), y + vy * t - push * (way + rest), rate, vy - push * impulse)
        turned = spin - push * impulse * arb_of(Fraction(5, 2) / self.radius)
        return dict(zip((*STATE, *STILL), (*now, turned, *(arb(0),) * 4), strict=True))

    def scalars(self) -> dict[str, Ball]:
        return self._certified(self.constants, "scalars")

    def constants(self) -> dict[str, arb]:
        contact, touch = self.contact()
        deepest, last = contact.depth, self.evaluate(touch + 3 * contact.half)
        return {
            "duration": 2 * contact.half,
            "max_overlap": deepest,
            "max_force": arb_of(self.stiffness) * deepest * deepest.sqrt(),
            "rebound_across": last["v.y"],
            "rebound_spin": last["omega.z"],
        }
