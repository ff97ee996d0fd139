"""Quaternion algebra by complex 2 x 2 matrices, in ball arithmetic.

The quaternion q = (w, x, y, z) stands for the matrix

    M(q) = w 1 - i (x s1 + y s2 + z s3) = [[w - i z, -y - i x], [y - i x, w + i z]]

with Pauli's matrices s1, s2, s3. Sums and products of quaternions are those of their matrices, the
conjugate q* = (w, -x, -y, -z) is the conjugate transpose, |q|^2 is the determinant, and (w, x, y,
z) are read back from the first column (w - i z, y - i x).

Names: a function that takes or returns `ComplexMatrix` works on such matrices. The case's
quaternions p, q, r are called `p_matrix`, `q_matrix`, `r_matrix`; u = q/|q| is the unit
quaternion, which rotates body vectors into space.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_forms.quaternion_matrices import (
    absolute,
    conjugated,
    numbers_of,
    of_balls,
    of_numbers,
)
from refdem.truth.closed_forms.quaternion_rules import rules
from refdem.truth.complex_balls import Complex, ComplexMatrix
from refdem.truth.dual import atan2
from refdem.truth.exact import vector
from refdem.truth.refiner import Refiner
from refdem.truth.timeless import Timeless


def rotated(u: ComplexMatrix, v: ComplexMatrix) -> list[arb]:
    """The vector v rotated by the unit quaternion u: the vector part of u v u*."""
    return numbers_of(u * v * conjugated(u))[1:]


def euler(u: ComplexMatrix) -> list[arb]:
    """Euler's angles phi, theta, psi (z-x-z) [rad] of the unit quaternion u.

    By (1.76) to (1.79), with c = cos(theta/2) and s = sin(theta/2),

        w + i z = c exp(i (phi + psi)/2),    x + i y = s exp(i (phi - psi)/2).

    So theta/2 is the phase of |w + i z| + i |x + i y|, and phi and psi are the sum and the
    difference of the two phases. Raises UndecidedError where phi or psi may be +-pi.
    """
    w, x, y, z = numbers_of(u)
    cosine_part = Complex(w, z)
    sine_part = Complex(x, y)
    half_sum = cosine_part.arg()
    half_difference = sine_part.arg()
    theta = 2 * atan2(abs(sine_part), abs(cosine_part))
    return [wrapped(half_sum + half_difference), theta, wrapped(half_sum - half_difference)]


def wrapped(angle: arb) -> arb:
    """The angle [rad] in (-pi, pi], for an angle in (-3 pi, 3 pi).

    Raises UndecidedError if the ball holds pi or -pi.
    """
    if angle > arb.pi():
        return angle - 2 * arb.pi()
    if angle < -arb.pi():
        return angle + 2 * arb.pi()
    if angle < arb.pi() and angle > -arb.pi():
        return angle
    raise UndecidedError("an Euler angle at the end of its range")


def values(p: Parameters) -> dict[str, list[arb]]:
    """The numbers of every row of the case, by the row's name."""
    q_matrix = of_numbers(vector(p, "q"))
    length = absolute(q_matrix)
    u = q_matrix / length
    matrices = products(p, q_matrix, length) | rates(p, u)
    of_matrices = {name: numbers_of(matrix) for name, matrix in matrices.items()}
    of_rotations = rotation_rows(p, q_matrix, length, u) | successive(p, u)
    return of_matrices | of_rotations | pauli(p) | rules(p, u)


def successive(p: Parameters, u: ComplexMatrix) -> dict[str, list[arb]]:
    """Rotations by u1 = p/|p| and then by u2 = u: that by the product u2 u1, and in the other
    order that by u1 u2.
    """
    p_matrix = of_numbers(vector(p, "p"))
    u1 = p_matrix / absolute(p_matrix)
    v = of_numbers(vector(p, "vector"))
    # One after the other: u2 (u1 v u1*) u2*.
    first = rotated(u1, v)
    both = rotated(u, of_balls(first))
    return {
        "u1": numbers_of(u1),
        "u2-u1": numbers_of(u * u1),
        "u1-u2": numbers_of(u1 * u),
        "rotated-by-u1": first,
        "rotated-in-turn": both,
        "rotated-at-once": both,
        "rotated-in-other-order": rotated(u1, of_balls(rotated(u, v))),
    }


def pauli(p: Parameters) -> dict[str, list[arb]]:
    """Eigenvalues of Pauli's matrices (1.143), 1 and -1; of those of i, j and k (1.142), i and -i;
    and of x s1 + y s2 + z s3, +-|(x, y, z)|, since its square is |(x, y, z)|^2 1.
    """
    square = sum((arb_of(component) ** 2 for component in vector(p, "vector")), arb(0))
    length = square.sqrt()
    of_axes = {f"pauli-{axis}": [arb(1), arb(-1)] for axis in "xyz"}
    of_elements = {f"element-{axis}": [arb(0), arb(1)] for axis in "ijk"}
    return of_axes | of_elements | {"pauli-vector": [length, -length]}


