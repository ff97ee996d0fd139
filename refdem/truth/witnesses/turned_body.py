"""Witness of a rotated body and a triangle: the tensor from the positions of the masses in space,
principal moments as roots of the characteristic polynomial, the height by Lagrange's identity.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, fmpq, fmpq_poly

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.turns import about, hamilton, row_by_row

ZERO = Fraction(0)


def of_body(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """The rows of the body, by name."""
    masses = vector(p, "masses")
    phi, theta, psi = (arb_of(x) for x in vector(p, "euler"))
    rotation = about("z", phi) * about("x", theta) * about("z", psi)
    # Mass k is at column k of the rotation: J_ij = sum m_k (delta_ij - R_ik R_jk), as |R_k| = 1.
    whole = arb_mat(3, 3)
    for k, mass in enumerate(masses):
        for i in range(3):
            for j in range(3):
                across = int(i == j) - rotation[i, k] * rotation[j, k]
                whole[i, j] += arb_of(mass) * across
    omega = arb_mat([[arb_of(x)] for x in vector(p, "omega")])
    # L = (m1 + m2) omega about the third axis, E = L omega/2, omega = 2 pi f.
    spin = 2 * arb.pi() * arb_of(number(p, "frequency"))
    momentum = (arb_of(masses[0]) + arb_of(masses[1])) * spin
    energy = momentum * spin / 2
    return {
        "spin-energy": [energy],
        "spin-momentum": [momentum],
        "momentum-energy": [energy],
        "half-turned-tensor": row_by_row(whole * rotation),
        "turned-tensor": row_by_row(whole),
        "principal-moments": characteristic_roots(masses),
        "turned-momentum": row_by_row(whole * omega),
    }


def characteristic_roots(masses: Sequence[Fraction]) -> list[arb]:
    """The eigenvalues, in rising order, of the tensor M 1 - diag(masses), M the sum of the masses.

    They are invariant under rotations.

    With the elementary symmetric functions M, e2 and e3 of the masses they are M - m for the roots
    m of m^3 - M m^2 + e2 m - e3.
    """
    first, second, third = masses
    total = first + second + third
    pairs = first * second + first * third + second * third
    # m^3 - M m^2 + e2 m - e3, from the constant coefficient on.
    coefficients = [-first * second * third, pairs, -total, Fraction(1)]
    polynomial = fmpq_poly([fmpq(c.numerator, c.denominator) for c in coefficients])
    roots: list[arb] = []
    found: Any = polynomial.complex_roots()
    for root, multiplicity in found:
        roots += [arb_of(total) - arb(root.real)] * multiplicity
    return sorted(roots, key=arb.mid)


def of_triangle(p: Mapping[str, Exact]) -> dict[str, Sequence[Any]]:
    """The rows of the triangle with the corner a over the base b, by name.

    The component of a at right angles to b is b x (a x b)/b^2, and its square a^2 - (a . b)^2/b^2.
    """
    shifts = vector(p, "shifts")
    corner = shifts[:3]
    base = shifts[3:]
    minus_along, *crossed = hamilton([ZERO, *corner], [ZERO, *base])
    corner_square = sum((x * x for x in corner), ZERO)
    base_square = sum((x * x for x in base), ZERO)
    _, *twice = hamilton([ZERO, *base], [ZERO, *crossed])
    area_square = corner_square * base_square - minus_along * minus_along
    # |a x b|^2 = a^2 b^2 - (a . b)^2 is the square of twice the area; height = |a x b|/|b|.
    height = arb_of(area_square / base_square).sqrt()
    return {
        "rejection": [x / base_square for x in twice],
        "height": [height],
        "corner-by-base": crossed,
        "twice-area": [arb_of(area_square).sqrt()],
        "base": [arb_of(base_square).sqrt()],
        "height-by-area": [height],
    }
