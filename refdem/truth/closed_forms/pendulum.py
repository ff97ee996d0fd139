"""Certified pendulum: theta'' = -w0^2 sin theta, w0^2 = g/l, by Jacobi's elliptic functions; tanh
and sech on the separatrix.

With k^2 = sin^2(theta0/2) + thetadot0^2/(4 w0^2), the energy over that of rest at the top (DLMF
22.19):

    k < 1, swing         sin(theta/2) = k sn(u | k^2),  u = w0 t + u0
    k > 1, revolution    theta/2 = +-am(u | 1/k^2),     u = k w0 t + u0
    k = 1, separatrix    theta/2 = +-atan sinh(w0 t)    from the bottom

The start is at the angle theta0 + half_turns pi, so that it may lie near the top exactly. In the
names below m = k^2 and m1 = 1 - k^2; `sine` and `cosine` are those of half the angle at the start.

S comes from neighbouring motions: the derivative of a motion by its energy H (energy_growth.py),
where H = thetadot^2/2 - w0^2 cos theta, so that k^2 = 1/2 + H/(2 w0^2).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of, nearest_integer
from refdem.truth.closed_form import ClosedForm, displaced_fields, per_precision
from refdem.truth.energy_growth import Line, Neighbour
from refdem.truth.exact import numbers
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.jacobi import Jacobi
from refdem.truth.refiner import Refiner, Sensitivity
from refdem.truth.smooth_flow import derivative_by_start, growth_along, growth_of_an_equation
from refdem.truth.validated_flow import Quantities, ValidatedFlow

WITNESS = (
    "Taylor series of (cos theta, sin theta, thetadot) with a proven remainder"
    " (tests/quadratic_flows.py): no elliptic function"
)


class PendulumMotion(ABC):
    """One kind of motion at the current precision."""

    @abstractmethod
    def state(self, t: arb) -> tuple[arb, arb]:
        """theta/2 [rad], without the whole turns of the start, and thetadot [rad/s] at t; both are
        continuous in t.
        """

    @abstractmethod
    def period(self) -> arb | None:
        """Time of a swing to and fro, or of a revolution [s]; None if there is none."""


@dataclass(frozen=True)
class Equilibrium(PendulumMotion):
    """Hanging, or standing exactly at the top."""

    half_angle: arb

    def state(self, t: arb) -> tuple[arb, arb]:
        return self.half_angle, arb(0)

    def period(self) -> None:
        """None: an equilibrium has no period."""


@dataclass(frozen=True)
class Swing(PendulumMotion):
    """k < 1: tan(theta/2) = k sn u/dn u, thetadot = 2 k w0 cn u, with u = w0 t + shift."""

    jacobi: Jacobi
    k: arb
    w0: arb
    shift: arb

    def state(self, t: arb) -> tuple[arb, arb]:
        # theta/2 = atan2(k sn u, dn u), thetadot = 2 k w0 cn u.
        sn, cn, dn = self.jacobi.sn_cn_dn(self.w0 * t + self.shift)
        return arb.atan2(self.k * sn, dn), 2 * self.k * self.w0 * cn

    def neighbour(self, t: arb) -> Neighbour:
        """The derivative of (theta, thetadot) by H as P + K (theta', thetadot'), with dH/dH = 1.

        By m at fixed u, sn changes as sn cn^2/(2 m1) + kappa sn' and cn as -sn^2 cn/(2 m1) + kappa
        cn' (Jacobi.kappa); what kappa multiplies is the motion itself, a shift in time by K. With
        m' = dm/dH and k' = dk/dH the rest P of sin(theta/2) = k sn u, cos(theta/2) = dn u and
        thetadot = 2 k w0 cn u is

            P_theta = 2 sn (k' + k m' cn^2/(2 m1))/dn,
            P_thetadot = 2 w0 cn (k' - k m' sn^2/(2 m1)).
        """
        u = self.w0 * t + self.shift
        sn, cn, dn = self.jacobi.sn_cn_dn(u)
        # dm/dH = 1/(2 w0^2), dk/dH = (dm/dH)/(2 k), and K = (dm/dH) kappa/w0 from u = w0 t + u0.
        m_slope = 1 / (2 * self.w0 * self.w0)
        k_slope = m_slope / (2 * self.k)
        factor = self.k * m_slope / (2 * self.jacobi.m1)
        place = 2 * sn * (k_slope + factor * cn * cn) / dn
        speed = 2 * self.w0 * cn * (k_slope - factor * sn * sn)
        along = m_slope * self.jacobi.kappa(u) / self.w0
        return Neighbour(place, speed, along, arb(1))

    def period(self) -> arb:
        """The time of a swing to and fro, 4 K(k^2)/w0 [s]."""
        return 4 * self.jacobi.k / self.w0


@dataclass(frozen=True)
class Revolution(PendulumMotion):
    """k > 1: theta/2 = sense am u, thetadot = 2 sense k w0 dn u, with u = k w0 t + shift.

    `sense` is the sign of thetadot, which it keeps. The parameter of Jacobi's functions is 1/k^2.
    """

    jacobi: Jacobi
    k: arb
    w0: arb
    sense: int
    shift: arb

    def state(self, t: arb) -> tuple[arb, arb]:
        u = self.k * self.w0 * t + self.shift
        # theta/2 = sense am u, thetadot = 2 sense k w0 dn u.
        half_angle = self.sense * self.jacobi.amplitude(u)
        dn = self.jacobi.sn_cn_dn(u)[2]
        return half_angle, 2 * self.sense * self.k * self.w0 * dn

    def neighbour(self, t: arb) -> Neighbour:
        """The derivative of (theta, thetadot) by H as P + K (theta', thetadot'), with dH/dH = 1.

        By m = 1/k^2 at fixed u, am changes as sn cn/(2 m1) + kappa am' and dn as -sn^2 dn/(2 m1) +
        kappa dn' (Jacobi.kappa). With (k^2)' = 1/(2 w0^2), k' = (k^2)'/(2 k), m' = -m^2 (k^2)':

            P_theta = sense m' sn cn/m1,    P_thetadot = 2 sense w0 dn (k' - k m' sn^2/(2 m1)),
            K = (k'/k) t + m' kappa/(k w0)    from u = k w0 t + u0.
        """
        rate = self.k * self.w0
        u = rate * t + self.shift
        sn, cn, dn = self.jacobi.sn_cn_dn(u)
        # (k^2)' = 1/(2 w0^2), k' = (k^2)'/(2 k), m' = -m^2 (k^2)'.
        k_square_slope = 1 / (2 * self.w0 * self.w0)
        k_slope = k_square_slope / (2 * self.k)
        m_slope = -k_square_slope * self.jacobi.m * self.jacobi.m
        factor = m_slope / (2 * self.jacobi.m1)
        place = 2 * self.sense * factor * sn * cn
        speed = 2 * self.sense * self.w0 * dn * (k_slope - self.k * factor * sn * sn)
        along = (k_slope / self.k) * t + m_slope * self.jacobi.kappa(u) / rate
        return Neighbour(place, speed, along, arb(1))

    def period(self) -> arb:
        """The time of a revolution, 2 K(1/k^2)/(k w0) [s]."""
        return 2 * self.jacobi.k / (self.k * self.w0)


@dataclass(frozen=True)
class Separatrix(PendulumMotion):
    """k = 1, through the bottom at t = 0: theta/2 = sense atan sinh(w0 t), thetadot = 2 sense w0
    sech(w0 t).
    """

    w0: arb
    sense: int

    def state(self, t: arb) -> tuple[arb, arb]:
        u = self.w0 * t
        return self.sense * u.sinh().atan(), 2 * self.sense * self.w0 / u.cosh()

    def period(self) -> None:
        """None: the motion on the separatrix is not periodic."""


@dataclass(frozen=True, kw_only=True)
class Pendulum(ClosedForm):
    """theta (continuous from theta0), thetadot, x, y and rod_force; the start is theta0 +
    half_turns pi, thetadot0.
    """

    method = (
        "closed form in Arb balls; Jacobi elliptic functions, by theta functions (tanh and sech on"
        " the separatrix)"
    )
    witness = WITNESS
    state = ("theta", "thetadot")
    proof_of_s = Sensitivity(CLOSED_BITS)

    mass: Fraction
    length: Fraction
    gravity: Fraction
    theta0: Fraction
    thetadot0: Fraction
    half_turns: int = 0

    displaced = displaced_fields("theta0", "thetadot0")
    jacobian = derivative_by_start

    @per_precision
    def start(self) -> tuple[int, arb, arb]:
        """The start as (turns, sin(phi/2), cos(phi/2)): its angle is 2 pi turns + phi.

        phi lies in [-pi, pi], so that the cosine is not negative. An odd half turn is pi/2 of the
        half angle a: it is taken with the sign that leads back into the range, sin(a -+ pi/2) = -+
        cos a and cos(a -+ pi/2) = +- sin a. Raises UndecidedError if balls do not decide on which
        side of the top that is.
        """
        turns = nearest_integer(arb_of(self.theta0) / (2 * arb.pi()))
        sine, cosine = (arb_of(self.theta0) / 2 - arb.pi() * turns).sin_cos()
        if self.half_turns % 2 == 0:
            return turns + self.half_turns // 2, sine, cosine
        if sine > 0:
            return turns + (self.half_turns + 1) // 2, -cosine, sine
        if sine < 0 or self.theta0 == 0:
            return turns + (self.half_turns - 1) // 2, cosine, -sine
        raise UndecidedError("side of the top")

    @per_precision
    def motion(self) -> PendulumMotion:
        """The motion, whose kind follows from k.

        Rest and the separatrix are equalities, which balls cannot decide: they follow from the
        exact start, at theta0 = 0, where its sine is rational. Raises UndecidedError where a ball
        of 1 - k^2 holds 0.
        """
        w0 = arb_of(self.gravity / self.length).sqrt()
        # thetadot0^2/(4 w0^2)
        kinetic = self.thetadot0**2 * self.length / (4 * self.gravity)
        if self.thetadot0 > 0:
            sense = 1
        else:
            sense = -1
        if self.theta0 == 0 and self.thetadot0 == 0:
            return Equilibrium(arb.pi() / 2 * (self.half_turns % 2))
        if self.theta0 == 0 and self.half_turns % 2 == 0 and kinetic == 1:
            return Separatrix(w0, sense)
        _, sine, cosine = self.start()
        # m = k^2 and m1 = 1 - k^2, each without the cancellation that 1 - m would have.
        m = sine * sine + arb_of(kinetic)
        m1 = cosine * cosine - arb_of(kinetic)
        if m1 > 0:
            jacobi = Jacobi(m, m1)
            k = m.sqrt()
            # At t = 0: sn u0 = sin(theta0/2)/k and cn u0 = thetadot0/(2 k w0).
            shift = jacobi.argument(sine / k, arb_of(self.thetadot0) / (2 * k * w0))
            return Swing(jacobi, k, w0, shift)
        if m1 < 0:
            # 1 - 1/k^2 = -(1 - k^2)/k^2.
            jacobi = Jacobi(1 / m, -m1 / m)
            # At t = 0: sn u0 = sense sin(theta0/2) and cn u0 = cos(theta0/2).
            return Revolution(jacobi, m.sqrt(), w0, sense, jacobi.argument(sense * sine, cosine))
        raise UndecidedError(f"swing or revolution: 1 - k^2 is {m1}")

    def evaluate(self, t: arb) -> dict[str, arb]:
        """theta, thetadot, x = l sin theta, y = -l cos theta, and the tension of the rod, m (l
        thetadot^2 + g cos theta).
        """
        half_angle, rate = self.motion().state(t)
        # The half angle of an equilibrium or the separatrix has the odd half turn in it already.
        if isinstance(self.motion(), Equilibrium | Separatrix):
            turns = self.half_turns // 2
        else:
            turns = self.start()[0]
        theta = 2 * (half_angle + arb.pi() * turns)
        sine, cosine = theta.sin_cos()
        length = arb_of(self.length)
        # m (l thetadot^2 + g cos theta).
        force = arb_of(self.mass) * (length * rate * rate + arb_of(self.gravity) * cosine)
        return {
            "theta": theta,
            "thetadot": rate,
            "x": length * sine,
            "y": -length * cosine,
            "rod_force": force,
        }

    def by_equation(self) -> ValidatedFlow:
        """The same quantities from the equation of motion, to the same digits."""
        return self.equation().refined(self.digits)

    def equation(self, quantities: Quantities | None = None) -> ValidatedFlow:
        """The same motion by its equation, with the same quantities or with others."""

        def field(y: Sequence[Any]) -> list[Any]:
            theta, rate = y
            # theta'' = -(g/l) sin theta.
            return [rate, theta.sin() * (-self.gravity / self.length)]

        def first() -> arb:
            return arb_of(self.theta0) + self.half_turns * arb.pi()

        return ValidatedFlow(
            field,
            [first, self.thetadot0],
            quantities or self.seen,
            self.scale,
            state=self.state,
            moved=(0, 1),
        )

    def seen(self, y: Sequence[Any]) -> dict[str, Any]:
        """The quantities of a state, by the operations of a traced field."""
        theta, rate = y
        sine = theta.sin()
        cosine = theta.cos()
        force = (rate * rate * self.length + cosine * self.gravity) * self.mass
        return {
            "theta": theta,
            "thetadot": rate,
            "x": sine * self.length,
            "y": cosine * -self.length,
            "rod_force": force,
        }

    def line(self) -> Line | None:
        """The motion and its neighbours in closed form; None on the separatrix and at rest."""
        motion = self.motion()
        if not isinstance(motion, Swing | Revolution):
            return None
        w0_square = arb_of(self.gravity / self.length)

        def state(t: arb) -> tuple[arb, arb]:
            half_angle, rate = motion.state(t)
            return 2 * half_angle, rate

        # |f'| = w0^2 |cos theta| is at most w0^2.
        return Line(
            state,
            lambda theta: -w0_square * theta.sin(),
            motion.neighbour,
            motion.period(),
            steepest=w0_square,
        )

    @per_precision
    def growth(self) -> Grows:
        """How errors of this motion grow, for S of its own quantities."""
        return self.growth_of(self.equation())

    def growth_of(self, equation: ValidatedFlow) -> Grows:
        """How errors of this motion grow, for S of the quantities that `equation` has.

        By neighbouring motions in closed form where there are any, else by the equation of motion.
        """
        line = self.line()
        if line is not None:
            return growth_along(line, self.scale, equation)
        return growth_of_an_equation(equation, self.motion().period())

    def constants(self) -> dict[str, arb]:
        period = self.motion().period()
        if period is None:
            return {}
        return {"period": period}


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass [kg], length [m], gravity [m/s^2], theta0 [rad], thetadot0
    [rad/s].

    `scale` has the size of each quantity against which its error counts.
    """
    exact = numbers(p, "mass", "length", "gravity", "theta0", "thetadot0")
    return Pendulum(refiner=Refiner.of(scale), half_turns=0, **exact)
