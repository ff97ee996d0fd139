"""m x'' + k |x|^n sgn x = 0 from rest: incomplete beta functions and their inverse, as balls.

With p = n + 1, y = x/A, w = -v/u, u = sqrt(2 k/(m p)) A^(p/2), energy says y^p + w^2 = 1. In units
of A/u (DLMF 8.17.7) the time

    from the centre is           q(y) = y 2F1(1/2, 1/p; 1 + 1/p; |y|^p),
    from the turning point is    s(w) = (2/p) w 2F1(1/2, 1 - 1/p; 3/2; w^2),

and a quarter of the period is B(1/p, 1/2)/p. Each series serves where its argument is at most about
1/2. They are inverted with a proof: since q' >= 1 and s' >= 2/p, a trial value is no farther from
the root than its residual over that bound (mean value theorem).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of, nearest_integer
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.exact import numbers
from refdem.truth.from_rest import derivative_from_rest, rates_from_rest
from refdem.truth.growth import Grows, Growth, Norm, PeriodicGrowth, narrow, smooth
from refdem.truth.line_growth import homogeneous, steepness
from refdem.truth.refiner import Refiner


@dataclass(frozen=True, kw_only=True)
class PowerOscillator(ClosedForm):
    """x [m] and v [m/s] at t; scalar period [s]."""

    state = ("x", "v")
    method = (
        "inverse incomplete beta functions, by 2F1 at arguments of at most 1/2 and a bound of the"
        " slope"
    )
    witness = (
        "quadrature of the time along the path; cosine (n = 1) and Jacobi's cn (n = 3); the period"
        " by gamma functions"
    )

    mass: Fraction
    stiffness: Fraction
    exponent: Fraction
    amplitude: Fraction

    displaced = displaced_fields("amplitude")
    jacobian = derivative_from_rest
    rates = rates_from_rest

    @property
    def ratio(self) -> Fraction:
        """The stiffness per mass, k/m."""
        return self.stiffness / self.mass

    @property
    def p(self) -> arb:
        """The exponent p = n + 1 of the potential."""
        return arb_of(self.exponent + 1)

    def acceleration(self, x: arb) -> arb:
        """-(k/m) |x|^n sgn x, also for a ball that holds 0."""
        size = arb_of(self.ratio) * magnitude(x, arb_of(self.exponent))
        if x > 0:
            return -size
        if x < 0:
            return size
        return size.union(-size)

    def rate(self) -> arb:
        """The rate u/A = sqrt(2 k/(m p)) A^((n - 1)/2) [1/s] of the motion."""
        amplitude = arb_of(abs(self.amplitude))
        factor = (2 * arb_of(self.ratio) / self.p).sqrt()
        return factor * amplitude ** ((arb_of(self.exponent) - 1) / 2)

    @per_precision
    def quarter(self) -> arb:
        """A quarter of the period in units of A/u: sqrt(pi) gamma(1 + 1/p)/gamma(1/2 + 1/p)."""
        share = 1 / self.p
        return arb.pi().sqrt() * (1 + share).gamma() / (arb(0.5) + share).gamma()

    def from_centre(self, y: arb) -> arb:
        """The integral q(y) from the centre, for an exact y."""
        share = 1 / self.p
        return y * magnitude(y, self.p).hypgeom_2f1(arb(0.5), share, 1 + share)

    def from_turning(self, w: arb) -> arb:
        """The integral s(w) from the turning point."""
        return 2 / self.p * w * (w * w).hypgeom_2f1(arb(0.5), 1 - 1 / self.p, arb(1.5))

    def place(self, s: arb) -> tuple[arb, arb]:
        """y and w at the time s [A/u] from the turning point y = 1, for |s| up to a quarter period.

        Near the turning point w is the inverse of s(w), s' = (2/p)(1 - w^2)^(1/p - 1), and y = (1 -
        w^2)^(1/p); near the centre y is that of q(y), q' = (1 - |y|^p)^(-1/2), and w = +-sqrt(1 -
        |y|^p).
        """
        until_centre = self.quarter() - abs(s)
        if until_centre.mid() > self.middle().mid():

            def turning_slope(w: arb) -> arb:
                return 2 / self.p * (1 - w * w) ** (1 / self.p - 1)

            w = inverse(self.from_turning, s, 2 / self.p, turning_slope)
            return (1 - w * w) ** (1 / self.p), w

        def centre_slope(y: arb) -> arb:
            return (1 - magnitude(y, self.p)).rsqrt()

        y = inverse(self.from_centre, until_centre, arb(1), centre_slope)
        w = (1 - magnitude(y, self.p)).sqrt()
        if s > 0:
            return y, w
        return y, -w

    @per_precision
    def middle(self) -> arb:
        """The time q at y^p = w^2 = 1/2, where either series serves."""
        return self.from_centre((arb(0.5) ** (1 / self.p)).mid())

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = A y and v = -u w, with the sign of A changed after every half period."""
        phase = self.rate() * t
        half_period = 2 * self.quarter()
        half_turns = nearest_integer(phase / half_period)
        y, w = self.place(phase - half_period * half_turns)
        if half_turns % 2:
            sign = -1
        else:
            sign = 1
        amplitude = arb_of(self.amplitude) * sign
        return {"x": amplitude * y, "v": -amplitude * self.rate() * w}

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: motions of other amplitudes are the same one in other units.

        The force is steepest at the turning point, |f'| <= (k/m) n A^(n - 1).
        """
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        power = arb_of(Fraction(2) / (self.exponent + 1))
        amplitude = arb_of(abs(self.amplitude))
        steepest = arb_of(self.ratio * self.exponent) * amplitude ** (arb_of(self.exponent) - 1)
        quick = steepness(steepest, ratio)

        def errors(t: arb) -> arb_mat:
            """Two independent errors of (x, v), as columns in scales (line_growth.py)."""
            state = self.evaluate(t)
            x = state["x"]
            v = state["v"]
            return homogeneous(x, v, self.acceleration(x), t, power, ratio)

        whole = smooth(arb(0), None, errors, quickness=lambda t: quick)
        return PeriodicGrowth(
            Growth([whole], Norm([1, 1]), step=narrow(arb(quick))), self.constants()["period"]
        )

    def constants(self) -> dict[str, arb]:
        """The period [s]: 4 sqrt(m/(2 k p)) A^((1 - n)/2) B(1/p, 1/2), which is 4 quarters."""
        return {"period": 4 * self.quarter() / self.rate()}


def magnitude(x: arb, power: arb) -> arb:
    """|x|^power for power > 0, also where the ball holds 0."""
    if x > 0 or x < 0:
        return abs(x) ** power
    upper = arb(x.abs_upper())
    if upper > 0:
        return arb(0).union(upper**power)
    return arb(0)


def inverse(
    function: Callable[[arb], arb], value: arb, least: arb, slope: Callable[[arb], arb]
) -> arb:
    """A ball of the argument at which a function with slope >= `least` has a value.

    Newton's method in floating point comes close, which proves nothing; by the mean value theorem
    the root is no farther away than the residual over `least`.
    """
    if abs(value.mid()) > 0.25:
        argument = arb(float(value.mid())) / 2
    else:
        argument = arb(value.mid())
    for _ in range(8 + ctx.prec.bit_length()):
        step = ((function(argument) - value) / slope(argument)).mid()
        argument = (argument - step).mid()
        if abs(step) < arb(2) ** (-ctx.prec // 2):
            break
    distance = (function(argument) - value) / least
    return argument + arb(0, distance.abs_upper())


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, exponent, amplitude; `scale` of x and v."""
    exact = numbers(p, "mass", "stiffness", "exponent", "amplitude")
    return PowerOscillator(refiner=Refiner.of(scale), **exact)
