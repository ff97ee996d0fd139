"""The operations of the case quaternions, and the magnitudes of their results.

A row is (name of the result, operation of core/algebra.py, operands); an operand is numbers or the
name of an earlier result.
"""

from typing import Any

import numpy as np

from refdem.cases._algebra import Row, X, Y, Z
from refdem.core.parameters import Parameters


def rows(p: Parameters) -> list[Row]:
    """All operations of the case: algebra, then rotations, then rates."""
    return _algebra_rows(p) + _rotation_rows(p) + _rate_rows(p)


def _algebra_rows(p: Parameters) -> list[Row]:
    """Products, sums, conjugates and inverses of the quaternions p, q and r."""
    a = p.p.tolist()
    b = p.q.tolist()
    c = p.r.tolist()
    # p q - q p = (0, 2 p x q) with the vector parts of p and q, and (p q) r = p (q r).
    products: list[Row] = [
        ("p-q", "product", [a, b]),
        ("q-p", "product", [b, a]),
        ("commutator", "difference", ["p-q", "q-p"]),
        ("q-r", "product", [b, c]),
        ("left", "product", ["p-q", c]),
        ("right", "product", [a, "q-r"]),
    ]
    # (p q)* = q* p*, (p + q)* = p* + q* (1.49), (1.50); q^-1 = q*/|q|^2, q q^-1 = 1; u = q/|q|.
    inverses: list[Row] = [
        ("conjugate-of-product", "conjugate", ["p-q"]),
        ("sum", "sum", [a, b]),
        ("conjugate-of-sum", "conjugate", ["sum"]),
        ("inverse", "inverse", [b]),
        ("one", "product", [b, "inverse"]),
        ("absolute", "absolute", [b]),
        ("u", "unit", [b]),
    ]
    # Products by the real 4 x 4 and the complex 2 x 2 matrices of quaternions.
    matrices: list[Row] = [
        ("real-product", "real-product", [a, b]),
        ("complex-product", "complex-product", [a, b]),
        ("complex-eigenvalue", "complex-eigenvalue", [b]),
    ]
    operations = products + inverses + matrices + _eigenvalue_rows(p)
    return operations + _rule_rows(p) + _complex_rows(p)


def _eigenvalue_rows(p: Parameters) -> list[Row]:
    """Eigenvalues of Pauli's matrices s1, s2, s3, of their sum weighted by a vector, and of the
    complex matrices of the basis elements.
    """
    # Those of x s1 + y s2 + z s3 are +-|(x, y, z)| (1.143).
    pauli: list[Row] = [
        ("pauli-x", "pauli-eigenvalues", [X]),
        ("pauli-y", "pauli-eigenvalues", [Y]),
        ("pauli-z", "pauli-eigenvalues", [Z]),
        ("pauli-vector", "pauli-eigenvalues", [p.vector.tolist()]),
    ]
    # Those of w 1 - i (x s1 + y s2 + z s3) are w +- i |(x, y, z)|.
    elements: list[Row] = [
        ("element-i", "complex-eigenvalue", [[0.0, *X]]),
        ("element-j", "complex-eigenvalue", [[0.0, *Y]]),
        ("element-k", "complex-eigenvalue", [[0.0, *Z]]),
    ]
    return pauli + elements


def _rule_rows(p: Parameters) -> list[Row]:
    """Products of the basis elements, both sides of the rules for conjugates, and the length of a
    quaternion, which a product by a unit quaternion preserves.
    """
    a = p.p.tolist()
    b = p.q.tolist()
    c = p.r.tolist()
    elements = {"i": [0.0, *X], "j": [0.0, *Y], "k": [0.0, *Z]}
    # i i = j j = k k = -1; i j = k, j k = i, k i = j, and -k, -i, -j in the other order (1.44),
    # (1.45).
    basis: list[Row] = [
        (f"{left}-{right}", "product", [elements[left], elements[right]])
        for left in elements
        for right in elements
    ]
    # (q*)* = q, p* + q* = (p + q)*, q* p* = (p q)* (1.49), (1.50), and q q* = q* q = |q|^2.
    conjugates: list[Row] = [
        ("p-conjugate", "conjugate", [a]),
        ("q-conjugate", "conjugate", [b]),
        ("conjugate-twice", "conjugate", ["q-conjugate"]),
        ("sum-of-conjugates", "sum", ["p-conjugate", "q-conjugate"]),
        ("product-of-conjugates", "product", ["q-conjugate", "p-conjugate"]),
        ("by-conjugate", "product", [b, "q-conjugate"]),
        ("conjugate-by", "product", ["q-conjugate", b]),
    ]
    # |u r| = |u| |r| = |r|.
    lengths: list[Row] = [
        ("u-r", "product", ["u", c]),
        ("u-r-absolute", "absolute", ["u-r"]),
        ("r-absolute", "absolute", [c]),
    ]
    return basis + conjugates + lengths


