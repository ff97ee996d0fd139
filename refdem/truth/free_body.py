"""The free rigid body in its principal axes, by closed form: omega, and the turn from the start.

Theorem: with M = J omega (body axes), M' = M x omega, E and L = |M| are kept, and one of four
formulas gives M and the turn at all times (Jacobi 1850; Whittaker, Analytical Dynamics, 69-71; van
Zon and Schofield 2007). One body axis k that M never meets is followed about the fixed M: its line
of nodes turns by phi, phi' = L (2 E - M_k omega_k)/(L^2 - M_k^2).

Hypotheses, and where each is checked:

* steady, M parallel to omega; two equal moments; separatrix, 2 E J2 = L^2: each is decided of the
  exact start (`kind`), or of an exact tensor (rigid_cluster.py);
* every other start is elliptic: the axis that M circles is decided by balls (`Elliptic.axes`), and
  the parameter m lies in (0, 1) (Jacobi, jacobi.py); UndecidedError where balls do not decide it.

Formula: M by tanh and sech, or by cn, sn and dn. phi is an integral of elliptic functions, which
Jacobi's theta function gives without a choice of branch: up to a constant factor,

    exp(i phi) = exp(i nu t) Theta(u + i a)/|Theta(u + i a)|.

The turn of the body from 0 to t is F(0)^T Z(phi) F(t), with the turn Z(phi) about M and the frame F
of M and the line of nodes in body axes (`Nodal.turn`).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

from flint import acb, arb

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.jacobi import Jacobi, carlson_f
from refdem.truth.reals import Number
from refdem.truth.rotation import (
    applied,
    cross,
    matrix,
    product,
    quaternion,
    times,
    transposed,
    turn,
)

Exact3 = tuple[Number, Number, Number]
Balls3 = tuple[arb, arb, arb]
"""Principal moments and omega that are not rational: the kind of their motion is decided by balls.
"""
AXES = (0, 1, 2)


class FreeBody(ABC):
    """One kind of motion of a free rigid body, at the precision at which it was made."""

    method: ClassVar[str]

    @abstractmethod
    def omega(self, t: arb) -> list[arb]:
        """Angular velocity in body axes at t."""

    @abstractmethod
    def turn(self, t: arb) -> list[arb]:
        """The quaternion (either sign) of the turn from 0 to t: attitude(t) = attitude(0)
        turn(t).
        """

    def constants(self) -> dict[str, arb]:
        """Period of omega [s] and elliptic parameter, where there are any."""
        return {}

    def period(self) -> arb | None:
        """Time [s] after which omega repeats in body axes; None where it never does."""
        return self.constants().get("period")

    @abstractmethod
    def fastest(self) -> arb:
        """Bound of |omega| [rad/s] at all times."""

    @abstractmethod
    def lead(self, t: arb) -> arb:
        """The lead k [s/J] at t: the time by which a motion with the same |M| and more energy is
        ahead, per unit of energy, up to a constant.

        Let w be the unit vector along the part of omega perpendicular to M, W the length of that
        part, and b the unit vector along M x omega. A motion with dE more energy differs in M by
        (w/W + k M') dE, and k' = (w J^-1 w - b J^-1 b)/W^2 (refdem/truth/body_growth.py).
        UndecidedError where the body spins about its momentum: W is 0 there.
        """


@dataclass(frozen=True)
class Principal:
    """The start of a free body in its principal axes, and the constants of its motion.

    `inertia` J [kg m^2] and `omega` [rad/s] are those at t = 0, `momentum` is M = J omega there,
    `l2` is L^2, exact if the start is, and `length` is L.
    """

    inertia: tuple[Any, ...]
    omega: tuple[Any, ...]
    momentum: tuple[Any, ...]
    l2: Any
    length: arb

    @classmethod
    def of(cls, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> Self:
        """The start with these principal moments and this omega, at the current precision."""
        # M = J omega, L^2 = M . M.
        pairs: Iterable[tuple[Any, Any]] = zip(inertia, omega, strict=True)
        momentum = tuple(j * w for j, w in pairs)
        l2 = dot_exact(momentum, momentum)
        return cls(tuple(inertia), tuple(omega), momentum, l2, arb_of(l2).sqrt())

    def twice_energy(self) -> Any:
        """2 E = M . omega [J], exact if the start is."""
        return dot_exact(self.momentum, self.omega)


@dataclass(frozen=True)
class Steady(FreeBody):
    """A steady spin: omega is parallel to M, or zero, and is constant."""

    method = "steady spin: omega stays and the body turns about it"

    start: Principal

    def omega(self, t: arb) -> list[arb]:
        """The constant omega (3) [rad/s] in body axes."""
        return [arb_of(w) for w in self.start.omega]

    def turn(self, t: arb) -> list[arb]:
        """The quaternion of the turn by |omega| t about omega; 1 if the body rests."""
        omega = self.omega(t)
        rate = length_of(self.start.omega)
        if rate > 0:
            return turn([w / rate for w in omega], rate * t)
        return [arb(1), arb(0), arb(0), arb(0)]

    def fastest(self) -> arb:
        """The constant |omega| [rad/s]."""
        return length_of(self.start.omega)

    def lead(self, t: arb) -> arb:
        """Raises UndecidedError: a steady spin has no lead."""
        raise UndecidedError(
            "a body that spins about its momentum has no motion beside it of more energy and the"
            " same momentum"
        )


@dataclass(frozen=True)
class Axisymmetric(FreeBody):
    """Two equal moments J1: in body axes omega turns about the third axis at the constant rate
    omega_3 - M_3/J1 backwards.

    The attitude is a turn about the fixed M at the rate L/J1, after one about the body's third axis
    at omega_3 - M_3/J1.
    """

    method = "two equal moments: one turn about L after one about the body's own axis"

    start: Principal

    @cached_property
    def axis(self) -> int:
        """The body's own axis: that which is not of the two equal moments."""
        inertia = self.start.inertia
        return next(k for k in AXES if inertia[(k + 1) % 3] == inertia[(k + 2) % 3])

    @property
    def across(self) -> Any:
        """The two equal moments J1 [kg m^2]."""
        return self.start.inertia[(self.axis + 1) % 3]

    @cached_property
    def rate(self) -> arb:
        """The rate omega_3 - M_3/J1 [rad/s] about the own axis."""
        start = self.start
        return arb_of(start.omega[self.axis] - start.momentum[self.axis] / self.across)

    def omega(self, t: arb) -> list[arb]:
        """omega (3) [rad/s] at t: that of the start, turned about the body's own axis by -rate
        t.
        """
        # omega(t) = R(-rate t) omega(0), about the own axis.
        backwards = matrix(turn(_unit(self.axis), -self.rate * t))
        return applied(backwards, [arb_of(w) for w in self.start.omega])

    def turn(self, t: arb) -> list[arb]:
        """The quaternion of the turn about M by L t/J1, after that about the own axis by rate t."""
        length = self.start.length
        momentum_axis = [arb_of(m) / length for m in self.start.momentum]
        about_momentum = turn(momentum_axis, length / arb_of(self.across) * t)
        about_own_axis = turn(_unit(self.axis), self.rate * t)
        return times(about_momentum, about_own_axis)

    def constants(self) -> dict[str, arb]:
        """The period 2 pi/|rate| of omega in body axes, and the elliptic parameter 0."""
        return {"period": 2 * arb.pi() / abs(self.rate), "elliptic_m": arb(0)}

    def fastest(self) -> arb:
        """The constant |omega| [rad/s]."""
        return length_of(self.start.omega)

    def lead(self, t: arb) -> arb:
        """The lead k = k' t with the constant k' of `steady_lead`."""
        start = self.start
        own_moment = arb_of(start.inertia[self.axis])
        twice_energy = arb_of(start.twice_energy())
        square = arb_of(dot_exact(start.omega, start.omega))
        return steady_lead(own_moment, twice_energy, start.length, square) * t


@dataclass(frozen=True)
class Nodal(FreeBody):
    """Motions that are given by M in body axes and by the angle phi of the line of nodes.

    The line of nodes is that of the body axis `axis`, which M never meets: it turns about M by phi.
    """

    start: Principal

    @property
    @abstractmethod
    def axis(self) -> int:
        """The body axis that M never meets."""

    @abstractmethod
    def momentum(self, t: arb) -> list[arb]:
        """Angular momentum M (3) in body axes at time t."""

    @abstractmethod
    def nodes(self, t: arb) -> acb:
        """exp(i phi) at t; 1 at t = 0."""

    def omega(self, t: arb) -> list[arb]:
        """omega_i = M_i/J_i (3) [rad/s] in body axes at t."""
        moments = self.start.inertia
        return [m / arb_of(j) for m, j in zip(self.momentum(t), moments, strict=True)]

    def turn(self, t: arb) -> list[arb]:
        """The quaternion of R = F(0)^T Z(phi) F(t), with F of `_frame` and Z a turn about M.

        F(t) takes body axes at t to axes about M and the line of nodes, which has turned by phi;
        F(0)^T takes those at 0 to body axes at 0.
        """
        phi = self.nodes(t)
        # Z(phi), a turn about the third axis, which is along M.
        turn_about_momentum = [
            [phi.real, -phi.imag, arb(0)],
            [phi.imag, phi.real, arb(0)],
            [arb(0), arb(0), arb(1)],
        ]
        from_frame = transposed(self._frame(arb(0)))
        return quaternion(product(from_frame, product(turn_about_momentum, self._frame(t))))

    def _frame(self, t: arb) -> list[list[arb]]:
        """Three unit vectors in body axes at t, as rows: the part of e_k across M, M x e_k, and M.

        e_k is the body axis `axis`. With m = M/L, e_k - (e_k.m) m has the length A/L, A^2 being the
        sum of M_i^2 over i != k; its components over that length are A/L for k and -m_k M_i/A for
        the others. So no term cancels.
        """
        momentum = self.momentum(t)
        k = self.axis
        across = sum((momentum[i] * momentum[i] for i in AXES if i != k), arb(0)).sqrt()
        length = self.start.length
        along = [x / length for x in momentum]
        # (e_k - (e_k . m) m) L/A: -m_k M_i/A for i != k, and A/L for k.
        first = [-along[k] * momentum[i] / across for i in AXES]
        first[k] = across / length
        return [first, cross(along, first), along]


@dataclass(frozen=True)
class Separatrix(Nodal):
    """The separatrix 2 E J2 = L^2: M_2 = L tanh u, M_i = s_i L sech u for the other two axes, u =
    rate t + shift.

    About M the line of nodes of the intermediate axis turns at L/J2.
    """

    method = "separatrix: tanh and sech, the line of nodes of axis 2 turns at L/J2"

    @cached_property
    def order(self) -> list[int]:
        """The axes of the smallest, the intermediate and the largest moment."""
        return rising(self.start.inertia)

    @property
    def axis(self) -> int:
        """The axis of the intermediate moment."""
        return self.order[1]

    @cached_property
    def across2(self) -> Any:
        """M_1^2 + M_3^2 = L^2 sech^2 u at the start."""
        return self.start.l2 - self.start.momentum[self.axis] ** 2

    @cached_property
    def shares(self) -> dict[int, arb]:
        """s_i = M_i/(L sech u) of the other two axes, with s_1^2 + s_3^2 = 1."""
        low, _, high = self.order
        across = arb_of(self.across2).sqrt()
        return {i: arb_of(self.start.momentum[i]) / across for i in (low, high)}

    @cached_property
    def rate(self) -> arb:
        """The rate u' [1/s], which is constant."""
        low, _, high = self.order
        start = self.start
        # L u' sech^2 u = M_2' = g M_1 M_3 = g s_1 s_3 L^2 sech^2 u: u' = L g s_1 s_3.
        growth = growth_along_middle(start.inertia, low, high)
        rate = growth * start.momentum[low] * start.momentum[high] / self.across2
        return start.length * arb_of(rate)

    @cached_property
    def shift(self) -> arb:
        """The argument u at the start."""
        # sinh u = M_2/(L sech u).
        across = arb_of(self.across2).sqrt()
        return (arb_of(self.start.momentum[self.axis]) / across).asinh()

    def momentum(self, t: arb) -> list[arb]:
        """M (3) at t: L tanh u along the intermediate axis, s_i L sech u along the others."""
        u = self.rate * t + self.shift
        across = self.start.length / u.cosh()
        momentum = {i: share * across for i, share in self.shares.items()}
        momentum[self.axis] = self.start.length * u.tanh()
        return [momentum[i] for i in AXES]

    def nodes(self, t: arb) -> acb:
        """exp(i L t/J2): the line of nodes of the intermediate axis turns uniformly."""
        return (acb(0, 1) * self.start.length / arb_of(self.start.inertia[self.axis]) * t).exp()

    def constants(self) -> dict[str, arb]:
        """The elliptic parameter 1; a separatrix has no period."""
        return {"elliptic_m": arb(1)}

    def fastest(self) -> arb:
        """The largest |omega|: |omega|^2 = sum of g_i^2 M_i^2, g = 1/J, bounded by its terms at
        their largest.
        """
        length = self.start.length
        moments = self.start.inertia
        squares = [(length * share / arb_of(moments[i])) ** 2 for i, share in self.shares.items()]
        middle = (length / arb_of(moments[self.axis])) ** 2
        return (squares[0] + squares[1] + middle).sqrt()

    def lead(self, t: arb) -> arb:
        """The lead k with k' = (g_1 + g_3 - 2 g_2)/(L v)^2 cosh^2 u, v = s_1 s_3 (g_1 - g_3).

        Here b J^-1 b = g_2, w J^-1 w = g_1 + g_3 - g_2 (the trace, as m J^-1 m = 2 E/L^2 = g_2),
        and W = L |v| sech u.
        """
        low, _, high = self.order
        g_low, g_mid, g_high = (1 / arb_of(self.start.inertia[i]) for i in self.order)
        across = self.start.length * self.shares[low] * self.shares[high] * (g_low - g_high)
        u = self.rate * t + self.shift
        # The integral of cosh^2 u over t.
        integral = t / 2 + (2 * u).sinh() / (4 * self.rate)
        return (g_low + g_high - 2 * g_mid) / across**2 * integral


@dataclass(frozen=True)
class Elliptic(Nodal):
    """M_a = A cn u, M_2 = +-B sn u, M_c = +-C dn u with u = rate t + shift.

    c (`axis`) is the axis of largest or smallest J, whichever M goes about; a (`other`) is the
    other one of both, 2 (`mid`) the axis of the intermediate J. All numbers are computed when the
    record is made.
    """

    method = "Jacobi elliptic functions for omega, Jacobi's theta function for the attitude"

    def __post_init__(self) -> None:
        """Raises UndecidedError if balls do not decide about which axis the body rotates."""
        # Every other number is a step towards these two.
        for name in ("drift", "phase0"):
            getattr(self, name)

    @cached_property
    def axes(self) -> tuple[int, int, int]:
        """The axes a, 2 and c: c has the largest J if L^2 > 2 E J_2, else the smallest.

        UndecidedError where balls do not decide that.
        """
        low, mid, high = rising(self.start.inertia)
        excess = self.start.l2 / self.start.inertia[mid] - self.start.twice_energy()
        if not (excess > 0 or excess <= 0):
            raise UndecidedError(f"about which axis it turns: {excess}")
        if excess > 0:
            return low, mid, high
        return high, mid, low

    @property
    def other(self) -> int:
        """a, the one of the axes of largest and smallest J that M does not go about."""
        return self.axes[0]

    @property
    def mid(self) -> int:
        """2, the axis of the intermediate J."""
        return self.axes[1]

    @property
    def axis(self) -> int:
        """c, the axis that M goes about."""
        return self.axes[2]

    @cached_property
    def squares(self) -> tuple[Any, Any, Any]:
        """The squares A^2, B^2 and C^2, exact if the start is."""
        g_other, g_mid, g_axis = (1 / self.start.inertia[i] for i in self.axes)
        # 2 E - L^2 g_c = M_a^2 (g_a - g_c) + M_2^2 (g_2 - g_c), with g = 1/J, is conserved: A^2 is
        # M_a^2 where M_2 = 0, and B^2 is M_2^2 where M_a = 0.
        conserved = self.start.twice_energy() - self.start.l2 * g_axis
        a2 = conserved / (g_other - g_axis)
        b2 = conserved / (g_mid - g_axis)
        return a2, b2, self.start.l2 - a2

    @cached_property
    def sizes(self) -> list[arb]:
        """The sizes A, B and C [kg m^2/s]."""
        return [arb_of(square).sqrt() for square in self.squares]

    @cached_property
    def jacobi(self) -> Jacobi:
        """The elliptic functions of the parameter m."""
        a2, b2, c2 = self.squares
        # dn^2 = 1 - m sn^2: C^2 m = B^2 - A^2, as A^2 cn^2 + B^2 sn^2 + C^2 dn^2 = L^2.
        return Jacobi(arb_of((b2 - a2) / c2), arb_of((self.start.l2 - b2) / c2))

    @cached_property
    def sense(self) -> int:
        """1 if J_a < J_c, else -1."""
        g_other, _, g_axis = (1 / self.start.inertia[i] for i in self.axes)
        if g_other > g_axis:
            return 1
        return -1

    @cached_property
    def growth_along_middle(self) -> Any:
        """The factor g in M_2' = g M_a M_c."""
        return growth_along_middle(self.start.inertia, self.other, self.axis)

    @cached_property
    def sign_c(self) -> int:
        """The sign of M_c, which stays."""
        if self.start.momentum[self.axis] > 0:
            return 1
        return -1

    @cached_property
    def sign_b(self) -> int:
        """The sign of M_2 for sn u > 0: with u' > 0 that of g M_c."""
        if self.growth_along_middle > 0:
            return self.sign_c
        return -self.sign_c

    @cached_property
    def rate(self) -> arb:
        """The rate u' [1/s], which is constant."""
        a, b, c = self.sizes
        # B sn' = B u' cn dn = |g| A C cn dn.
        return a * c / b * arb_of(abs(self.growth_along_middle))

    @cached_property
    def shift(self) -> arb:
        """The argument u at the start, which gives the momentum there."""
        a, b, _ = self.sizes
        sn = self.sign_b * arb_of(self.start.momentum[self.mid]) / b
        cn = arb_of(self.start.momentum[self.other]) / a
        return self.jacobi.argument(sn, cn)

    @cached_property
    def imaginary(self) -> arb:
        """a of Theta(u + i a), with sn(i a) = i C/A."""
        _, _, c = self.sizes
        a2, b2, _ = self.squares
        # cs = A/C, ds = B/C, ns = L/C are those of a with parameter 1 - m, and a = R_F(cs^2, ds^2,
        # ns^2) (DLMF 19.25).
        return c * carlson_f(arb_of(a2), arb_of(b2), arb_of(self.start.l2))

    @cached_property
    def drift(self) -> arb:
        """nu = L/J_a -+ z u' [rad/s] of the module's formula, with Z(i a) = i z."""
        zeta = self.jacobi.zeta_on_imaginary_axis(self.imaginary)
        # nu = L/J_a - sense z u'
        uniform = self.start.length / arb_of(self.start.inertia[self.other])
        return uniform - self.sense * zeta * self.rate

    @cached_property
    def phase0(self) -> acb:
        """Theta(u + i a)/|Theta(u + i a)| at t = 0."""
        return self._phase(self.shift)

    def momentum(self, t: arb) -> list[arb]:
        """M (3) at t: A cn u, +-B sn u and +-C dn u along the axes a, 2 and c."""
        sn, cn, dn = self.jacobi.sn_cn_dn(self.rate * t + self.shift)
        a, b, c = self.sizes
        momentum = {
            self.other: a * cn,
            self.mid: self.sign_b * b * sn,
            self.axis: self.sign_c * c * dn,
        }
        return [momentum[i] for i in AXES]

    def nodes(self, t: arb) -> acb:
        """exp(i phi) = exp(i nu t) Theta(u + i a)/|Theta(u + i a)|, divided by its value at 0."""
        uniform = (acb(0, 1) * self.drift * t).exp()
        return uniform * self._phase(self.rate * t + self.shift) / self.phase0

    def _phase(self, u: arb) -> acb:
        """Theta(u + i a)/|Theta(u + i a)|, or its conjugate where M goes about the axis of smallest
        J.
        """
        theta = self.jacobi.theta4(u, self.imaginary)
        unit = theta / abs(theta).real
        if self.sense > 0:
            return unit
        return unit.conjugate()

    def constants(self) -> dict[str, arb]:
        """The period 4 K/rate of omega, and the elliptic parameter m."""
        return {"period": 4 * self.jacobi.k / self.rate, "elliptic_m": self.jacobi.m}

    def fastest(self) -> arb:
        """The largest |omega|: |omega|^2 is linear in sn^2, and so largest where sn^2 is 0 or 1."""
        other, mid, axis = (arb_of(self.start.inertia[i]) for i in self.axes)
        a2, b2, c2 = self.squares
        # |omega|^2 = M_a^2/J_a^2 + M_2^2/J_2^2 + M_c^2/J_c^2, at (sn, cn) = (0, 1) and (1, 0).
        square_at_sn_0 = arb_of(a2) / other**2 + arb_of(c2) / axis**2
        square_at_sn_1 = arb_of(b2) / mid**2 + arb_of(self.start.l2 - b2) / axis**2
        return arb.max(square_at_sn_0, square_at_sn_1).sqrt()

    def lead(self, t: arb) -> arb:
        """The lead k [s/J], from the derivative of M(E, t) by E at fixed |M|.

        dM/dE = p + K M', and k = K + p . M'/|M'|^2. The derivatives of the elliptic functions by
        their parameter m are those given at Jacobi.kappa.
        """
        u = self.rate * t + self.shift
        sn, cn, dn = self.jacobi.sn_cn_dn(u)
        a, b, c = self.sizes
        a2, b2, c2 = (arb_of(square) for square in self.squares)
        m = self.jacobi.m
        m1 = self.jacobi.m1
        g_other, g_mid, g_axis = (1 / arb_of(self.start.inertia[i]) for i in self.axes)

        # Derivatives by the energy E of the squared sizes, A^2 = (2 E - L^2 g_c)/(g_a - g_c), B^2 =
        # (2 E - L^2 g_c)/(g_2 - g_c), C^2 = L^2 - A^2; of m = (B^2 - A^2)/C^2; and of the logarithm
        # of the rate, which is proportional to A C/B.
        a2_slope = 2 / (g_other - g_axis)
        b2_slope = 2 / (g_mid - g_axis)
        c2_slope = -a2_slope
        m_slope = (b2_slope - a2_slope - m * c2_slope) / c2
        log_rate_slope = a2_slope / (2 * a2) + c2_slope / (2 * c2) - b2_slope / (2 * b2)

        # K: the shift in time along the motion, (ln rate)' t by the argument u = rate t + shift,
        # and m' kappa(u)/rate by the parameter of the functions, up to a constant.
        along = log_rate_slope * t + m_slope * self.jacobi.kappa(u) / self.rate

        # p: the change of the sizes, A' = (A^2)'/(2 A), and of cn, sn, dn by m at fixed argument,
        # dcn/dm = -sn^2 cn/(2 m1), dsn/dm = sn cn^2/(2 m1), ddn/dm = -sn^2 dn/(2 m1).
        by_m = m_slope / (2 * m1)
        p_other = cn * (a2_slope / (2 * a) - a * by_m * sn * sn)
        p_mid = self.sign_b * sn * (b2_slope / (2 * b) + b * by_m * cn * cn)
        p_axis = self.sign_c * dn * (c2_slope / (2 * c) - c * by_m * sn * sn)
        p = {self.other: p_other, self.mid: p_mid, self.axis: p_axis}

        # M' = M x omega.
        momentum = self.momentum(t)
        omega = [x / arb_of(j) for x, j in zip(momentum, self.start.inertia, strict=True)]
        rate = cross(momentum, omega)
        ahead: arb = dot_exact([p[i] for i in AXES], rate) / dot_exact(rate, rate)
        return along + ahead


def length_of(omega: Sequence[Any]) -> arb:
    """The length |omega| [rad/s]."""
    return arb_of(dot_exact(omega, omega)).sqrt()


def steady_lead(along: arb, twice_energy: arb, length: arb, square: arb) -> arb:
    """The constant rate k' [1/J] of `lead` with two equal moments J1.

    `along` is the third moment J3, `twice_energy` 2 E, `length` L, `square` |omega|^2. In k' = (w
    J^-1 w - b J^-1 b)/W^2 of `lead` b J^-1 b = 1/J1, and w J^-1 w = 1/J1 + 1/J3 - 2 E/L^2, as the
    trace of J^-1 is 2/J1 + 1/J3 and m J^-1 m = 2 E/L^2.
    """
    # W^2 = |omega|^2 - (omega.m)^2.
    across_squared = square - (twice_energy / length) ** 2
    return (1 / along - twice_energy / length**2) / across_squared


Kind = type[Steady] | type[Axisymmetric] | type[Separatrix] | type[Elliptic]


def kind(inertia: Exact3, omega: Exact3) -> Kind:
    """The kind of motion, which follows from the exact initial state."""
    momentum = [j * w for j, w in zip(inertia, omega, strict=True)]
    is_parallel = all(momentum[i] * omega[j] == momentum[j] * omega[i] for i in AXES for j in AXES)
    if is_parallel:
        return Steady
    if len(set(inertia)) < 3:
        return Axisymmetric
    # 2 E J2 = L^2.
    if dot_exact(momentum, omega) * sorted(inertia)[1] == dot_exact(momentum, momentum):
        return Separatrix
    return Elliptic


def dot_exact(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The dot product a . b, which is exact if both are."""
    # The sum begins with a product, not with 0, so that its type is that of the products.
    first, *others = (x * y for x, y in zip(a, b, strict=True))
    return sum(others, first)


def rising(moments: Sequence[Any]) -> list[int]:
    """The axes in rising order of their principal moments."""
    return sorted(AXES, key=lambda i: moments[i])


def growth_along_middle(moments: Sequence[Any], a: int, c: int) -> Any:
    """g in M_2' = g M_a M_c: (1/J_a - 1/J_c), with the other sign if (a, 2, c) is left-handed."""
    right_handed = (c - a) % 3 == 2
    difference = 1 / moments[a] - 1 / moments[c]
    if right_handed:
        return difference
    return -difference


def _unit(axis: int) -> list[arb]:
    """The unit vector of a coordinate axis."""
    return [arb(int(i == axis)) for i in AXES]
