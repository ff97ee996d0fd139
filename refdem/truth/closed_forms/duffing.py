"""Duffing's oscillator x'' + alpha x + beta x^3 = 0 from rest at A, by Jacobi's functions for every
sign that keeps it bounded.

With c = alpha + beta A^2 (-c A is the acceleration at the start) and h = alpha + beta A^2/2 (DLMF
22.13.4-6; v^2 = (A^2 - x^2) (alpha + beta (A^2 + x^2)/2)):  beta > 0, h > 0: A cn(sqrt(c) t), m =
beta A^2/(2 c);  h = 0: A sech(sqrt(-alpha) t);  h < 0 < c: A dn(sqrt(beta/2) A t), m = 2 c/(beta
A^2);  c < 0, the nearer turning point of a well: A nd(sqrt(beta/2) B t), B^2 = -2 alpha/beta - A^2,
m = -2 c/(beta B^2);  beta < 0 < c: A cd(sqrt(h) t), m = -beta A^2/(2 h);  c = 0: it stays.
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
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.energy_growth import Line, Neighbour
from refdem.truth.exact import numbers
from refdem.truth.from_rest import FromRest
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.jacobi import Jacobi
from refdem.truth.refiner import Refiner, Sensitivity
from refdem.truth.smooth_flow import growth_along, growth_of_an_equation
from refdem.truth.validated_flow import ValidatedFlow

Shape = Callable[[arb], tuple[arb, arb]]
"""x/A and its derivative at the phase u."""
Change = tuple[arb, arb]
"""How a shape changes by m, and its derivative by u, both but for kappa times their own derivatives
(Jacobi.kappa).
"""
Elliptic = Callable[[Jacobi, arb], tuple[tuple[arb, arb], Change]]
"""A shape with its derivative, and its change."""


@dataclass(frozen=True)
class Family:
    """Motions from rest beside one: x = A shape(rate t | m), with derivatives of m and of ln rate
    by A.
    """

    jacobi: Jacobi
    shape: Elliptic
    m_slope: arb
    log_rate_slope: arb


@dataclass(frozen=True)
class DuffingMotion:
    """x = A shape(rate t); a period [s], if there is one; those beside it, where they are
    elliptic.
    """

    shape: Shape
    rate: arb
    period: arb | None
    family: Family | None = None


class Duffing(FromRest, ClosedForm):
    """x [m] and v [m/s] at t; scalar period [s] where there is one."""

    state = ("x", "v")
    method = (
        "Jacobi elliptic functions by theta functions; sech on the separatrix; cosine, or cosh, for"
        " beta = 0"
    )
    witness = "validated integration of the equation of motion; energy; the period by quadrature"
    proof_of_s = Sensitivity(CLOSED_BITS)

    def __init__(self, p: Parameters, scale: Mapping[str, float]) -> None:
        self.refiner = Refiner.of(scale)
        values = numbers(p, "alpha", "beta", "amplitude")
        self.alpha = values["alpha"]
        self.beta = values["beta"]
        self.amplitude = values["amplitude"]

    def acceleration(self, x: arb) -> arb:
        return -(arb_of(self.alpha) + arb_of(self.beta) * x * x) * x

    @per_precision
    def motion(self) -> DuffingMotion:
        """The kind of motion, decided in exact rationals; raises NotCertifiedError where it goes to
        infinity.
        """
        square = self.beta * self.amplitude**2
        c = self.alpha + square
        h = self.alpha + square / 2
        # Half the derivative of beta A^2 by A.
        pull = self.beta * self.amplitude
        if c == 0:
            return DuffingMotion(lambda u: (arb(1), arb(0)), arb(0), None)
        if self.beta == 0 and self.alpha > 0:
            rate = arb_of(self.alpha).sqrt()
            return DuffingMotion(lambda u: (u.cos(), -u.sin()), rate, 2 * arb.pi() / rate)
        if self.beta > 0 and h > 0:
            m_slope = self.alpha * pull / c**2
            return _elliptic(_cn, arb_of(c).sqrt(), square / (2 * c), h / c, 4, m_slope, pull / c)
        if self.beta > 0 and h == 0:
            return DuffingMotion(
                lambda u: (1 / u.cosh(), -u.tanh() / u.cosh()), arb_of(-self.alpha).sqrt(), None
            )
        if self.beta > 0 and c > 0:
            m_slope = -4 * self.alpha / (square * self.amplitude)
            return _elliptic(
                _dn,
                arb_of(square / 2).sqrt(),
                2 * c / square,
                -2 * h / square,
                2,
                m_slope,
                1 / self.amplitude,
            )
        if self.beta > 0:
            farther = -2 * self.alpha - square
            m_slope = 4 * self.alpha * pull / farther**2
            return _elliptic(
                _nd,
                arb_of(farther / 2).sqrt(),
                -2 * c / farther,
                square / farther,
                2,
                m_slope,
                -pull / farther,
            )
        if self.beta < 0 and c > 0:
            m_slope = -self.alpha * pull / h**2
            return _elliptic(
                _cd, arb_of(h).sqrt(), -square / (2 * h), c / h, 4, m_slope, pull / (2 * h)
            )
        if self.beta == 0:
            # x'' = -alpha x with alpha < 0 grows for ever and is never infinite.
            return DuffingMotion(lambda u: (u.cosh(), u.sinh()), arb_of(-self.alpha).sqrt(), None)
        raise NotCertifiedError(
            "singular: the motion goes to infinity: the start is above the escape energy",
            code="singular",
            time=0.0,
        )

    def evaluate(self, t: arb) -> dict[str, arb]:
        motion = self.motion()
        x, slope = motion.shape(motion.rate * t)
        reach = arb_of(self.amplitude)
        return {"x": reach * x, "v": reach * motion.rate * slope}

    def rates(self, t: Fraction) -> tuple[arb, arb]:
        """The rates as of any start from rest; of an equilibrium those of its linear equation, d''
        = -(alpha + 3 beta A^2) d = 2 alpha d.
        """
        if self.alpha + self.beta * self.amplitude**2 != 0:
            return self.rates_of_the_motion(t)
        w = arb_of(2 * abs(self.alpha)).sqrt()
        u = w * arb_of(t)
        if self.alpha < 0:
            return (u.sin() / w, u.cos())
        return (u.sinh() / w, u.cosh())

    def equation(self) -> ValidatedFlow:
        """The same motion by its equation, with the same quantities."""

        def field(y: Sequence[Any]) -> list[Any]:
            x, v = y
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
        """The motion and those beside it in closed form; None where they are not elliptic."""
        motion = self.motion()
        family = motion.family
        if family is None:
            return None

        def state(t: arb) -> tuple[arb, arb]:
            found = self.evaluate(t)
            return found["x"], found["v"]

        return Line(
            state,
            self.acceleration,
            lambda t: self.neighbour(motion, family, t),
            motion.period,
            self.steepest(),
        )

    @per_precision
    def growth(self) -> Grows:
        """S from the motions beside it, where they are elliptic; else from the equation."""
        line = self.line()
        if line is not None:
            return growth_along(line, self.scale, self.equation())
        return growth_of_an_equation(self.equation(), self.motion().period)

    def neighbour(self, motion: DuffingMotion, family: Family, t: arb) -> Neighbour:
        """How x = A S(rate t | m) and v = A rate S' change by A; H' = c A."""
        u = motion.rate * t
        (shape, slope), (change, change_rate) = family.shape(family.jacobi, u)
        reach = arb_of(self.amplitude)
        dn = family.jacobi.sn_cn_dn(u)[2]
        m = family.jacobi.m
        m1 = family.jacobi.m1
        # S' changes by m as (change)' + kappa' S' + kappa S''.
        kappa_rate = (1 / m - dn * dn / (m * m1)) / 2
        by_m = change_rate + kappa_rate * slope
        place = shape + reach * family.m_slope * change
        speed = motion.rate * (
            slope * (1 + reach * family.log_rate_slope) + reach * family.m_slope * by_m
        )
        along = family.log_rate_slope * t + family.m_slope * family.jacobi.kappa(u) / motion.rate
        return Neighbour(place, speed, along, -self.acceleration(reach))

    def steepest(self) -> arb:
        """Bound of |f'| along the motion: alpha + 3 beta x^2 at 0 and at the turning points of a
        well.
        """
        square = self.beta * self.amplitude**2
        slopes = [self.alpha, self.alpha + 3 * square, self.alpha + 3 * (-2 * self.alpha - square)]
        return arb_of(max(abs(slope) for slope in slopes))

    def constants(self) -> dict[str, arb]:
        period = self.motion().period
        if period is None:
            return {}
        return {"period": period}


def _elliptic(
    shape: Elliptic,
    rate: arb,
    m: Fraction,
    m1: Fraction,
    quarters: int,
    m_slope: Fraction,
    log_rate_slope: Fraction,
) -> DuffingMotion:
    """x = A shape(rate t | m), m1 = 1 - m, whose period is so many K; m and ln rate change by A as
    told.
    """
    jacobi = Jacobi(arb_of(m), arb_of(m1))
    family = Family(jacobi, shape, arb_of(m_slope), arb_of(log_rate_slope))
    return DuffingMotion(lambda u: shape(jacobi, u)[0], rate, quarters * jacobi.k / rate, family)


def _cn(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    sn, cn, dn = j.sn_cn_dn(u)
    swell = 1 / (2 * j.m1)
    change = -swell * sn * sn * cn
    rate = -swell * sn * dn * (2 * cn * cn - sn * sn)
    return (cn, -sn * dn), (change, rate)


def _dn(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    sn, cn, dn = j.sn_cn_dn(u)
    swell = 1 / (2 * j.m1)
    change = -swell * sn * sn * dn
    rate = -swell * sn * cn * (2 * dn * dn - j.m * sn * sn)
    return (dn, -j.m * sn * cn), (change, rate)


def _nd(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    sn, cn, dn = j.sn_cn_dn(u)
    swell = 1 / (2 * j.m1)
    change = swell * sn * sn / dn
    rate = swell * sn * cn * (2 * dn * dn + j.m * sn * sn) / (dn * dn)
    return (1 / dn, j.m * sn * cn / (dn * dn)), (change, rate)


def _cd(j: Jacobi, u: arb) -> tuple[tuple[arb, arb], Change]:
    """cd changes by m along itself alone."""
    sn, cn, dn = j.sn_cn_dn(u)
    return (cn / dn, -j.m1 * sn / (dn * dn)), (arb(0), arb(0))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters alpha, beta, amplitude; `scale` of x and v."""
    return Duffing(p, scale)