def _complex_rows(p: Parameters) -> list[Row]:
    """Complex numbers, which are the quaternions along 1 and I: with z = w + i x of p and y = 1 + i
    v_x, the product z y, |y|, the quotient z/y, and i z, a quarter turn.
    """
    z = [*p.p.tolist()[:2], 0.0, 0.0]
    y = [1.0, p.vector.tolist()[0], 0.0, 0.0]
    return [
        ("complex-z-y", "product", [z, y]),
        ("complex-absolute", "absolute", [y]),
        ("complex-inverse", "inverse", [y]),
        ("complex-quotient", "product", [z, "complex-inverse"]),
        ("complex-i-z", "product", [[0.0, *X], z]),
    ]


def _rotation_rows(p: Parameters) -> list[Row]:
    """Rotations of a vector by the unit quaternion u along q, other forms of u, and rotations by
    u1 = p/|p| and u2 = u one after the other.
    """
    v = p.vector.tolist()
    pure = [0.0, *v]
    # (0, v)* = -(0, v), and (0, v) (0, omega) = (-v . omega, v x omega). u (0, v) without u* on
    # its right is not a vector: for u = (s, a) its scalar part is -a . v.
    of_pure: list[Row] = [
        ("pure-conjugate", "conjugate", [pure]),
        ("pure-product", "product", [pure, [0.0, *p.omega.tolist()]]),
        ("one-sided", "product", ["u", pure]),
    ]
    # v' = u v u* = (-u) v (-u)*.
    rotated: list[Row] = [
        ("rotated", "rotated", ["u", v]),
        ("-u", "negative", ["u"]),
        ("rotated-by-minus-u", "rotated", ["-u", v]),
    ]
    # The matrix R of u with R v = u v u*, and u and Euler's angles from it.
    forms: list[Row] = [
        ("matrix", "matrix-of-quaternion", ["u"]),
        ("back", "quaternion-of-matrix", ["matrix"]),
        ("euler", "euler-of-matrix", ["matrix"]),
    ]
    # u u rotates by twice the angle of u.
    twice: list[Row] = [
        ("turned-twice", "product", ["u", "u"]),
        ("rotated-twice", "rotated", ["turned-twice", v]),
    ]
    # u2 (u1 v u1*) u2* = (u2 u1) v (u2 u1)*: the first rotation is the factor on the right.
    in_turn: list[Row] = [
        ("u1", "unit", [p.p.tolist()]),
        ("u2-u1", "product", ["u", "u1"]),
        ("u1-u2", "product", ["u1", "u"]),
        ("rotated-by-u1", "rotated", ["u1", v]),
        ("rotated-in-turn", "rotated", ["u", "rotated-by-u1"]),
        ("rotated-at-once", "rotated", ["u2-u1", v]),
        ("rotated-in-other-order", "rotated", ["u1-u2", v]),
    ]
    return of_pure + rotated + forms + twice + in_turn


def _rate_rows(p: Parameters) -> list[Row]:
    """Rates of u for the angular velocity omega in space axes, and omega from them."""
    omega = p.omega.tolist()
    rise = p.rise.tolist()
    return [
        # u' = omega u/2 (1.67), u'' = (omega' u + omega u')/2 (1.68), and u . u' = 0 as |u| = 1.
        ("rate", "rate", ["u", omega]),
        ("second-rate", "second-rate", ["u", omega, rise]),
        ("orthogonal", "dot", ["u", "rate"]),
        # u u'* = -omega/2 and u' u* = omega/2, whose sum is 0.
        ("rate-conjugate", "conjugate", ["rate"]),
        ("u-conjugate", "conjugate", ["u"]),
        ("u-rate", "product", ["u", "rate-conjugate"]),
        ("rate-u", "product", ["rate", "u-conjugate"]),
        ("anticommute", "sum", ["u-rate", "rate-u"]),
        # omega = 2 u' u* in space axes (1.89) and 2 u* u' in body axes (1.90).
        ("omega-back", "omega-of-rate", ["u", "rate"]),
        ("omega-body", "body-omega-of-rate", ["u", "rate"]),
    ]


