"""The free rigid body in its principal axes: Euler's equations and the turn from the start, by
closed form.

With M = J omega (body axes) and L = |M|, one body axis k that M never meets is followed about the
fixed M: its line of nodes turns by phi, phi' = L (2 E - M_k omega_k)/(L^2 - M_k^2). E and L are
kept, so phi is an integral of elliptic functions, which Jacobi's theta function gives without a
branch: exp(i phi) = exp(i nu t) Theta(u + i a)/|Theta(u + i a)| up to a constant. Jacobi (1850);
Whittaker, Analytical Dynamics, 69-71; van Zon and Schofield (2007).
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

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
"""Principal moments and omega that are not rational; what must be decided of them is then decided
by balls.
"""
AXES = (0, 1, 2)


class FreeBody(ABC):
    """One kind of motion at the current precision, from inertia J [kg m^2] and omega [rad/s] at t =
    0 in body axes.
    """

    method: ClassVar[str]

    def begin(self, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> None:
        """Sets what every kind of motion begins with."""
        pairs: list[tuple[Any, Any]] = list(zip(inertia, omega, strict=True))
        self.inertia = tuple(j for j, _ in pairs)
        self.start = tuple(w for _, w in pairs)
        self.momentum0 = tuple(j * w for j, w in pairs)
        self.l2 = dot_exact(self.momentum0, self.momentum0)
        self.length = arb_of(self.l2).sqrt()

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
        """Time [s/J] by which a motion with the same |M| and more energy is ahead at t, per energy,
        up to a constant.

        With M the momentum, w the unit vector of omega across M, W its length there and b that of M
        x omega, the motion that has more energy is displaced by w/W + k M', and k' = (w J^-1 w - b
        J^-1 b)/W^2 (refdem/truth/body_growth.py); this is k. UndecidedError where the body spins
        about its momentum, which has no such motion beside it.
        """


class Steady(FreeBody):
    """omega is parallel to M (or zero): it stays."""

    method = "steady spin: omega stays and the body turns about it"

    def __init__(self, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> None:
        self.begin(inertia, omega)

    def omega(self, t: arb) -> list[arb]:
        return [arb_of(w) for w in self.start]

    def turn(self, t: arb) -> list[arb]:
        omega = self.omega(t)
        size = arb_of(dot_exact(self.start, self.start)).sqrt()
        if size > 0:
            return turn([w / size for w in omega], size * t)
        return [arb(1), arb(0), arb(0), arb(0)]

    def fastest(self) -> arb:
        return length_of(self.start)

    def lead(self, t: arb) -> arb:
        raise UndecidedError(
            "a body that spins about its momentum has no motion beside it of more energy and the"
            " same momentum"
        )


class Axisymmetric(FreeBody):
    """Two equal moments J1: a turn about M at L/J1 after one about the third axis at omega_3 -
    M_3/J1.
    """

    method = "two equal moments: one turn about L after one about the body's own axis"

    def __init__(self, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> None:
        self.begin(inertia, omega)
        self.axis = next(k for k in AXES if inertia[(k + 1) % 3] == inertia[(k + 2) % 3])
        self.across = self.inertia[(self.axis + 1) % 3]
        self.rate = arb_of(self.start[self.axis] - self.momentum0[self.axis] / self.across)

    def omega(self, t: arb) -> list[arb]:
        back = matrix(turn(_unit(self.axis), -self.rate * t))
        return applied(back, [arb_of(w) for w in self.start])

    def turn(self, t: arb) -> list[arb]:
        along = [arb_of(m) / self.length for m in self.momentum0]
        return times(
            turn(along, self.length / arb_of(self.across) * t),
            turn(_unit(self.axis), self.rate * t),
        )

    def constants(self) -> dict[str, arb]:
        return {"period": 2 * arb.pi() / abs(self.rate), "elliptic_m": arb(0)}

    def fastest(self) -> arb:
        """The largest |omega| [rad/s], which stays."""
        return length_of(self.start)

    def lead(self, t: arb) -> arb:
        twice_energy = arb_of(dot_exact(self.momentum0, self.start))
        square = arb_of(dot_exact(self.start, self.start))
        return steady_lead(arb_of(self.inertia[self.axis]), twice_energy, self.length, square) * t


class Nodal(FreeBody):
    """Motions told by M and by the angle phi of the line of nodes of `axis`, which M never
    meets.
    """

    axis: int

    @abstractmethod
    def momentum(self, t: arb) -> list[arb]:
        """Angular momentum M (3) in body axes at time t."""

    @abstractmethod
    def nodes(self, t: arb) -> acb:
        """exp(i phi) at t; 1 at t = 0."""

    def omega(self, t: arb) -> list[arb]:
        return [m / arb_of(j) for m, j in zip(self.momentum(t), self.inertia, strict=True)]

    def turn(self, t: arb) -> list[arb]:
        phi = self.nodes(t)
        about = [
            [phi.real, -phi.imag, arb(0)],
            [phi.imag, phi.real, arb(0)],
            [arb(0), arb(0), arb(1)],
        ]
        return quaternion(product(transposed(self._frame(arb(0))), product(about, self._frame(t))))

    def _frame(self, t: arb) -> list[list[arb]]:
        """Rows: the axis across M, M x axis and M, unit vectors in body axes; no term cancels."""
        m = self.momentum(t)
        k = self.axis
        across = sum((m[i] * m[i] for i in AXES if i != k), arb(0)).sqrt()
        along = [x / self.length for x in m]
        first = [across / self.length if i == k else -along[k] * m[i] / across for i in AXES]
        return [first, cross(along, first), along]


class Separatrix(Nodal):
    """2 E J2 = L^2: M_2 = +-L tanh u, the others fall as sech u; about M the intermediate axis
    turns at L/J2.
    """

    method = "separatrix: tanh and sech, the line of nodes of axis 2 turns at L/J2"

    def __init__(self, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> None:
        self.begin(inertia, omega)
        low, self.axis, high = sorted(AXES, key=lambda i: self.inertia[i])
        rest2 = self.l2 - self.momentum0[self.axis] ** 2
        rest = arb_of(rest2).sqrt()
        self.shares = {i: arb_of(self.momentum0[i]) / rest for i in (low, high)}
        rate = _growth(self, low, high) * self.momentum0[low] * self.momentum0[high] / rest2
        self.rate = self.length * arb_of(rate)
        self.shift = (arb_of(self.momentum0[self.axis]) / rest).asinh()

    def momentum(self, t: arb) -> list[arb]:
        u = self.rate * t + self.shift
        fading = self.length / u.cosh()
        return [self.length * u.tanh() if i == self.axis else self.shares[i] * fading for i in AXES]

    def nodes(self, t: arb) -> acb:
        return (acb(0, 1) * self.length / arb_of(self.inertia[self.axis]) * t).exp()

    def constants(self) -> dict[str, arb]:
        return {"elliptic_m": arb(1)}

    def fastest(self) -> arb:
        """|omega|^2 = g_2^2 L^2 + (terms that fall as sech^2), g = 1/J: it is largest at u = 0."""
        squares = [
            (self.length * share / arb_of(self.inertia[i])) ** 2 for i, share in self.shares.items()
        ]
        middle = (self.length / arb_of(self.inertia[self.axis])) ** 2
        return (squares[0] + squares[1] + middle).sqrt()

    def lead(self, t: arb) -> arb:
        """Here b J^-1 b = g_2 and W = L v sech u with v^2 = (s_1 s_3 (g_1 - g_3))^2, so that k' =
        (g_1 + g_3 - 2 g_2)/(L v)^2 cosh^2 u.
        """
        low, high = self.shares
        g_low = 1 / arb_of(self.inertia[low])
        g_high = 1 / arb_of(self.inertia[high])
        g_mid = 1 / arb_of(self.inertia[self.axis])
        across = self.length * self.shares[low] * self.shares[high] * (g_low - g_high)
        u = self.rate * t + self.shift
        # The integral of cosh^2 u over t.
        integral = t / 2 + (2 * u).sinh() / (4 * self.rate)
        return (g_low + g_high - 2 * g_mid) / across**2 * integral


class Elliptic(Nodal):
    """M_a = A cn u, M_2 = +-B sn u, M_c = +-C dn u: c is the axis of largest or smallest J that M
    goes about.
    """

    method = "Jacobi elliptic functions for omega, Jacobi's theta function for the attitude"

    def __init__(self, inertia: Exact3 | Balls3, omega: Exact3 | Balls3) -> None:
        self.begin(inertia, omega)
        low, mid, high = sorted(AXES, key=lambda i: self.inertia[i])
        excess = self.l2 / self.inertia[mid] - dot_exact(self.momentum0, self.start)
        if not (excess > 0 or excess <= 0):
            raise UndecidedError(f"about which axis it turns: {excess}")
        self.other, self.axis = (low, high) if excess > 0 else (high, low)
        self.mid = mid
        ja, jb, jc = (1 / self.inertia[i] for i in (self.other, mid, self.axis))
        kept = dot_exact(self.momentum0, self.start) - self.l2 * jc
        self.a2 = kept / (ja - jc)
        self.b2 = kept / (jb - jc)
        self.c2 = self.l2 - self.a2
        self.m = (self.b2 - self.a2) / self.c2
        self.jacobi = Jacobi(arb_of(self.m), arb_of((self.l2 - self.b2) / self.c2))
        self.sizes = [arb_of(x).sqrt() for x in (self.a2, self.b2, self.c2)]
        if ja > jc:
            self.sense = 1
        else:
            self.sense = -1
        self._begin()

    def _begin(self) -> None:
        a, b, c = self.sizes
        growth = _growth(self, self.other, self.axis)
        if self.momentum0[self.axis] > 0:
            self.sign_c = 1
        else:
            self.sign_c = -1
        self.sign_b = self.sign_c * (1 if growth > 0 else -1)
        self.rate = a * c / b * arb_of(abs(growth))
        sn = self.sign_b * arb_of(self.momentum0[self.mid]) / b
        self.shift = self.jacobi.argument(sn, arb_of(self.momentum0[self.other]) / a)
        self.imaginary = c * carlson_f(arb_of(self.a2), arb_of(self.b2), arb_of(self.l2))
        zeta = self.jacobi.zeta_on_imaginary_axis(self.imaginary)
        self.drift = self.length / arb_of(self.inertia[self.other]) - self.sense * zeta * self.rate
        self.phase0 = self._phase(self.shift)

    def momentum(self, t: arb) -> list[arb]:
        sn, cn, dn = self.jacobi.sn_cn_dn(self.rate * t + self.shift)
        a, b, c = self.sizes
        m = {self.other: a * cn, self.mid: self.sign_b * b * sn, self.axis: self.sign_c * c * dn}
        return [m[i] for i in AXES]

    def nodes(self, t: arb) -> acb:
        return (
            (acb(0, 1) * self.drift * t).exp()
            * self._phase(self.rate * t + self.shift)
            / self.phase0
        )

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
        return {"period": 4 * self.jacobi.k / self.rate, "elliptic_m": self.jacobi.m}

    def fastest(self) -> arb:
        """|omega|^2 is linear in sn^2: it is largest where sn^2 is 0 or 1."""
        other, mid, axis = (arb_of(self.inertia[i]) for i in (self.other, self.mid, self.axis))
        without = arb_of(self.a2) / other**2 + arb_of(self.c2) / axis**2
        within = arb_of(self.b2) / mid**2 + arb_of(self.l2 - self.b2) / axis**2
        return arb.max(without, within).sqrt()

    def lead(self, t: arb) -> arb:
        """M(E, t) at fixed |M| is differentiated by E: dM/dE = p + K M', and k = K + p . M'/|M'|^2.

        How the functions change by the parameter m is told at Jacobi.kappa.
        """
        u = self.rate * t + self.shift
        sn, cn, dn = self.jacobi.sn_cn_dn(u)
        a, b, c = self.sizes
        a2, b2, c2 = (arb_of(square) for square in (self.a2, self.b2, self.c2))
        m = self.jacobi.m
        m1 = self.jacobi.m1
        g_other, g_mid, g_axis = (
            1 / arb_of(self.inertia[i]) for i in (self.other, self.mid, self.axis)
        )

        # Derivatives by the energy of the squared sizes, of m = (b2 - a2)/c2 and of ln rate, rate ~
        # a c/b.
        a2_slope = 2 / (g_other - g_axis)
        b2_slope = 2 / (g_mid - g_axis)
        c2_slope = -a2_slope
        m_slope = (b2_slope - a2_slope - m * c2_slope) / c2
        log_rate_slope = a2_slope / (2 * a2) + c2_slope / (2 * c2) - b2_slope / (2 * b2)

        # K: what moves all functions along the motion.
        along = log_rate_slope * t + m_slope * self.jacobi.kappa(u) / self.rate

        # p: what changes their sizes.
        swell = m_slope / (2 * m1)
        other = cn * (a2_slope / (2 * a) - a * swell * sn * sn)
        mid = self.sign_b * sn * (b2_slope / (2 * b) + b * swell * cn * cn)
        axis = self.sign_c * dn * (c2_slope / (2 * c) - c * swell * sn * sn)
        changed = {self.other: other, self.mid: mid, self.axis: axis}
        momentum = self.momentum(t)
        omega = [x / arb_of(j) for x, j in zip(momentum, self.inertia, strict=True)]
        rate = cross(momentum, omega)
        ahead: arb = dot_exact([changed[i] for i in AXES], rate) / dot_exact(rate, rate)
        return along + ahead


def length_of(omega: Sequence[Any]) -> arb:
    """The length |omega| [rad/s]."""
    return arb_of(dot_exact(omega, omega)).sqrt()


def steady_lead(along: arb, twice_energy: arb, length: arb, square: arb) -> arb:
    """The rate k' [1/J] of `lead` with two equal moments J1 and `along` = J3: there b J^-1 b =
    1/J1, W is constant, and w J^-1 w = 1/J1 + 1/J3 - 2 E/L^2, as the trace of J^-1 says; `square`
    is |omega|^2.
    """
    across = square - (twice_energy / length) ** 2
    return (1 / along - twice_energy / length**2) / across


Kind = type[Steady] | type[Axisymmetric] | type[Separatrix] | type[Elliptic]


def kind(inertia: Exact3, omega: Exact3) -> Kind:
    """The kind of motion, which the exact start decides."""
    m = [j * w for j, w in zip(inertia, omega, strict=True)]
    if all(m[i] * omega[j] == m[j] * omega[i] for i in AXES for j in AXES):
        return Steady
    if len(set(inertia)) < 3:
        return Axisymmetric
    if dot_exact(m, omega) * sorted(inertia)[1] == dot_exact(m, m):
        return Separatrix
    return Elliptic


def dot_exact(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The dot product a . b, which is exact if both are."""
    first, *rest = (x * y for x, y in zip(a, b, strict=True))
    return sum(rest, first)


def _growth(body: FreeBody, a: int, c: int) -> Any:
    """g in M_2' = g M_a M_c: (1/J_a - 1/J_c), with the other sign if (a, 2, c) is left-handed."""
    right_handed = (c - a) % 3 == 2
    difference = 1 / body.inertia[a] - 1 / body.inertia[c]
    if right_handed:
        return difference
    return -difference


def _unit(axis: int) -> list[arb]:
    return [arb(1 if i == axis else 0) for i in AXES]
