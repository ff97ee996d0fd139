"""A wedge that meets a wall with m d'' = -k2 d^2, turns at greatest overlap, and leaves with m d''
= -k1 d: overlap d and its rate.

In: d_m = (3 m v^2/(2 k2))^(1/3), time by the incomplete beta function. Out: d = d_m cos(w t), w^2 =
k1/m, until d = 0.
"""

from collections.abc import Iterator, Mapping
from copy import copy
from fractions import Fraction
from functools import partial
from typing import Self

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.line_growth import homogeneous, linear, steepness
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.refiner import Refiner, Size
from refdem.truth.smooth_flow import SmoothFlow


class WedgeCollision(ClosedForm, SmoothFlow):
    """overlap [m] (negative while apart) and v, its rate [m/s], from touch at t = 0."""

    state = ("overlap", "v")
    method = (
        "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound from"
        " the mean value theorem; cosine"
    )
    witness = "Taylor integration of both laws, energy, numerical integration"

    def __init__(self, scale: Mapping[str, Size], exact: Mapping[str, Fraction]) -> None:
        self.refiner = Refiner.of(scale)
        self.exact, self.begin = dict(exact), (Fraction(0), exact["closing_speed"])

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        other.kept = {}
        other.begin = (self.begin[0] + amount * (axis == 0), self.begin[1] + amount * (axis == 1))
        return other

    @per_precision
    def approach(self) -> tuple[PowerContact, arb]:
        """The way in, and when it begins."""
        return touching(self.exact["mass"], self.exact["k2"], Fraction(2), *self.begin)

    @per_precision
    def rate(self) -> arb:
        """The angular frequency w [1/s] of the way out."""
        return arb_of(self.exact["k1"] / self.exact["mass"]).sqrt()

    def evaluate(self, t: arb) -> dict[str, arb]:
        if t < 0:
            raise NotCertifiedError("wedge-collision: t < 0 is before the start")
        contact, touch = self.approach()
        since = t - touch
        rate = self.rate()
        if since < 0:
            return {
                "overlap": arb_of(self.begin[0]) + arb_of(self.begin[1]) * t,
                "v": arb_of(self.begin[1]),
            }
        turned = since - contact.half
        if turned < 0:
            overlap, speed = contact.state(since)
            return {"overlap": overlap, "v": speed}
        after = turned - arb.pi() / (2 * rate)
        if after >= 0:
            return {"overlap": -contact.depth * rate * after, "v": -contact.depth * rate}
        if not (turned >= 0 and after < 0):
            raise UndecidedError(f"whether it has turned, or parted, at {t}")
        return {
            "overlap": contact.depth * (rate * turned).cos(),
            "v": -contact.depth * rate * (rate * turned).sin(),
        }

    @per_precision
    def growth(self) -> Grows:
        return Growth(self.stretches(), Norm([1, 1]), step=narrow(self.rate()))

    def stretches(self) -> Iterator[Stretch]:
        """The stretches of the motion: in by scaling, out and away by linear laws.

        At the turn, v = 0, the acceleration jumps from -k2 d_m^2/m to -k1 d_m/m: an error of v,
        which shifts the time of the turn, is multiplied by their ratio, one of the place stays.
        """
        (contact, touch), rate = self.approach(), self.rate()
        ratio = arb_of(self.scale["overlap"] / self.scale["v"])
        power = arb_of(Fraction(2, 3))
        stiffness = arb_of(self.exact["k2"] / self.exact["mass"])
        quick = steepness(2 * stiffness * contact.depth, ratio)

        def inward(t: arb) -> arb_mat:
            since = t - touch
            overlap, speed = (
                contact.state(since)
                if since > 0 or since == 0
                else (contact.speed * since, contact.speed)
            )
            if since > 0:
                push = -stiffness * overlap * overlap
            else:
                push = arb(0)
            return homogeneous(overlap, speed, push, since, power, ratio)

        turned = touch + contact.half
        parted = arb.pi() / (2 * rate)
        jump = arb_mat([[arb(1), arb(0)], [arb(0), rate * rate / (stiffness * contact.depth)]])
        yield smooth(arb(0), turned, inward, jump=jump, quickness=lambda t: quick)
        yield smooth(turned, parted, partial(linear, rate * rate, -1, ratio))
        yield smooth(turned + parted, None, partial(linear, rate * rate, 0, ratio))

    def constants(self) -> dict[str, arb]:
        contact, _ = self.approach()
        before = arb_of(self.exact["mass"] * self.exact["closing_speed"] ** 2 / 2)
        after = arb_of(self.exact["k1"] / 2) * contact.depth * contact.depth
        duration = contact.half + arb.pi() / (2 * self.rate())
        return {"energy_change": after - before, "max_overlap": contact.depth, "duration": duration}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case wedge-collision."""
    return WedgeCollision(scale, numbers(p, "mass", "k1", "k2", "closing_speed"))
