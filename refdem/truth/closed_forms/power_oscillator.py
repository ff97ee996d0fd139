"""m x'' + k |x|^n sgn x = 0 from rest: incomplete beta functions and their inverses, as Arb balls.

With p = n + 1, y = x/A, w = -v/u and u = sqrt(2 k/(m p)) A^(p/2), energy is conserved as
y^p + w^2 = 1. In units of A/u (DLMF 8.17.7) the time

    from the centre is           q(y) = y 2F1(1/2, 1/p; 1 + 1/p; |y|^p),
    from the turning point is    s(w) = (2/p) w 2F1(1/2, 1 - 1/p; 3/2; w^2),

and a quarter of the period is B(1/p, 1/2)/p. Each series is used where its argument is at most
about 1/2. The inversion is proved: since q' >= 1 and s' >= 2/p, the distance of a trial value from
the root is at most its residual divided by that bound (mean value theorem).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb, arb_mat, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of, nearest_integer
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.dual import ball, carried, plain, slopes_of
from refdem.truth.exact import numbers
from refdem.truth.from_rest import derivative_from_rest, rates_from_rest
from refdem.truth.growth import Grows, Growth, Norm, PeriodicGrowth, narrow, smooth
from refdem.truth.hypergeometric import two_f_one
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
        # For a ball x that contains 0 both signs are possible.
        size = arb_of(self.ratio) * magnitude(x, arb_of(self.exponent))
        if x > 0:
            return -size
        if x < 0:
            return size
        return size.union(-size)

    def rate(self) -> arb:
        """The rate u/A = sqrt(2 k/(m p)) A^((n - 1)/2) [1/s] of the motion."""
        # u = sqrt(2 k/(m p)) A^(p/2), so that u/A = sqrt(2 k/(m p)) A^((n - 1)/2).
        amplitude = arb_of(abs(self.amplitude))
        factor = (2 * arb_of(self.ratio) / self.p).sqrt()
        return factor * amplitude ** ((arb_of(self.exponent) - 1) / 2)

    @per_precision
    def quarter(self) -> arb:
        """A quarter of the period in units of A/u: sqrt(pi) gamma(1 + 1/p)/gamma(1/2 + 1/p)."""
        # B(1/p, 1/2)/p with gamma(1/2) = sqrt(pi) and gamma(1/p)/p = gamma(1 + 1/p)
        share = 1 / self.p
        return arb.pi().sqrt() * gamma(1 + share) / gamma(arb(0.5) + share)

    def from_centre(self, y: arb) -> arb:
        """The integral q(y) from the centre, for an exact y."""
        # q(y) = y 2F1(1/2, 1/p; 1 + 1/p; |y|^p)
        share = 1 / self.p
        return y * two_f_one(arb(0.5), share, 1 + share, magnitude(y, self.p))

    def centre_slope(self, y: arb) -> arb:
        """The derivative (1 - |y|^p)^(-1/2) >= 1 of q(y)."""
        return (1 - magnitude(y, self.p)).rsqrt()

    def from_turning(self, w: arb) -> arb:
        """The integral s(w) from the turning point."""
        # s(w) = (2/p) w 2F1(1/2, 1 - 1/p; 3/2; w^2)
        return 2 / self.p * w * two_f_one(arb(0.5), 1 - 1 / self.p, arb(1.5), w * w)

    def turning_slope(self, w: arb) -> arb:
        """The derivative (2/p)(1 - w^2)^(1/p - 1) >= 2/p of s(w)."""
        return 2 / self.p * (1 - w * w) ** (1 / self.p - 1)

    def without_derivatives(self) -> "PowerOscillator":
        """The same motion, of numbers that carry no derivatives."""
        return replace(
            self,
            mass=plain(self.mass),
            stiffness=plain(self.stiffness),
            exponent=plain(self.exponent),
            amplitude=plain(self.amplitude),
        )

    def place(self, s: arb) -> tuple[arb, arb]:
        """y and w at the time s [A/u] from the turning point y = 1, for |s| up to a quarter period.

        Near the turning point w is the inverse of s(w), and y = (1 - w^2)^(1/p); near the centre y
        is that of q(y), and w = +-sqrt(1 - |y|^p).
        """
        exact = self.without_derivatives()
        until_centre = ball(self.quarter()) - abs(ball(s))
        if until_centre.mid() > self.middle().mid():
            w = inverse(exact.from_turning, ball(s), 2 / exact.p, exact.turning_slope)
            w = with_derivatives_of(s, self.from_turning, w, exact.turning_slope)
            return (1 - w * w) ** (1 / self.p), w
        y = inverse(exact.from_centre, until_centre, arb(1), exact.centre_slope)
        y = with_derivatives_of(self.quarter() - abs(s), self.from_centre, y, exact.centre_slope)
        w = (1 - magnitude(y, self.p)).sqrt()
        if s > 0:
            return y, w
        return y, -w

    @per_precision
    def middle(self) -> arb:
        """The time q at y^p = w^2 = 1/2, where both series have the argument 1/2."""
        return self.from_centre((arb(0.5) ** (1 / self.p)).mid())

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = A y and v = -u w, with the sign of A changed after every half period."""
        # The phase t u/A, reduced by the nearest multiple of half a period.
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
        """How errors grow: motions of other amplitudes are the same motion in other units.

        The force is steepest at the turning point, |f'| <= (k/m) n A^(n - 1).
        """
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        # A ~ u^(2/(n + 1)) with the largest speed u.
        power = arb_of(Fraction(2) / (self.exponent + 1))
        amplitude = arb_of(abs(self.amplitude))
        # (k/m) n A^(n - 1).
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
        # A quarter in units of A/u, over the rate u/A.
        return {"period": 4 * self.quarter() / self.rate()}