PRODUCTS = (
    "p-q",
    "q-p",
    "commutator",
    "conjugate-of-product",
    "real-product",
    "complex-product",
    "product-of-conjugates",
)
"""Results of the size |p| |q|."""
RATES = (
    "rate",
    "orthogonal",
    "rate-conjugate",
    "u-rate",
    "rate-u",
    "anticommute",
    "omega-back",
    "omega-body",
)
"""Results of the size |omega|, since u has length 1."""

UNIT_EIGENVALUES = ("pauli-x", "pauli-y", "pauli-z", "element-i", "element-j", "element-k")
"""Results that are eigenvalues of size 1."""
ITERATED = 4.0
"""The magnitude of an eigenvalue over the length of its quaternion or vector.

The matrices A = w 1 - i v . s are normal, so that a change dA moves their eigenvalues by at most
|dA| (Bauer and Fike 1960). A solver for general matrices iterates: the transformations that it
applies from both sides add about ten roundings of |A|. For 60,000 random vectors and quaternions
the largest error was 13.8 u of the length (u = 2^-53); a bound of four units in the last place, 8
u, would be too small.
"""


def sizes(p: Parameters) -> dict[str, float]:
    """The magnitude of each result by name; that of a product is the product of the magnitudes.

    An error of u changes the rotated vector u v u* by twice as much, and two rotations by four
    times as much.
    """
    a = _size(p.p)
    b = _size(p.q)
    c = _size(p.r)
    v = _size(p.vector)
    omega = _size(p.omega)
    rise = _size(p.rise)
    magnitudes = dict.fromkeys(PRODUCTS, a * b)
    magnitudes |= dict.fromkeys(("sum", "conjugate-of-sum", "sum-of-conjugates"), a + b)
    of_q = ("absolute", "q-conjugate", "conjugate-twice")
    magnitudes |= dict.fromkeys(of_q, b)
    magnitudes["p-conjugate"] = a
    magnitudes |= dict.fromkeys(("by-conjugate", "conjugate-by"), b * b)
    magnitudes |= dict.fromkeys(("u-r", "u-r-absolute", "r-absolute"), c)
    magnitudes |= _sizes_of_complex(p)
    magnitudes["q-r"] = b * c
    magnitudes |= dict.fromkeys(("left", "right"), a * b * c)
    magnitudes["inverse"] = 1 / b
    magnitudes |= dict.fromkeys(("rotated", "rotated-by-minus-u"), 2 * v)
    two_rotations = ("rotated-in-turn", "rotated-at-once", "rotated-in-other-order")
    magnitudes |= dict.fromkeys(("rotated-twice", *two_rotations), 4 * v)
    magnitudes["rotated-by-u1"] = 2 * v
    magnitudes |= dict.fromkeys(("pure-conjugate", "one-sided"), v)
    magnitudes["pure-product"] = v * omega
    # The errors of both factors add up. The matrix is quadratic in u, so that an error of u counts
    # twice.
    twice = ("matrix", "turned-twice", "u2-u1", "u1-u2")
    magnitudes |= dict.fromkeys(twice, 2.0)
    magnitudes |= dict.fromkeys(UNIT_EIGENVALUES, ITERATED)
    magnitudes["pauli-vector"] = ITERATED * v
    magnitudes["complex-eigenvalue"] = ITERATED * b
    magnitudes |= dict.fromkeys(RATES, omega)
    # u'' = (rise u)/2 - omega^2 u/4.
    magnitudes["second-rate"] = rise + omega * omega
    magnitudes["euler"] = float(np.pi) * steepness(p)
    return magnitudes


def _sizes_of_complex(p: Parameters) -> dict[str, float]:
    """The magnitudes of the complex numbers and of what is made of them."""
    z = _size(p.p[:2])
    y = float(np.hypot(1.0, p.vector[0]))
    return {
        "complex-z-y": z * y,
        "complex-absolute": y,
        "complex-inverse": 1 / y,
        "complex-quotient": z / y,
        "complex-i-z": z,
    }


def _size(value: Any) -> float:
    """The Euclidean norm of a vector, or 1 if it is zero."""
    norm = float(np.linalg.norm(value))
    if norm == 0:
        return 1.0
    return norm


def steepness(p: Parameters) -> float:
    """The factor 1/sin theta by which Euler angles z-x-z change faster than the attitude.

    For a unit quaternion sin(theta/2) = |(x, y)| and cos(theta/2) = |(w, z)|.
    """
    w, x, y, z = p.q / np.linalg.norm(p.q)
    # sin theta = 2 sin(theta/2) cos(theta/2).
    sine = 2 * np.hypot(x, y) * np.hypot(w, z)
    return float(1 / max(1e-100, sine))
