"""Rules of quaternion algebra by complex 2 x 2 matrices: products of the basis elements,
conjugates, vectors, and complex numbers as the quaternions along 1 and I.

The matrices are those of `quaternion_matrices`; a complex number is worked out as one. Numbers in
parentheses, as (1.45), are equations of Matuttis and Chen 2014.
"""

from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.quaternion_matrices import (
    absolute,
    conjugated,
    numbers_of,
    of_numbers,
)
from refdem.truth.complex_balls import Complex, ComplexMatrix
from refdem.truth.exact import vector

ELEMENTS = {"i": (0, 1, 0, 0), "j": (0, 0, 1, 0), "k": (0, 0, 0, 1)}
"""The basis elements I, J and K."""


def rules(p: Parameters, u: ComplexMatrix) -> dict[str, list[arb]]:
    """The numbers of the rows on rules, by the row's name; u = q/|q|."""
    p_matrix = of_numbers(vector(p, "p"))
    q_matrix = of_numbers(vector(p, "q"))
    r_matrix = of_numbers(vector(p, "r"))
    v = of_numbers(vector(p, "vector"))
    omega = of_numbers(vector(p, "omega"))
    length_of_q = absolute(q_matrix)
    length_of_r = absolute(r_matrix)
    # q q* = q* q = (|q|^2, 0, 0, 0).
    square = [length_of_q * length_of_q, arb(0), arb(0), arb(0)]
    matrices = {
        "p-conjugate": conjugated(p_matrix),
        "q-conjugate": conjugated(q_matrix),
        # (q*)* = q and p* + q* = (p + q)* (1.49), q* p* = (p q)* (1.50).
        "conjugate-twice": q_matrix,
        "sum-of-conjugates": conjugated(p_matrix + q_matrix),
        "product-of-conjugates": conjugated(p_matrix * q_matrix),
        "u-r": u * r_matrix,
        # (0, v)* = -(0, v), and (0, v) (0, omega) = (-v . omega, v x omega).
        "pure-conjugate": -v,
        "pure-product": v * omega,
        "one-sided": u * v,
    }
    lengths = {
        "by-conjugate": square,
        "conjugate-by": square,
        # |u r| = |u| |r| = |r|.
        "r-absolute": [length_of_r],
        "u-r-absolute": [length_of_r],
    }
    of_matrices = {name: numbers_of(matrix) for name, matrix in matrices.items()}
    return of_matrices | lengths | basis() | complex_numbers(p)


def basis() -> dict[str, list[arb]]:
    """Products of the basis elements: I^2 = J^2 = K^2 = -1, I J = K = -J I etc. (1.44), (1.45)."""
    elements = {
        name: of_numbers([Fraction(x) for x in numbers]) for name, numbers in ELEMENTS.items()
    }
    return {
        f"{left}-{right}": numbers_of(elements[left] * elements[right])
        for left in elements
        for right in elements
    }


def complex_numbers(p: Parameters) -> dict[str, list[arb]]:
    """Products, quotients and absolute values of z = w + i x of p and y = 1 + i v_x."""
    w, x = (arb_of(number) for number in vector(p, "p")[:2])
    z = Complex(w, x)
    y = Complex(arb(1), arb_of(vector(p, "vector")[0]))
    results = {
        "complex-z-y": z * y,
        "complex-inverse": y.inverse(),
        "complex-quotient": z * y.inverse(),
        "complex-i-z": Complex(arb(0), arb(1)) * z,
    }
    rows = {name: [value.real, value.imag, arb(0), arb(0)] for name, value in results.items()}
    return rows | {"complex-absolute": [abs(y)]}
