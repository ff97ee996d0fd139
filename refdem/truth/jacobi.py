"""Jacobi's elliptic functions by theta functions, as balls: sn, cn, dn, the amplitude and F, from m
and 1 - m both given.

theta_i(v, tau) with v = u/(2K), tau = i K'/K (DLMF 20.2, 22.2); K and K' are the complete integrals
of m and of 1 - m. Theta is Jacobi's, theta_4, and Z = Theta'/Theta his zeta function. 1 - m is a
separate argument: near a separatrix it must not be lost by cancellation.
"""

from flint import acb, arb

from refdem.truth.balls import UndecidedError, nearest_integer


class Jacobi:
    """The elliptic functions of parameter m = k^2 in (0, 1).

    `m1` is 1 - m, `k` is K, `k1` is K' and `tau` the half-period ratio. UndecidedError if the balls
    do not lie in (0, 1).
    """

    def __init__(self, m: arb, m1: arb) -> None:
        if not (m > 0 and m1 > 0):
            raise UndecidedError(
                f"elliptic parameter {m} with complement {m1} is not inside (0, 1)"
            )
        self.m = m
        self.m1 = m1
        # K = pi/(2 agm(1, sqrt(1 - m))) (DLMF 19.8.5), K' the same of 1 - m.
        half_pi = arb.pi() / 2
        self.k = half_pi / arb(1).agm(m1.sqrt())
        self.k1 = half_pi / arb(1).agm(m.sqrt())
        self.tau = acb(0, self.k1 / self.k)
        _, theta2, theta3, theta4 = (x.real for x in acb.modular_theta(acb(0), self.tau))
        # The factors of DLMF 22.2.4 to 22.2.6.
        self._sn = theta3 / theta2
        self._cn = theta4 / theta2
        self._dn = theta4 / theta3

    def complete_e(self) -> arb:
        """Legendre's complete integral E = 2 R_G(0, 1 - m, 1) (DLMF 19.25.1)."""
        return 2 * acb.elliptic_rg(acb(0), acb(self.m1), acb(1)).real

    def epsilon(self, u: arb) -> arb:
        """Jacobi's epsilon function, the integral of dn^2 from 0 to u: Z(u) + (E/K) u, Z =
        Theta'/Theta (DLMF 22.16.32).
        """
        # Z has the period 2K: an argument near 0 keeps the theta series short.
        half_turns = nearest_integer(u / (2 * self.k))
        v = acb((u - 2 * self.k * half_turns) / (2 * self.k))
        slope = acb.modular_theta(v, self.tau, 1)[3].real
        value = acb.modular_theta(v, self.tau)[3].real
        # E(u) = Z(u) + (E/K) u, Z = Theta'/Theta, and dv/du = 1/(2K).
        return slope / value / (2 * self.k) + self.complete_e() / self.k * u

    def sn_cn_dn(self, u: arb) -> tuple[arb, arb, arb]:
        """Jacobi's elliptic functions sn u, cn u and dn u (DLMF 22.2.4 to 22.2.6)."""
        # They have the period 4K.
        u = u - 4 * self.k * nearest_integer(u / (4 * self.k))
        one, two, three, four = (x.real for x in acb.modular_theta(acb(u / (2 * self.k)), self.tau))
        return self._sn * one / four, self._cn * two / four, self._dn * three / four

    def kappa(self, u: arb) -> arb:
        """kappa = (u/m - E(u)/(m m1))/2, which is in all derivatives of the functions by m, E(u)
        being `epsilon`.

        At fixed u, ' being the derivative by u (Byrd and Friedman 710.51 to 710.53):

            d sn/dm =  sn cn^2/(2 m1) + kappa sn'      d dn/dm = -sn^2 dn/(2 m1) + kappa dn'
            d cn/dm = -sn^2 cn/(2 m1) + kappa cn'      d am/dm =  sn cn/(2 m1) + kappa am'
        """
        return (u / self.m - self.epsilon(u) / (self.m * self.m1)) / 2

    def amplitude(self, u: arb) -> arb:
        """The amplitude am u, which is continuous: d am/du = dn u, am 0 = 0, am(u + 2K) = am u +
        pi.
        """
        half_turns = nearest_integer(u / (2 * self.k))
        sn, cn, _ = self.sn_cn_dn(u - 2 * self.k * half_turns)
        return arb.atan2(sn, cn) + arb.pi() * half_turns

    def argument(self, sn: arb, cn: arb) -> arb:
        """The u in [-2K, 2K] with these sn and cn: F(am u, m), by Carlson's R_F (DLMF 19.25.5).

        UndecidedError where the sign of cn, which chooses the branch, is not known.
        """
        # u = sn R_F(cn^2, dn^2, 1), dn^2 = cn^2 + (1 - m) sn^2, for |u| <= K.
        cn2 = cn * cn
        u = sn * carlson_f(cn2, cn2 + self.m1 * sn * sn, arb(1))
        if cn >= 0:
            return u
        if not cn < 0:
            raise UndecidedError("sign of cn")
        # Beyond K: sn(2K - u) = sn u, cn(2K - u) = -cn u, and the same with -2K.
        if sn >= 0:
            return 2 * self.k - u
        return -2 * self.k - u

    def theta4(self, u: arb, imaginary: arb) -> acb:
        """Jacobi's Theta(u + i a) = theta_4 at (u + i a)/(2K)."""
        u = u - 4 * self.k * nearest_integer(u / (4 * self.k))
        return acb.modular_theta(acb(u, imaginary) / (2 * self.k), self.tau)[3]

    def zeta_on_imaginary_axis(self, imaginary: arb) -> arb:
        """The real z with Z(i a) = i z, a being `imaginary` and Z = Theta'/Theta Jacobi's zeta
        function (DLMF 22.16.32).
        """
        v = acb(0, imaginary / (2 * self.k))
        ratio = acb.modular_theta(v, self.tau, 1)[3] / acb.modular_theta(v, self.tau)[3]
        return ratio.imag / (2 * self.k)


def carlson_f(x: arb, y: arb, z: arb) -> arb:
    """Carlson's R_F(x, y, z) for x, y, z >= 0, at most one of them 0."""
    return acb.elliptic_rf(acb(x), acb(y), acb(z)).real
