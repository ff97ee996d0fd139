"""Duffing's oscillator x'' + alpha x + beta x^3 = 0 from rest at A, by Jacobi's functions for every
sign that keeps it bounded.

Energy gives v^2 = (A^2 - x^2) (alpha + beta (A^2 + x^2)/2). With c = alpha + beta A^2 (-c A is the
acceleration at the start), h = alpha + beta A^2/2 and m1 = 1 - m, it follows (DLMF 22.13.4-6):

    beta > 0, h > 0        x = A cn(sqrt(c) t | m),           m = beta A^2/(2 c)
    beta > 0, h = 0        x = A sech(sqrt(-alpha) t)         the separatrix
    beta > 0, h < 0 < c    x = A dn(sqrt(beta/2) A t | m),    m = 2 c/(beta A^2)
    beta > 0, c < 0        x = A nd(sqrt(beta/2) B t | m),    m = -2 c/(beta B^2)
    beta < 0 < c           x = A cd(sqrt(h) t | m),           m = -beta A^2/(2 h)
    c = 0                  x = A                              an equilibrium

In a well (h < 0) A is the farther turning point for c > 0 and the nearer one for c < 0, with B^2 =
-2 alpha/beta - A^2 the square of the other one.

Motions from neighbouring starts: every elliptic line above is x = A S(r t | m) with r and m
functions of A; `m_slope` = dm/dA and `log_rate_slope` = d ln r/dA.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.energy_growth import Line, Neighbour
from refdem.truth.exact import numbers
from refdem.truth.from_rest import derivative_from_rest, rates_from_rest
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.jacobi import Jacobi
from refdem.truth.refiner import Refiner, Sensitivity
from refdem.truth.smooth_flow import growth_along, growth_of_an_equation
from refdem.truth.validated_flow import ValidatedFlow

Shape = Callable[[arb], tuple[arb, arb]]
"""S(u) = x/A and S'(u) at the phase u = r t."""
Change = tuple[arb, arb]
"""C(u) and C'(u), where dS/dm at fixed u is C + kappa S' (`Jacobi.kappa`)."""
Elliptic = Callable[[Jacobi, arb], tuple[tuple[arb, arb], Change]]
"""(S, S') and (C, C') of one of Jacobi's functions at u."""


@dataclass(frozen=True)
class Family:
    """The family of motions x = A S(r t | m) from rest at neighbouring A: dm/dA and d ln r/dA."""

    jacobi: Jacobi
    shape: Elliptic
    m_slope: arb
    log_rate_slope: arb


@dataclass(frozen=True)
class DuffingMotion:
    """x = A shape(rate t), with rate in rad/s; its period [s] and its family, None without one."""

    shape: Shape
    rate: arb
    period: arb | None
    family: Family | None = None