def products(p: Parameters, q_matrix: ComplexMatrix, length: arb) -> dict[str, ComplexMatrix]:
    """Products, sums and conjugates of p, q and r, and the inverse and unit quaternion of q.

    `length` is |q|. Rows that are different formulas of one value (the two ways to bracket p q r,
    the real 4 x 4 and the complex 2 x 2 product) have the same matrix here.
    """
    p_matrix = of_numbers(vector(p, "p"))
    r_matrix = of_numbers(vector(p, "r"))
    product = p_matrix * q_matrix
    reversed_product = q_matrix * p_matrix
    of_product = {
        "p-q": product,
        "q-p": reversed_product,
        "commutator": product - reversed_product,
        "q-r": q_matrix * r_matrix,
        "left": product * r_matrix,
        "right": product * r_matrix,
        # (p q)* = q* p*
        "conjugate-of-product": conjugated(q_matrix) * conjugated(p_matrix),
        "real-product": product,
        "complex-product": product,
    }
    return of_product | {
        "sum": p_matrix + q_matrix,
        "conjugate-of-sum": conjugated(p_matrix) + conjugated(q_matrix),
        # q^-1 = q*/|q|^2
        "inverse": conjugated(q_matrix) / (length * length),
        # q q^-1 = 1
        "one": of_numbers((Fraction(1),) + (Fraction(0),) * 3),
        "u": q_matrix / length,
    }


def rates(p: Parameters, u: ComplexMatrix) -> dict[str, ComplexMatrix]:
    """The first and second time derivatives of the unit quaternion u, and products with them.

    The parameters `omega` [rad/s] and `rise` [rad/s^2] are the angular velocity and its derivative,
    in space axes.
    """
    omega = of_numbers(vector(p, "omega"))
    omega_rate = of_numbers(vector(p, "rise"))
    two = arb(2)
    # (1.67): u' = omega u/2, and u'' = (omega' u + omega u')/2 = (omega' u + omega^2 u/2)/2.
    rate = omega * u / two
    second_rate = (omega_rate * u + omega * omega * u / two) / two
    # The row "back" is computed from the rotation matrix, which is the same for u and -u. Of these
    # the quaternion with w >= 0 is taken.
    if numbers_of(u)[0] < 0:
        back = -u
    else:
        back = u
    return {
        "-u": -u,
        "back": back,
        "turned-twice": u * u,
        "rate": rate,
        "second-rate": second_rate,
        "rate-conjugate": conjugated(rate),
        "u-conjugate": conjugated(u),
        # u u'* = -omega/2 and u' u* = omega/2, so that their sum is 0.
        "u-rate": u * conjugated(rate),
        "rate-u": rate * conjugated(u),
        "anticommute": omega - omega,
    }


def rotation_rows(
    p: Parameters, q_matrix: ComplexMatrix, length: arb, u: ComplexMatrix
) -> dict[str, list[arb]]:
    """Vectors rotated by u, the rotation matrix and Euler's angles of u, and omega in both axes.

    `length` is |q| and u = q/|q|; `omega` [rad/s] is given in space axes.
    """
    v = of_numbers(vector(p, "vector"))
    omega = of_numbers(vector(p, "omega"))
    # The complex matrix of q has the eigenvalues w +- i |(x, y, z)|.
    w, *imaginary = numbers_of(q_matrix)
    imaginary_square = sum((x * x for x in imaginary), arb(0))
    # Column k of the rotation matrix is the rotated unit vector along axis k.
    unit_vectors = [of_numbers([Fraction(int(i == k)) for i in range(3)]) for k in range(3)]
    columns = [rotated(u, unit_vector) for unit_vector in unit_vectors]
    matrix = [columns[k][i] for i in range(3) for k in range(3)]
    rotated_once = rotated(u, v)
    return {
        "absolute": [length],
        "complex-eigenvalue": [w, imaginary_square.sqrt()],
        "rotated": rotated_once,
        "rotated-by-minus-u": rotated_once,
        "matrix": matrix,
        "euler": euler(u),
        "rotated-twice": rotated(u, of_balls(rotated_once)),
        # The scalar product of u and u' is 0, because |u| = 1.
        "orthogonal": [arb(0)],
        "omega-back": numbers_of(omega)[1:],
        # omega_body = u* omega u
        "omega-body": rotated(conjugated(u), omega),
    }


def listed(rows: Mapping[str, Sequence[arb]]) -> dict[str, arb]:
    """Rows as quantities: `name` for a row of one number, else `name.0`, `name.1` and so on."""
    quantities: dict[str, arb] = {}
    for name, numbers in rows.items():
        if len(numbers) == 1:
            quantities[name] = numbers[0]
        else:
            for i, number in enumerate(numbers):
                quantities[f"{name}.{i}"] = number
    return quantities


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters p, q, r (quaternions), vector, omega [rad/s], rise [rad/s^2].

    `scale` maps every quantity to the size against which its error counts.
    """
    return Timeless(
        Refiner.of(scale),
        lambda: listed(values(p)),
        witness="Hamilton's products in rational arithmetic",
    )
