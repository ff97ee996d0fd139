"""m x'' + 2 m delta x' + k x = m g + m f0 cos(w t): damped in any of three ways, driven or not,
from any start.

Free motion, X = x - c about the equilibrium c = m g/k, with w0^2 = k/m and D^2 = |w0^2 - delta^2|:

    X = X0 (C + delta S) + V0 S,    V = V0 (C - delta S) - w0^2 X0 S,
    C = exp(-delta t) cos D t,  S = exp(-delta t) (sin D t)/D     below critical damping,
    C = exp(-delta t),  S = exp(-delta t) t                       at it,

and cosh, sinh above it. A drive adds its steady motion Re(A exp(i w t)), A = f0/(w0^2 - w^2 + 2 i
delta w) (1.104), whose start is taken from X0, V0; without damping at w = w0 it adds f0 t sin(w0
t)/(2 w0) instead.
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
from refdem.truth.growth import Grows, Norm, SteadyGrowth, Told, narrow
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start


@dataclass(frozen=True, kw_only=True)
class DrivenOscillator(ClosedForm):
    """x [m] and v [m/s] at t; `f0` [m/s^2] and `drive` [rad/s] are zero where nothing drives."""

    method = "closed form; regime and resonance decided in exact rationals"
    witness = "Taylor series of the equation in rational arithmetic"
    state = ("x", "v")

    mass: Fraction
    stiffness: Fraction
    gravity: Fraction
    x0: Fraction
    v0: Fraction
    delta: Fraction
    f0: Fraction = Fraction(0)
    drive: Fraction = Fraction(0)
    is_driven: bool

    displaced = displaced_fields("x0", "v0")
    jacobian = derivative_by_start

    @property
    def square(self) -> Fraction:
        """The square w0^2 = k/m of the angular frequency [1/s^2]."""
        return self.stiffness / self.mass

    @property
    def centre(self) -> Fraction:
        """The equilibrium c = m g/k [m]."""
        return self.gravity / self.square

    @property
    def gap(self) -> Fraction:
        """The difference w0^2 - delta^2 of squared frequencies [1/s^2]."""
        return self.square - self.delta**2

    @property
    def resounds(self) -> bool:
        """True if undamped and driven at w = w0, where the amplitude grows without bound."""
        return self.delta == 0 and self.drive**2 == self.square

    def free(self, x0: arb, v0: arb, t: arb) -> tuple[arb, arb]:
        """X and V at time t of the free motion about the equilibrium from X0, V0."""
        # X = X0 (C + delta S) + V0 S,  V = V0 (C - delta S) - w0^2 X0 S
        delta = arb_of(self.delta)
        decay = (-arb_of(self.delta) * t).exp()
        d = arb_of(abs(self.gap)).sqrt()
        if self.gap > 0:
            c = (d * t).cos()
            s = (d * t).sin() / d
        elif self.gap < 0:
            c = (d * t).cosh()
            s = (d * t).sinh() / d
        else:
            c = arb(1)
            s = t
        c = decay * c
        s = decay * s
        x = x0 * (c + delta * s) + v0 * s
        v = v0 * (c - delta * s) - arb_of(self.square) * x0 * s
        return x, v

    def steady(self, t: arb) -> tuple[arb, arb]:
        """x and v at t of the steady motion; at undamped resonance of the growing one from rest.

        With a = w0^2 - w^2 and b = 2 delta w, Re(f0 exp(i w t)/(a + i b)) = f0 (a cos w t + b sin w
        t)/(a^2 + b^2).
        """
        f0 = arb_of(self.f0)
        w = arb_of(self.drive)
        sine, cosine = (w * t).sin_cos()
        if self.f0 == 0:
            return arb(0), arb(0)
        # x = f0 t sin(w0 t)/(2 w0),  v = f0 (sin w0 t + w0 t cos w0 t)/(2 w0)
        if self.resounds:
            return f0 * t * sine / (2 * w), f0 * (sine + w * t * cosine) / (2 * w)
        a = arb_of(self.square - self.drive**2)
        b = arb_of(2 * self.delta * self.drive)
        norm_square = a * a + b * b
        # x = f0 (a cos w t + b sin w t)/(a^2 + b^2) and its derivative.
        x = f0 * (a * cosine + b * sine) / norm_square
        v = f0 * w * (b * cosine - a * sine) / norm_square
        return x, v

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = c + X + x_s with the steady motion x_s; X0 = x0 - c - x_s(0), V0 = v0 - v_s(0)."""
        centre = arb_of(self.centre)
        x_first, v_first = self.steady(arb(0))
        x_steady, v_steady = self.steady(t)
        x, v = self.free(arb_of(self.x0) - centre - x_first, arb_of(self.v0) - v_first, t)
        return {"x": centre + x + x_steady, "v": v + v_steady}

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: the motion is linear, so that an error moves as the free motion does,
        whenever it is made; in a whole period it does not grow.
        """
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        if self.delta**2 >= 4 * self.square:
            # Over-damped, with the rates s1 < s2 = delta -+ kappa. At all times
            #   |dx/dx0| = (s2 exp(-s1 t) - s1 exp(-s2 t))/(s2 - s1) <= 1,  |dx/dv0| <= 1/(s2 - s1),
            #   |dv/dx0| <= s1 s2/(s2 - s1) with s1 s2 = w0^2,              |dv/dv0| <= 1.
            rate_gap = 2 * arb_of(-self.gap).sqrt()
            x_by_v = 1 / (rate_gap * ratio)
            v_by_x = arb_of(self.square) * ratio / rate_gap
            off_diagonal = x_by_v.max(v_by_x).upper()
            return Told(lambda _: 1 + off_diagonal)
        one = arb(1)
        zero = arb(0)

        def propagator(elapsed: arb) -> arb_mat:
            """The matrix that maps errors of (x, v) in scales to those after a time [s]."""
            x_by_x, v_by_x = self.free(one, zero, elapsed)
            x_by_v, v_by_v = self.free(zero, one, elapsed)
            # In scales: x by v0 times V/X, v by x0 times X/V; `ratio` is X/V.
            return arb_mat([[x_by_x, x_by_v / ratio], [v_by_x * ratio, v_by_v]])

        if self.gap > 0:
            # After 2 pi/D the flow is exp(-delta t) times the identity.
            period = 2 * arb.pi() / arb_of(self.gap).sqrt()
        else:
            period = None
        fastest = arb_of(self.square).sqrt() + arb_of(self.delta)
        return SteadyGrowth(propagator, Norm([1, 1]), narrow(fastest), period)

    def constants(self) -> dict[str, arb]:
        """The period 2 pi/D of the free oscillation, if it oscillates.

        Of a driven one the amplitude |A| = |f0|/sqrt((w0^2 - w^2)^2 + (2 delta w)^2) (1.105) of the
        steady motion, if there is one.
        """
        if not self.is_driven:
            if self.gap > 0:
                return {"period": 2 * arb.pi() / arb_of(self.gap).sqrt()}
            return {}
        if self.resounds:
            return {}
        a = self.square - self.drive**2
        b = 2 * self.delta * self.drive
        # |A| = |f0|/sqrt(a^2 + b^2), a = w0^2 - w^2, b = 2 delta w.
        return {"steady_amplitude": arb_of(abs(self.f0)) / arb_of(a**2 + b**2).sqrt()}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, gravity, delta, f0, drive, x0, v0.

    `scale` of x and v.
    """
    names = ("mass", "stiffness", "gravity", "x0", "v0", "delta", "f0", "drive")
    return DrivenOscillator(refiner=Refiner.of(scale), is_driven=True, **numbers(p, *names))