@dataclass(frozen=True, kw_only=True)
class Duffing(ClosedForm):
    """x [m] and v [m/s] at t; scalar period [s] where there is one."""

    state = ("x", "v")
    method = (
        "Jacobi elliptic functions by theta functions; sech on the separatrix; cosine, or cosh, for"
        " beta = 0"
    )
    witness = "validated integration of the equation of motion; energy; the period by quadrature"
    proof_of_s = Sensitivity(CLOSED_BITS)

    alpha: Fraction
    beta: Fraction
    amplitude: Fraction

    displaced = displaced_fields("amplitude")
    jacobian = derivative_from_rest

    def acceleration(self, x: arb) -> arb:
        return -(arb_of(self.alpha) + arb_of(self.beta) * x * x) * x

    @per_precision
    def motion(self) -> DuffingMotion:
        """The motion, by the line of the table above that holds, decided in exact rationals.

        Raises NotCertifiedError where the motion goes to infinity in a finite time.
        """
        if self.beta == 0:
            return self._linear_motion()
        if self.beta > 0:
            return self._bounded_motion()
        c = self.alpha + self.beta * self.amplitude**2
        if c == 0:
            return self._equilibrium()
        if c > 0:
            return self._softening_motion()
        raise NotCertifiedError(
            "singular: the motion goes to infinity: the start is above the escape energy",
            code="singular",
            time=0.0,
        )

    def _equilibrium(self) -> DuffingMotion:
        """The constant motion x = A of an equilibrium."""
        return DuffingMotion(lambda u: (arb(1), arb(0)), arb(0), None)

    def _linear_motion(self) -> DuffingMotion:
        """The motion for beta = 0: x = A cos(sqrt(alpha) t), or A cosh(sqrt(-alpha) t)."""
        if self.alpha == 0:
            return self._equilibrium()
        if self.alpha > 0:
            rate = arb_of(self.alpha).sqrt()
            return DuffingMotion(lambda u: (u.cos(), -u.sin()), rate, 2 * arb.pi() / rate)
        # It grows without bound, and is finite at all times.
        return DuffingMotion(lambda u: (u.cosh(), u.sinh()), arb_of(-self.alpha).sqrt(), None)

    def _bounded_motion(self) -> DuffingMotion:
        """The motion for beta > 0, where every start stays bounded."""
        a = self.amplitude
        beta_a2 = self.beta * a**2
        c = self.alpha + beta_a2
        h = self.alpha + beta_a2 / 2
        if c == 0:
            return self._equilibrium()
        if h > 0:
            # A cn(sqrt(c) t | m): c' = 2 beta A, so that m' = alpha beta A/c^2.
            return _elliptic(
                _cn,
                arb_of(c).sqrt(),
                m=beta_a2 / (2 * c),
                m1=h / c,
                quarters=4,
                m_slope=self.alpha * (self.beta * a) / c**2,
                log_rate_slope=self.beta * a / c,
            )
        if h == 0:
            # A sech(sqrt(-alpha) t), the separatrix through the unstable equilibrium x = 0.
            return DuffingMotion(
                lambda u: (1 / u.cosh(), -u.tanh() / u.cosh()), arb_of(-self.alpha).sqrt(), None
            )
        if c > 0:
            # A dn(sqrt(beta/2) A t | m): m = 2 + 2 alpha/(beta A^2), m' = -4 alpha/(beta A^3).
            return _elliptic(
                _dn,
                arb_of(beta_a2 / 2).sqrt(),
                m=2 * c / beta_a2,
                m1=-2 * h / beta_a2,
                quarters=2,
                m_slope=-4 * self.alpha / (beta_a2 * a),
                log_rate_slope=1 / a,
            )
        # A nd(sqrt(beta/2) B t | m): m1 = A^2/B^2, (beta B^2)' = -2 beta A.
        beta_b2 = -2 * self.alpha - beta_a2
        return _elliptic(
            _nd,
            arb_of(beta_b2 / 2).sqrt(),
            m=-2 * c / beta_b2,
            m1=beta_a2 / beta_b2,
            quarters=2,
            m_slope=4 * self.alpha * (self.beta * a) / beta_b2**2,
            log_rate_slope=-(self.beta * a) / beta_b2,
        )

    def _softening_motion(self) -> DuffingMotion:
        """The motion for beta < 0 < c, below the escape energy: A cd(sqrt(h) t | m).

        Its rate changes with h' = beta A.
        """
        a = self.amplitude
        beta_a2 = self.beta * a**2
        c = self.alpha + beta_a2
        h = self.alpha + beta_a2 / 2
        return _elliptic(
            _cd,
            arb_of(h).sqrt(),
            m=-beta_a2 / (2 * h),
            m1=c / h,
            quarters=4,
            m_slope=-self.alpha * (self.beta * a) / h**2,
            log_rate_slope=self.beta * a / (2 * h),
        )

    def evaluate(self, t: arb) -> dict[str, arb]:
        """x = A S(r t) and v = A r S'(r t)."""
        motion = self.motion()
        shape, shape_slope = motion.shape(motion.rate * t)
        amplitude = arb_of(self.amplitude)
        return {"x": amplitude * shape, "v": amplitude * motion.rate * shape_slope}

    def rates(self, t: Fraction) -> tuple[arb, arb]:
        """d(x, v)(t)/d v(0), as of any start from rest (from_rest.py).

        At an equilibrium, where alpha = -beta A^2, a small displacement d obeys the linear equation
        d'' = -(alpha + 3 beta A^2) d = 2 alpha d, d(0) = 0, d'(0) = 1.
        """
        if self.alpha + self.beta * self.amplitude**2 != 0:
            return rates_from_rest(self, t)
        # d = sin(w t)/w for alpha < 0, sinh(w t)/w for alpha > 0, with w^2 = 2 |alpha|.
        w = arb_of(2 * abs(self.alpha)).sqrt()
        u = w * arb_of(t)
        if self.alpha < 0:
            return (u.sin() / w, u.cos())
        return (u.sinh() / w, u.cosh())

    def by_equation(self) -> ValidatedFlow:
        """The same quantities from the equation of motion, to the same digits."""
        return self.equation().refined(self.digits)

    def equation(self) -> ValidatedFlow:
        """The same motion by its equation, with the same quantities."""

        def field(y: Sequence[Any]) -> list[Any]:
            x, v = y
            # v' = -(alpha + beta x^2) x.
            return [v, -(x * x * self.beta + self.alpha) * x]

        start = [self.amplitude, Fraction(0)]
        return ValidatedFlow(
            field,
            start,
            lambda y: dict(zip(self.state, y, strict=True)),
            self.scale,
            state=self.state,
            moved=(0, 1),
        )

    def line(self) -> Line | None:
        """The motion and its family in closed form, for S; None where they are not elliptic."""
        motion = self.motion()
        family = motion.family
        if family is None:
            return None

        def state(t: arb) -> tuple[arb, arb]:
            solution = self.evaluate(t)
            return solution["x"], solution["v"]

        return Line(
            state,
            self.acceleration,
            lambda t: self.neighbour(motion, family, t),
            motion.period,
            self.steepest(),
        )

    @per_precision
    def growth(self) -> Grows:
        """S from the family of motions, where it is elliptic; else from the equation of motion."""
        line = self.line()
        if line is not None:
            return growth_along(line, self.scale, self.equation())
        return growth_of_an_equation(self.equation(), self.motion().period)

    def neighbour(self, motion: DuffingMotion, family: Family, t: arb) -> Neighbour:
        """The derivative of (x, v) by A as P + K (x', v') (energy_growth.py), and H' = c A.

        x = A S(u | m) and v = A r S'(u | m) with u = r t. By m at fixed u, S changes as C + kappa
        S', and S' as C' + kappa' S' + kappa S''; u changes by A as u (ln r)'. What is proportional
        to (x', v') = A r (S', r S'') is K = (ln r)' t + m' kappa/r. The rest is P:

            P_x = S + A m' C,    P_v = r (S' (1 + A (ln r)') + A m' (C' + kappa' S')).
        """
        u = motion.rate * t
        (shape, shape_slope), (change, change_slope) = family.shape(family.jacobi, u)
        amplitude = arb_of(self.amplitude)
        dn = family.jacobi.sn_cn_dn(u)[2]
        m = family.jacobi.m
        m1 = family.jacobi.m1
        # kappa = (u/m - E(u)/(m m1))/2 with E' = dn^2.
        kappa_slope = (1 / m - dn * dn / (m * m1)) / 2
        slope_by_m = change_slope + kappa_slope * shape_slope
        # P_x = S + A m' C.
        place = shape + amplitude * family.m_slope * change
        # P_v = r (S' (1 + A (ln r)') + A m' (C' + kappa' S')).
        of_amplitude = shape_slope * (1 + amplitude * family.log_rate_slope)
        of_parameter = amplitude * family.m_slope * slope_by_m
        speed = motion.rate * (of_amplitude + of_parameter)
        # K = (ln r)' t + m' kappa/r.
        along = family.log_rate_slope * t + family.m_slope * family.jacobi.kappa(u) / motion.rate
        # dH/dA = alpha A + beta A^3 = c A.
        energy_slope = -self.acceleration(amplitude)
        return Neighbour(place, speed, along, energy_slope)

    def steepest(self) -> arb:
        """A bound of |f'(x)| = |alpha + 3 beta x^2| along the motion.

        f' is monotone in x^2, so that it is largest at an end of the range of x^2: 0, A^2, or B^2 =
        -2 alpha/beta - A^2 at the other turning point of a well.
        """
        beta_a2 = self.beta * self.amplitude**2
        beta_b2 = -2 * self.alpha - beta_a2
        slopes = [self.alpha, self.alpha + 3 * beta_a2, self.alpha + 3 * beta_b2]
        return arb_of(max(abs(slope) for slope in slopes))

    def constants(self) -> dict[str, arb]:
        period = self.motion().period
        if period is None:
            return {}
        return {"period": period}