def magnitude(x: arb, power: arb) -> arb:
    """|x|^power for power > 0, also where the ball x contains 0.

    Raises UndecidedError where it contains 0 and x or the power carries derivatives.
    """
    if x > 0 or x < 0:
        if slopes_of(power):
            # |x|^p = exp(p ln |x|): a power of a plain ball would drop the derivatives of p.
            return (abs(x).log() * power).exp()
        return abs(x) ** power
    if slopes_of(x) or slopes_of(power):
        raise UndecidedError("the derivative of a power at the centre")
    upper = arb(x.abs_upper())
    if upper > 0:
        return arb(0).union(upper**power)
    return arb(0)


def gamma(x: arb) -> arb:
    """The gamma function, whose derivative is gamma(x) digamma(x)."""
    value: arb = ball(x).gamma()
    if not slopes_of(x):
        return value
    return carried(value, (value * ball(x).digamma(), x))


def with_derivatives_of(
    value: arb, function: Callable[[arb], arb], root: arb, slope: Callable[[arb], arb]
) -> arb:
    """The root x of function(x) = value with the derivatives that both carry, x' = (value' -
    function'(at a fixed x))/slope.
    """
    if not slopes_of(value):
        return root
    return carried(root, (1 / slope(root), value - function(root)))


def inverse(
    function: Callable[[arb], arb], value: arb, least: arb, slope: Callable[[arb], arb]
) -> arb:
    """A ball that contains the root x of function(x) = value, for a function with slope >= `least`.

    Newton's method gives an approximation x0, without a proof. By the mean value theorem the root
    satisfies |x - x0| <= |function(x0) - value|/least.
    """
    if abs(value.mid()) > 0.25:
        argument = arb(float(value.mid())) / 2
    else:
        argument = arb(value.mid())
    for _ in range(8 + ctx.prec.bit_length()):
        # x <- x - (function(x) - value)/slope(x).
        step = ((function(argument) - value) / slope(argument)).mid()
        argument = (argument - step).mid()
        if abs(step) < arb(2) ** (-ctx.prec // 2):
            break
    # (function(x0) - value)/least.
    distance = (function(argument) - value) / least
    return argument + arb(0, distance.abs_upper())


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, exponent, amplitude; `scale` of x and v."""
    exact = numbers(p, "mass", "stiffness", "exponent", "amplitude")
    return PowerOscillator(refiner=Refiner.of(scale), **exact)
