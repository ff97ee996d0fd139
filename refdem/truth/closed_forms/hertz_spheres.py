"""Two spheres that meet head-on under Hertz's law F = k d^(3/2): overlap and its rate from touch,
with free flight afterwards.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Growth, Norm, narrow, smooth
from refdem.truth.line_growth import homogeneous, steepness
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start

HERTZ = Fraction(3, 2)


@dataclass(frozen=True)
class HertzSpheres(ClosedForm):
    """overlap [m] (negative while apart) and v, its rate [m/s], from touch at t = 0.

    `begin` has both at t = 0.
    """

    state = ("overlap", "v")
    method = (
        "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound from"
        " the mean value theorem"
    )
    witness = "Taylor integration in w = sqrt(overlap), energy, numerical integration of the law"

    mass: Number
    stiffness: Number
    begin: tuple[Fraction, Fraction]

    displaced = displaced_tuple("begin")
    jacobian = derivative_by_start

    @per_precision
    def contact(self) -> tuple[PowerContact, arb]:
        """The contact, and the time [s] at which it begins."""
        return touching(self.mass, self.stiffness, HERTZ, *self.begin)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Overlap d and rate d' at t: free at first, in contact, and free after that."""
        if t < 0:
            raise NotCertifiedError("hertz-spheres: t < 0 is before the start")
        # With the times t1 of touch and t2 = t1 + 2 half of parting and the speed v at touch:
        # d = d_0 + d'_0 t for t < t1, the contact from t1 to t2, d = -v (t - t2) after that.
        contact, touch = self.contact()
        since_touch = t - touch
        if since_touch < 0:
            rate = arb_of(self.begin[1])
            return {"overlap": arb_of(self.begin[0]) + rate * t, "v": rate}
        # The contact lasts 2 half; the spheres part with the speed of touch, as the law is elastic.
        since_end = since_touch - 2 * contact.half
        if since_end >= 0:
            return {"overlap": -contact.speed * since_end, "v": -contact.speed}
        overlap, rate = contact.state(since_touch)
        return {"overlap": overlap, "v": rate}

    @per_precision
    def growth(self) -> Grows:
        """The growth S of errors: contacts of other speeds are the same motion in other units.

        The force is steepest at the largest overlap, |f'| <= (3/2)(k/m) sqrt(d_m).
        """
        contact, touch = self.contact()
        ratio = arb_of(self.scale["overlap"] / self.scale["v"])
        # d ~ u^(2/(n + 1)) with the speed u at touch, n = 3/2.
        power = arb_of(Fraction(2) / (HERTZ + 1))
        stiffness = arb_of(self.stiffness / self.mass)
        quick = steepness(stiffness * arb_of(HERTZ) * contact.depth.sqrt(), ratio)

        def errors(t: arb) -> arb_mat:
            """Two independent errors of (overlap, v), as columns in scales (line_growth.py)."""
            state = self.evaluate(t)
            overlap = state["overlap"]
            rate = state["v"]
            # d'' = -(k/m) d^(3/2) in contact.
            if overlap > 0:
                acceleration = -stiffness * overlap * overlap.sqrt()
            else:
                acceleration = arb(0)
            return homogeneous(overlap, rate, acceleration, t - touch, power, ratio)

        whole = smooth(arb(0), None, errors, quickness=lambda t: quick)
        return Growth([whole], Norm([1, 1]), step=narrow(arb(quick)))

    def constants(self) -> dict[str, arb]:
        """duration [s], max_overlap d_m [m] and max_force k d_m^(3/2) [N]."""
        contact, _ = self.contact()
        max_overlap = contact.depth
        # k d_m^(3/2).
        force = arb_of(self.stiffness) * max_overlap * max_overlap.sqrt()
        return {"duration": 2 * contact.half, "max_overlap": max_overlap, "max_force": force}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case hertz-spheres."""
    exact = numbers(p, "effective_mass", "stiffness", "closing_speed")
    begin = (Fraction(0), exact["closing_speed"])
    return HertzSpheres(Refiner.of(scale), exact["effective_mass"], exact["stiffness"], begin)