def _elliptic(
    shape: Elliptic,
    rate: arb,
    *,
    m: Fraction,
    m1: Fraction,
    quarters: int,
    m_slope: Fraction,
    log_rate_slope: Fraction,
) -> DuffingMotion:
    """The motion x = A shape(rate t | m), whose period is quarters K(m)/rate.

    m1 is 1 - m, given apart so that it is not lost by cancellation; `m_slope` and `log_rate_slope`
    are dm/dA and d ln rate/dA.
    """
    jacobi = Jacobi(arb_of(m), arb_of(m1))
    family = Family(jacobi, shape, arb_of(m_slope), arb_of(log_rate_slope))
    return DuffingMotion(lambda u: shape(jacobi, u)[0], rate, quarters * jacobi.k / rate, family)


def _cn(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    """S = cn, S' = -sn dn; C = -sn^2 cn/(2 m1), C' = -sn dn (2 cn^2 - sn^2)/(2 m1)."""
    sn, cn, dn = j.sn_cn_dn(u)
    factor = 1 / (2 * j.m1)
    change = -factor * sn * sn * cn
    change_slope = -factor * sn * dn * (2 * cn * cn - sn * sn)
    return (cn, -sn * dn), (change, change_slope)


def _dn(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    """S = dn, S' = -m sn cn; C = -sn^2 dn/(2 m1), C' = -sn cn (2 dn^2 - m sn^2)/(2 m1)."""
    sn, cn, dn = j.sn_cn_dn(u)
    factor = 1 / (2 * j.m1)
    change = -factor * sn * sn * dn
    change_slope = -factor * sn * cn * (2 * dn * dn - j.m * sn * sn)
    return (dn, -j.m * sn * cn), (change, change_slope)


def _nd(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    """S = 1/dn, S' = m sn cn/dn^2; C = sn^2/(2 m1 dn), C' = sn cn (2 + m sn^2/dn^2)/(2 m1)."""
    sn, cn, dn = j.sn_cn_dn(u)
    factor = 1 / (2 * j.m1)
    change = factor * sn * sn / dn
    change_slope = factor * sn * cn * (2 * dn * dn + j.m * sn * sn) / (dn * dn)
    return (1 / dn, j.m * sn * cn / (dn * dn)), (change, change_slope)


def _cd(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    """S = cn/dn, S' = -m1 sn/dn^2; C = 0, because the factors of cn and dn by m are the same."""
    sn, cn, dn = j.sn_cn_dn(u)
    return (cn / dn, -j.m1 * sn / (dn * dn)), (arb(0), arb(0))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters alpha [1/s^2], beta [1/(m^2 s^2)], amplitude [m].

    `scale` has the sizes of x and v against which their errors count.
    """
    return Duffing(refiner=Refiner.of(scale), **numbers(p, "alpha", "beta", "amplitude"))
