"""Witness of the whirling shaft: Newton's law in Cartesian coordinates by Taylor integration; the
border of stability from the power of both dashpots on a circle.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, fmpq, fmpq_poly

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = "Taylor integration at 58 digits, unproven (truth/witnesses/whirling_shaft.py)"


def values(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """x, y [m] and vx, vy [m/s], the growth rate [1/s], and the turning [rad/s] at the border."""
    mass = number(p, "mass")
    stiffness = number(p, "stiffness")
    outer = number(p, "outer_damping")
    inner = number(p, "inner_damping")
    turning = number(p, "turning")

    def rates(t: Any, state: Sequence[Any]) -> list[Any]:
        """m r'' = -k r - c_e v - c_i (v - W e_z x r), with W e_z x r = (-W y, W x)."""
        x, y, vx, vy = state
        # v - W e_z x r = (v_x + W y, v_y - W x)
        slip_x = vx + y * arb_of(turning)
        slip_y = vy - x * arb_of(turning)
        force_x = -x * arb_of(stiffness) - vx * arb_of(outer) - slip_x * arb_of(inner)
        force_y = -y * arb_of(stiffness) - vy * arb_of(outer) - slip_y * arb_of(inner)
        return [vx, vy, force_x / arb_of(mass), force_y / arb_of(mass)]

    start = [arb_of(value) for value in (*vector(p, "x0"), *vector(p, "v0"))]
    solution = Solution(rates, start)
    yield None, {"growth_rate": growth_rate(mass, stiffness, outer, inner, turning)}
    if inner:
        # On a circle of radius 1 at the rate w0 the outer dashpot dissipates the power c_e w0^2,
        # and the inner one supplies c_i w0 (W - w0). Both are equal at W = w0 + c_e w0/c_i.
        w0 = arb_of(stiffness / mass).sqrt()
        yield None, {"border": w0 + arb_of(outer) * w0 * w0 / (arb_of(inner) * w0)}
    for t in times:
        yield t, dict(zip(("x", "y", "vx", "vy"), solution.at(t), strict=True))


def growth_rate(
    mass: Fraction, stiffness: Fraction, outer: Fraction, inner: Fraction, turning: Fraction
) -> arb:
    """The largest real part of the roots of |m q^2 + (c_e + c_i) q + k - i c_i W|^2, the
    characteristic polynomial of the four real equations, by their isolation.

    Both roots of one factor are conjugate to those of the other, so that nothing is lost.
    """
    # (m q^2 + c q + k)^2 + (c_i W)^2 for real q.
    damping = outer + inner
    coefficients = [
        stiffness**2 + (inner * turning) ** 2,
        2 * damping * stiffness,
        2 * mass * stiffness + damping**2,
        2 * mass * damping,
        mass**2,
    ]
    polynomial = fmpq_poly([fmpq(c.numerator, c.denominator) for c in map(Fraction, coefficients)])
    # Pairs of root and multiplicity.
    roots: list[Any] = polynomial.complex_roots()
    largest: arb = max((root.real for root, _ in roots), key=float)
    return largest


WITNESSES = {"whirling-shaft": Witness(METHOD, values)}
