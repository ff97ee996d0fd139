"""Witness of folds and period doublings: folds as double roots of the harmonic balance's cubic in
A^2, doublings as zeros of the multiplier plus 1 along a cycle.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import cast

from flint import acb, arb, fmpq, fmpq_poly

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness

BISECTIONS = 110
"""Halvings of an interval of 1/8: 2^-113, below the digits that are compared."""


def bifurcations(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Every row of the case bifurcations."""
    said = {"forces.0": arb_of(number(p, "f0")), "forces.1": arb_of(number(p, "f0"))}
    for name, found in zip(("lower-fold", "upper-fold"), double_roots(p), strict=True):
        said |= {f"{name}.{i}": value for i, value in enumerate(found)}
    said |= {f"drives.{i}": drive for i, drive in enumerate(drives(p))}
    eta = arb_of(number(p, "eta"))
    # The two iterates have the sum 1 + 1/eta and the product (1 + 1/eta)/eta: roots of a quadratic.
    mean = (1 + 1 / eta) / 2
    half = (mean * mean - 2 * mean / eta).sqrt()
    said |= {"two-cycle.0": mean + half, "two-cycle.1": mean - half}
    said |= {
        "doubling-of-1": doubling(1, Fraction(23, 8)),
        "doubling-of-2": doubling(2, Fraction(27, 8)),
        "doubling-of-4": doubling(4, Fraction(7, 2)),
    }
    said |= {
        "below-quarter": share_below(Fraction(1, 4)),
        "below-half": share_below(Fraction(1, 2)),
        "below-three-quarters": share_below(Fraction(3, 4)),
    }
    yield None, said


def share_below(x: Fraction) -> arb:
    """The share of the iterates below x at eta = 4.

    It is the integral from 0 to x of the invariant density 1/(pi sqrt(s (1 - s))), which is (2/pi)
    asin(sqrt(x)) = (2/pi) atan2(sqrt(x), sqrt(1 - x)).
    """
    angle = arb.atan2(arb_of(x).sqrt(), arb_of(1 - x).sqrt())
    return 2 * angle / arb.pi()


def double_roots(p: Mapping[str, Exact]) -> list[list[arb]]:
    """Drive [rad/s] and amplitude [m] of both folds, the lower drive first.

    At a fold the discriminant of the cubic in S = A^2

        h^2 S^3 + 2 h g S^2 + (g^2 + d q) S - f0^2,   g = alpha - q, d = 4 delta^2, q = w^2,

    vanishes, where h = 3 beta/4. The double root of a S^3 + b S^2 + c S + e is
    (9 a e - b c)/(2 (b^2 - 3 a c)). A softening spring, h < 0, has a third solution of the largest
    amplitude, near the potential barrier, which is left out.
    """
    values = {
        name: fmpq(value.numerator, value.denominator)
        for name, value in numbers(p, "alpha", "beta", "delta", "f0").items()
    }
    # The coefficients a, b, c, e of a S^3 + b S^2 + c S + e as polynomials in q = w^2.
    h = values["beta"] * 3 / 4
    q = fmpq_poly([0, 1])
    g = values["alpha"] - q
    a = fmpq_poly([h * h])
    b = 2 * h * g
    c = g * g + 4 * values["delta"] * values["delta"] * q
    e = fmpq_poly([-values["f0"] * values["f0"]])
    discriminant = (
        18 * a * b * c * e - 4 * b**3 * e + b * b * c * c - 4 * a * c**3 - 27 * a * a * e * e
    )
    found = []
    for root in roots(discriminant):
        if root.imag != 0 or not root.real > 0:
            continue
        square = root.real
        a_, b_, c_, e_ = (_at(polynomial, square) for polynomial in (a, b, c, e))
        # The double root S = (9 a e - b c)/(2 (b^2 - 3 a c)), and w = sqrt(q), A = sqrt(S).
        s = (9 * a_ * e_ - b_ * c_) / (2 * (b_ * b_ - 3 * a_ * c_))
        if s > 0:
            found.append([square.sqrt(), s.sqrt()])
    of_resonance = sorted(found, key=lambda pair: float(pair[1].mid()))[:2]
    return sorted(of_resonance, key=lambda pair: float(pair[0].mid()))


def roots(polynomial: fmpq_poly) -> list[acb]:
    """The real and complex roots of a polynomial, in disjoint balls."""
    return [root for root, _ in cast("list[tuple[acb, int]]", polynomial.complex_roots())]


def _at(polynomial: fmpq_poly, x: arb) -> arb:
    """The value of a polynomial at a ball, by Horner's scheme."""
    value = arb(0)
    for coefficient in reversed(polynomial.coeffs()):
        value = value * x + arb(coefficient)
    return value


def drives(p: Mapping[str, Exact]) -> list[arb]:
    """Both drives [rad/s] of an amplitude A: roots q = w^2 of a quadratic.

    (k - q)^2 + 4 delta^2 q = f0^2/A^2 with k = alpha + 3 beta A^2/4.
    """
    values = {
        name: fmpq(value.numerator, value.denominator)
        for name, value in numbers(p, "amplitude", "alpha", "beta", "delta", "f0").items()
    }
    k = values["alpha"] + values["beta"] * values["amplitude"] * values["amplitude"] * 3 / 4
    ratio = values["f0"] / values["amplitude"]
    # q^2 + (4 delta^2 - 2 k) q + k^2 - (f0/A)^2 = 0, from the constant coefficient on.
    quadratic = fmpq_poly([k * k - ratio * ratio, 4 * values["delta"] * values["delta"] - 2 * k, 1])
    found = [root.real.sqrt() for root in roots(quadratic)]
    return sorted(found, key=lambda root: float(root.mid()))


def doubling(period: int, low: Fraction) -> arb:
    """The eta in [low, low + 1/8] at which the multiplier of the stable cycle becomes less than -1.

    It is found by bisection of the sign of the multiplier plus 1.
    """
    high = low + Fraction(1, 8)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if multiplier(middle, period) > -1:
            low = middle
        else:
            high = middle
    return arb_of((low + high) / 2)


def multiplier(eta: Fraction, period: int) -> arb:
    """The multiplier of the cycle that attracts x = 1/2: the product of eta (1 - 2 x) along it."""
    parameter = arb_of(eta)
    x = arb(1) / 2
    # Iterates of 1/2 approach the cycle; then Newton's method for f^period(x) - x = 0.
    for _ in range(64 * period):
        x = _middle(parameter * x * (1 - x))
    for _ in range(12):
        # x - (f^p(x) - x)/((f^p)'(x) - 1), f^p being p = `period` steps of the map.
        image, slope = _image(parameter, x, period)
        x = _middle(x - (image - x) / (slope - 1))
    return _image(parameter, x, period)[1]


def _image(eta: arb, x: arb, period: int) -> tuple[arb, arb]:
    """The iterate of x after `period` steps of the map, and its derivative by x."""
    slope = arb(1)
    for _ in range(period):
        # (f^(k + 1))'(x) = (f^k)'(x) eta (1 - 2 f^k(x))
        slope = slope * eta * (1 - 2 * x)
        x = eta * x * (1 - x)
    return x, slope


def _middle(ball: arb) -> arb:
    """The midpoint of a ball, without its radius."""
    middle: arb = ball.mid()
    return middle


WITNESSES = {
    "bifurcations": Witness(
        "double roots by discriminants; multipliers along cycles by bisection"
        " (truth/witnesses/bifurcations.py)",
        bifurcations,
    ),
}
