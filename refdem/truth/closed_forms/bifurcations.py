"""Folds of harmonic balance (1.120), (1.121) and doublings of the logistic map (1.127), as roots of
polynomials with rational coefficients.

Folds. With S = A^2, h = 3 beta/4, q = w^2 and u = alpha + h S - q the balance (1.120) is F = S (u^2
+ 4 delta^2 q) - f0^2 = 0. Where dq/dS = 0 on it, dF/dS = u^2 + 4 delta^2 q + 2 h S u = 0, so that
u = -f0^2/(2 h S^2), q = alpha + h S + f0^2/(2 h S^2), and

    16 delta^2 h^3 S^5 + 16 delta^2 h^2 alpha S^4 - 4 h^2 f0^2 S^3 + 8 delta^2 h f0^2 S^2 + f0^4
    = 0.

For h > 0 its coefficients change sign twice: it has two positive roots or none (Descartes). For h <
0 they change sign three times. The branches w^2 = k - 2 delta^2 -+ sqrt(D), k = alpha + h S, meet
where D = f0^2/S - 4 delta^2 (k - delta^2) vanishes; if it does, the smaller solution S_t is the tip
of the resonance, and the folds of the resonance are the roots below S_t. The third root lies beyond
the larger solution, where amplitudes reach the barrier at k = 0.

Doublings. w = eta (1/2 - x) has the map w -> w^2 + c, with c = eta/2 - eta^2/4, v = 4 c = 1 - (eta
- 1)^2. The cycle of one iterate has the multiplier -1 at v = -3, that of two at v = -5. The
resultant of the polynomial of cycles of four and of their multiplier plus 1 is a power of

    v^6 + 12 v^5 + 47 v^4 + 188 v^3 + 527 v^2 + 4913,

whose two real roots are v = -5.47 and v = -7.77, the latter far beyond the limit of the doublings,
at eta = 3.96. The cycle of four that is born at v = -5 has the multiplier 1 there, and it keeps a
multiplier above -1 up to the first root. That it is -1 there, and not +1 elsewhere, the witness
shows by its sign on both sides.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import cast

from flint import acb, arb, fmpq, fmpq_poly

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_forms.quaternions import listed
from refdem.truth.dual import carried, plain
from refdem.truth.exact import numbers
from refdem.truth.refiner import Refiner
from refdem.truth.timeless import Timeless

DOUBLING_OF_4 = fmpq_poly([4913, 0, 527, 188, 47, 12, 1])
"""The polynomial in v = 4 c of the doubling of the cycle of four, lowest power first."""


def real_roots(polynomial: fmpq_poly) -> list[arb]:
    """The real roots, the smallest first, each in a ball of its own."""
    roots: list[arb] = []
    for root, _ in cast("list[tuple[acb, int]]", polynomial.complex_roots()):
        if root.imag == 0:
            roots.append(root.real)
        elif root.imag.contains(0):
            raise UndecidedError("a root that may be real")
    return sorted(roots, key=lambda root: float(root.mid()))


def fold_squares(p: Parameters) -> tuple[arb, arb]:
    """The squares S of the amplitudes at the lower and the upper fold."""
    # 16 delta^2 h^3 S^5 + 16 delta^2 h^2 alpha S^4 - 4 h^2 f0^2 S^3 + 8 delta^2 h f0^2 S^2
    #     + f0^4 = 0
    values = numbers(p, "alpha", "beta", "delta", "f0")
    h = values["beta"] * Fraction(3, 4)
    force = values["f0"] * values["f0"]
    damping = values["delta"] * values["delta"]
    coefficients = [
        force * force,
        Fraction(0),
        8 * damping * h * force,
        -4 * h * h * force,
        16 * damping * h * h * values["alpha"],
        16 * damping * h * h * h,
    ]
    polynomial = fmpq_poly([fmpq(c.numerator, c.denominator) for c in coefficients])
    positive = [root for root in real_roots(polynomial) if root > 0]
    if h > 0:
        expected = 2
    else:
        expected = 3
    if len(positive) != expected:
        raise NotCertifiedError("the resonance has no two folds")
    if h > 0:
        lower, upper = positive
    else:
        # The resonance of a softening spring bends to lower drives: the fold of the lower drive has
        # the larger amplitude.
        upper, lower, _ = positive
        if not lower < tip_square(p):
            raise NotCertifiedError("the resonance has no two folds below its tip")
    return moving_root(lower, coefficients), moving_root(upper, coefficients)


def tip_square(p: Parameters) -> arb:
    """The square S_t of the largest amplitude of the resonance of a softening spring.

    Both branches meet there: 4 delta^2 (-h) S^2 - 4 delta^2 (alpha - delta^2) S + f0^2 = 0. The
    smaller root is 2 c/(b + sqrt(b^2 - 4 a c)) of a S^2 - b S + c.
    """
    values = numbers(p, "alpha", "beta", "delta", "f0")
    force = plain(values["f0"]) ** 2
    damping = plain(values["delta"]) ** 2
    # a S^2 - b S + c = 0 with a = 4 delta^2 (-h), b = 4 delta^2 (alpha - delta^2), c = f0^2.
    softening = -plain(values["beta"]) * Fraction(3, 4)
    linear = 4 * damping * (plain(values["alpha"]) - damping)
    discriminant = linear**2 - 16 * damping * softening * force
    if linear <= 0 or discriminant <= 0:
        raise NotCertifiedError("the resonance does not close below the barrier")
    return 2 * arb_of(force) / (arb_of(linear) + arb_of(discriminant).sqrt())


def moving_root(root: arb, coefficients: Sequence[Fraction]) -> arb:
    """The simple root S of P = sum c_k S^k, with the derivatives that the coefficients c_k carry.

    P(S) = 0 gives dS = -sum dc_k S^k/P'(S).
    """
    powers = [arb(1)]
    for _ in coefficients[1:]:
        powers.append(powers[-1] * root)
    # P'(S) = sum k c_k S^(k-1).
    slope = arb(0)
    for k, coefficient in enumerate(coefficients[1:], start=1):
        slope += k * arb_of(plain(coefficient)) * powers[k - 1]
    # dS = -sum (S^k/P'(S)) dc_k.
    changes = [
        (-power / slope, arb_of(coefficient))
        for power, coefficient in zip(powers, coefficients, strict=True)
    ]
    return carried(root, *changes)


def fold(p: Parameters, s: arb) -> list[arb]:
    """Drive [rad/s] and amplitude [m] of the fold at S: w^2 = alpha + h S + f0^2/(2 h S^2)."""
    values = numbers(p, "alpha", "beta", "f0")
    h = arb_of(values["beta"] * 3 / 4)
    square = arb_of(values["f0"] ** 2)
    # w^2 = alpha + h S + f0^2/(2 h S^2).
    drive_square = arb_of(values["alpha"]) + h * s + square / (2 * h * s * s)
    if not drive_square > 0:
        raise NotCertifiedError("the resonance leans down to drives that are not real")
    return [drive_square.sqrt(), s.sqrt()]


def drives(p: Parameters) -> list[arb]:
    """The lower and the higher drive [rad/s] of an amplitude A (1.121): w^2 = k - 2 delta^2 -+
    sqrt(f0^2/A^2 - 4 delta^2 (k - delta^2)), with k = alpha + 3 beta A^2/4.
    """
    values = numbers(p, "amplitude", "alpha", "beta", "delta", "f0")
    amplitude = values["amplitude"]
    damping = values["delta"] ** 2
    k = values["alpha"] + values["beta"] * amplitude**2 * 3 / 4
    # sqrt(f0^2/A^2 - 4 delta^2 (k - delta^2)) and k - 2 delta^2.
    root = arb_of((values["f0"] / amplitude) ** 2 - 4 * damping * (k - damping)).sqrt()
    middle = arb_of(k - 2 * damping)
    return [(middle - root).sqrt(), (middle + root).sqrt()]


def eta_of(v: arb) -> arb:
    """The parameter eta = 1 + sqrt(1 - v) of the map with c = v/4, from v = 1 - (eta - 1)^2."""
    return 1 + (1 - v).sqrt()


def doublings() -> dict[str, list[arb]]:
    """The parameters eta at which cycles of one, two and four iterates double."""
    # The larger real root, v = -5.47: the doubling of the cycle that is born at v = -5.
    stable = real_roots(DOUBLING_OF_4)[-1]
    return {
        # eta = 1 + sqrt(1 - v) at v = -3, at v = -5, and at the root.
        "doubling-of-1": [arb(3)],
        "doubling-of-2": [1 + arb(6).sqrt()],
        "doubling-of-4": [eta_of(stable)],
    }


def two_cycle(p: Parameters) -> list[arb]:
    """The cycle of two iterates, (eta + 1 +- sqrt((eta - 3)(eta + 1)))/(2 eta)."""
    eta = numbers(p, "eta")["eta"]
    # (eta + 1 +- sqrt((eta - 3)(eta + 1)))/(2 eta).
    root = arb_of((eta - 3) * (eta + 1)).sqrt()
    return [(arb_of(eta + 1) + sign * root) / arb_of(2 * eta) for sign in (1, -1)]


def shares() -> dict[str, list[arb]]:
    """The shares of the iterates at eta = 4 below 1/4, 1/2 and 3/4.

    The share below x = sin^2(pi u/2) is u, and sin^2 is 1/4, 1/2, 3/4 at 30, 45 and 60 degrees.
    """
    return {
        "below-quarter": [arb_of(Fraction(1, 3))],
        "below-half": [arb_of(Fraction(1, 2))],
        "below-three-quarters": [arb_of(Fraction(2, 3))],
    }


def values(p: Parameters) -> dict[str, list[arb]]:
    """The numbers of every row of the case, by the row's name."""
    lower, upper = fold_squares(p)
    force = arb_of(numbers(p, "f0")["f0"])
    return {
        "drives": drives(p),
        "forces": [force, force],
        "lower-fold": fold(p, lower),
        "upper-fold": fold(p, upper),
        "two-cycle": two_cycle(p),
        **doublings(),
        **shares(),
    }


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters amplitude [m], alpha [1/s^2], beta [1/(m^2 s^2)], delta [1/s], f0
    [m/s^2], eta; `scale` of every number.
    """
    return Timeless(
        Refiner.of(scale),
        lambda: listed(values(p)),
        witness="discriminants of the balance; multipliers of cycles in balls",
    )
