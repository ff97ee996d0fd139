"""The mass on a linear spring that gravity stretches: m x'' = -k x + m g, x from the natural
length.

x(t) = c + (x0 - c) cos w t + (v0/w) sin w t with c = m g/k and w^2 = k/m; period 2 pi/w, whatever
gravity is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.exact import numbers
from refdem.truth.growth import Grows, Norm, SteadyGrowth, narrow
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start


@dataclass(frozen=True, kw_only=True)
class HarmonicOscillator(ClosedForm):
    """x [m] and v [m/s] at t; gravity [m/s^2] acts along +x, so that x = m g/k is the
    equilibrium.
    """

    method = "closed form"
    witness = "Taylor series of the equation in rational arithmetic"
    state = ("x", "v")

    mass: Fraction
    stiffness: Fraction
    gravity: Fraction
    x0: Fraction
    v0: Fraction

    displaced = displaced_fields("x0", "v0")
    jacobian = derivative_by_start

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = c + a cos w t + (v0/w) sin w t and v = v0 cos w t - a w sin w t, with a = x0 - c."""
        w = arb_of(self.stiffness / self.mass).sqrt()
        centre = self.mass * self.gravity / self.stiffness
        a = arb_of(self.x0 - centre)
        v0 = arb_of(self.v0)
        sine, cosine = (w * t).sin_cos()
        x = arb_of(centre) + a * cosine + v0 / w * sine
        v = v0 * cosine - a * w * sine
        return {"x": x, "v": v}

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: the flow is linear, so that the time elapsed alone counts."""
        w = arb_of(self.stiffness / self.mass).sqrt()

        def propagator(elapsed: arb) -> arb_mat:
            """The matrix that maps errors of (x, v) in scales to those after a time [s]."""
            sine, cosine = (w * elapsed).sin_cos()
            # w X/V, with the scales X of x and V of v.
            scaled_w = w * arb_of(self.scale["x"] / self.scale["v"])
            # x = x0 cos w t + (v0/w) sin w t, v = -w x0 sin w t + v0 cos w t, each over its scale.
            return arb_mat([[cosine, sine / scaled_w], [-scaled_w * sine, cosine]])

        return SteadyGrowth(propagator, Norm([1, 1]), narrow(w), self.constants()["period"])

    def constants(self) -> dict[str, arb]:
        """The scalar constants of the motion: the period [s]."""
        # 2 pi/w = 2 pi sqrt(m/k).
        return {"period": 2 * arb.pi() * arb_of(self.mass / self.stiffness).sqrt()}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, gravity, x0, v0; `scale` of x and v."""
    exact = numbers(p, "mass", "stiffness", "gravity", "x0", "v0")
    return HarmonicOscillator(refiner=Refiner.of(scale), **exact)
