"""Rules of quaternion algebra by Hamilton's products in rational numbers, as the witness of the
case quaternions has them.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import vector
from refdem.truth.witnesses.turns import hamilton

ZERO = Fraction(0)
ONE = Fraction(1)


def rules(p: Mapping[str, Exact], u: Sequence[arb]) -> dict[str, Sequence[Any]]:
    """The rows on basis elements, conjugates, vectors and complex numbers; u = q/|q|."""
    a, b, c = (vector(p, name) for name in ("p", "q", "r"))
    v = vector(p, "vector")
    pure = (ZERO, *v)
    p_conjugate = reversed_vector(a)
    q_conjugate = reversed_vector(b)
    u_r = hamilton(u, [arb_of(x) for x in c])
    return {
        **products_of_elements(),
        "p-conjugate": p_conjugate,
        "q-conjugate": q_conjugate,
        "conjugate-twice": reversed_vector(q_conjugate),
        "sum-of-conjugates": [x + y for x, y in zip(p_conjugate, q_conjugate, strict=True)],
        "product-of-conjugates": hamilton(q_conjugate, p_conjugate),
        "by-conjugate": hamilton(b, q_conjugate),
        "conjugate-by": hamilton(q_conjugate, b),
        "u-r": u_r,
        "u-r-absolute": [sum((x * x for x in u_r), arb(0)).sqrt()],
        "r-absolute": [arb_of(sum((x * x for x in c), ZERO)).sqrt()],
        "pure-conjugate": reversed_vector(pure),
        "pure-product": hamilton(pure, (ZERO, *vector(p, "omega"))),
        "one-sided": hamilton(u, [arb_of(x) for x in pure]),
        **complex_numbers((a[0], a[1]), v[0]),
    }


def reversed_vector(q: Sequence[Fraction]) -> list[Fraction]:
    """The quaternion (w, -x, -y, -z)."""
    return [q[0], *(-x for x in q[1:])]


def products_of_elements() -> dict[str, Sequence[Any]]:
    """The nine products of the elements I, J and K, in both orders."""
    elements = {
        "i": (ZERO, ONE, ZERO, ZERO),
        "j": (ZERO, ZERO, ONE, ZERO),
        "k": (ZERO, ZERO, ZERO, ONE),
    }
    return {
        f"{left}-{right}": hamilton(elements[left], elements[right])
        for left in elements
        for right in elements
    }


def complex_numbers(z: tuple[Fraction, Fraction], slope: Fraction) -> dict[str, Sequence[Any]]:
    """The rows of z = (real, imaginary) and y = 1 + i slope; divided as (1.42) and after."""
    real, imaginary = z
    # z y = z (1 + i s) and z/y = z (1 - i s)/(1 + s^2), with y = 1 + i s.
    square = 1 + slope * slope
    product = [real - imaginary * slope, real * slope + imaginary]
    quotient = [(real + imaginary * slope) / square, (imaginary - real * slope) / square]
    return {
        "complex-z-y": [*product, ZERO, ZERO],
        "complex-absolute": [arb_of(square).sqrt()],
        "complex-inverse": [1 / square, -slope / square, ZERO, ZERO],
        "complex-quotient": [*quotient, ZERO, ZERO],
        "complex-i-z": [-imaginary, real, ZERO, ZERO],
    }
