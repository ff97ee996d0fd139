"""A wedge that collides with a wall: m d'' = -k2 d^2 up to the largest overlap d_m, and m d'' = -k1
d afterwards.

Approach: d_m = (3 m v^2/(2 k2))^(1/3), the time by the incomplete beta function. Separation: d =
d_m cos(w t), w^2 = k1/m, until d = 0.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.line_growth import homogeneous, linear, steepness
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start


@dataclass(frozen=True)
class WedgeCollision(ClosedForm):
    """overlap [m] (negative while apart) and v, its rate [m/s], from touch at t = 0.

    `begin` has both at t = 0.
    """

    state = ("overlap", "v")
    method = (
        "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound from"
        " the mean value theorem; cosine"
    )
    witness = "Taylor integration of both laws, energy, numerical integration"

    mass: Fraction
    k1: Fraction
    k2: Fraction
    begin: tuple[Fraction, Fraction]

    displaced = displaced_tuple("begin")
    jacobian = derivative_by_start

    @per_precision
    def approach(self) -> tuple[PowerContact, arb]:
        """The contact on the way in, d'' = -(k2/m) d^2, and the time [s] at which it begins."""
        return touching(self.mass, self.k2, Fraction(2), *self.begin)

    @per_precision
    def rate(self) -> arb:
        """The angular frequency w [1/s] of the way out."""
        return arb_of(self.k1 / self.mass).sqrt()

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Overlap d and rate d' at t: free, in contact on the way in, on the way out, and free."""
        if t < 0:
            raise NotCertifiedError("wedge-collision: t < 0 is before the start")
        # With the times t1 of touch, t2 = t1 + half of the turn and t3 = t2 + pi/(2 w) of parting:
        # d = d_0 + d'_0 t for t < t1, the power law from t1 to t2, d = d_m cos(w (t - t2)) from t2
        # to t3, d = -d_m w (t - t3) after that.
        contact, touch = self.approach()
        since_touch = t - touch
        w = self.rate()
        if since_touch < 0:
            rate = arb_of(self.begin[1])
            return {"overlap": arb_of(self.begin[0]) + rate * t, "v": rate}
        since_turn = since_touch - contact.half
        if since_turn < 0:
            overlap, speed = contact.state(since_touch)
            return {"overlap": overlap, "v": speed}
        since_end = since_turn - arb.pi() / (2 * w)
        if since_end >= 0:
            return {"overlap": -contact.depth * w * since_end, "v": -contact.depth * w}
        if not (since_turn >= 0 and since_end < 0):
            raise UndecidedError(f"whether it has turned, or parted, at {t}")
        overlap = contact.depth * (w * since_turn).cos()
        rate = -contact.depth * w * (w * since_turn).sin()
        return {"overlap": overlap, "v": rate}

    @per_precision
    def growth(self) -> Grows:
        """The growth S of errors, stretch by stretch."""
        return Growth(self.stretches(), Norm([1, 1]), step=narrow(self.rate()))

    def stretches(self) -> Iterator[Stretch]:
        """The stretches of the motion: approach by scaling, separation and flight by linear laws.

        At the turn, v = 0, the acceleration jumps from a1 = -k2 d_m^2/m to a2 = -k1 d_m/m: an error
        of v, which shifts the time of the turn, is multiplied by a2/a1, an error of d by 1.
        """
        contact, touch = self.approach()
        w = self.rate()
        ratio = arb_of(self.scale["overlap"] / self.scale["v"])
        # d ~ u^(2/(n + 1)) with the speed u at touch, n = 2.
        power = arb_of(Fraction(2, 3))
        stiffness = arb_of(self.k2 / self.mass)
        quick = steepness(2 * stiffness * contact.depth, ratio)

        def inward(t: arb) -> arb_mat:
            """Two independent errors of (overlap, v), as columns in scales (line_growth.py)."""
            since = t - touch
            if since > 0 or since == 0:
                overlap, speed = contact.state(since)
            else:
                overlap = contact.speed * since
                speed = contact.speed
            # d'' = -(k2/m) d^2 in contact.
            if since > 0:
                acceleration = -stiffness * overlap * overlap
            else:
                acceleration = arb(0)
            return homogeneous(overlap, speed, acceleration, since, power, ratio)

        turn_time = touch + contact.half
        way_out = arb.pi() / (2 * w)
        # The jump matrix diag(1, a2/a1), a2/a1 = k1/(k2 d_m) = w^2/((k2/m) d_m).
        jump = arb_mat([[arb(1), arb(0)], [arb(0), w * w / (stiffness * contact.depth)]])
        yield smooth(arb(0), turn_time, inward, jump=jump, quickness=lambda t: quick)
        yield smooth(turn_time, way_out, partial(linear, w * w, -1, ratio))
        yield smooth(turn_time + way_out, None, partial(linear, w * w, 0, ratio))

    def constants(self) -> dict[str, arb]:
        """energy_change k1 d_m^2/2 - m v^2/2 [J], max_overlap d_m [m] and duration [s]."""
        # Delta E = k1 d_m^2/2 - m v^2/2,  duration = half + pi/(2 w)
        contact, _ = self.approach()
        before = arb_of(self.mass * self.begin[1] ** 2 / 2)
        after = arb_of(self.k1 / 2) * contact.depth * contact.depth
        duration = contact.half + arb.pi() / (2 * self.rate())
        return {"energy_change": after - before, "max_overlap": contact.depth, "duration": duration}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case wedge-collision."""
    exact = numbers(p, "mass", "k1", "k2", "closing_speed")
    begin = (Fraction(0), exact["closing_speed"])
    return WedgeCollision(Refiner.of(scale), exact["mass"], exact["k1"], exact["k2"], begin)
