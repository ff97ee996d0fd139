"""Slips of the source chapter about attitudes and spins: matrices, quaternions, an ellipsoid.

Each has the measurement that settles it, made on demand.
"""

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.core.discovery import truth_of
from refdem.manual.slip import KnownSlip, Measured, norm, number, vector, vector_of
from refdem.mechanics.quaternion import conjugate, matrix, product, rotated

Array = NDArray[np.float64]
INERTIA = np.array([1.0, 2.0, 3.0])
"""Principal moments [kg m^2] of the case free-rigid-body at its defaults."""


def orthogonal_columns_and_determinant() -> Measured:
    """What a matrix with orthogonal columns and determinant 1 does to a length, and what a mirror
    with determinant -1 does.
    """
    e_x = np.array([1.0, 0.0])
    # A = diag(2, 1/2) has columns with a . b = 0, and det A = 2 x 1/2 = 1, but |A e_x| = 2.
    stretch = np.diag([2.0, 0.5])
    column_a, column_b = stretch.T
    scalar_product = float(column_a @ column_b)
    stretch_determinant = float(np.linalg.det(stretch))
    stretched_length = norm(stretch @ e_x)
    # M (x, y) = (y, x) has det M = -1, and |M e_x| = |e_y| = 1.
    mirror = np.array([[0.0, 1.0], [1.0, 0.0]])
    mirror_determinant = float(np.linalg.det(mirror))
    mirrored_length = norm(mirror @ e_x)
    return (
        ("scalar product of the columns of diag(2, 1/2)", number(scalar_product)),
        ("its determinant", number(stretch_determinant)),
        ("|diag(2, 1/2) e_x|", number(stretched_length)),
        ("determinant of the mirror that exchanges x and y", number(mirror_determinant)),
        ("|mirror e_x|", number(mirrored_length)),
    )


def minus_conjugate_turns_back() -> Measured:
    """Where e_y goes under a turn by +90 degrees about x, by q, by -q and by -q*."""
    # cos and sin of half the angle, 45 degrees.
    half = math.sqrt(0.5)
    q = np.array([half, half, 0.0, 0.0])
    e_y = np.array([0.0, 1.0, 0.0])
    return (
        ("e_y turned by q = (cos, +sin e_x)", vector(rotated(q, e_y))),
        ("e_y turned by -q", vector(rotated(-q, e_y))),
        ("e_y turned by -q* = (-cos, +sin e_x)", vector(rotated(-conjugate(q), e_y))),
    )


def body_axes_have_second_rates() -> Measured:
    """q'' on a certified motion: from omega in body axes with Euler's equations, and from five
    certified attitudes.
    """
    truth = truth_of("free-rigid-body")
    now = truth.at(Fraction(1))
    q = vector_of(now, "attitude", "wxyz")
    omega = vector_of(now, "omega_body", "xyz")
    # Euler's equations without torque: J omega' = J omega x omega.
    omega_rate = np.cross(INERTIA * omega, omega) / INERTIA
    # q' = q (0, omega)/2, so q'' = (q' (0, omega) + q (0, omega'))/2.
    q_rate = product(q, _pure(omega)) / 2
    second = (product(q_rate, _pure(omega)) + product(q, _pure(omega_rate))) / 2
    h = Fraction(1, 256)
    before2, before, after, after2 = (
        vector_of(truth.at(1 + n * h), "attitude", "wxyz") for n in (-2, -1, 1, 2)
    )
    # The second difference of five points: its error is h^4 q^(6)/90.
    difference = 16 * (before + after) - (before2 + after2) - 30 * q
    by_differences = difference / (12 * float(h) ** 2)
    return (
        ("q'' [1/s^2] from omega in body axes, t = 1 s of the free rigid body", vector(second)),
        ("q'' [1/s^2] by differences of certified attitudes", vector(by_differences)),
    )


def pure_quaternions_do_not_anticommute() -> Measured:
    """The two claims before (1.88) on a certified motion, and the two identities that carry it."""
    motion = truth_of("free-rigid-body").at(Fraction(1))
    q = vector_of(motion, "attitude", "wxyz")
    omega = vector_of(motion, "omega", "xyz")
    # q' = (0, omega) q/2, omega in space axes.
    q_rate = product(_pure(omega), q) / 2
    a = product(q_rate, conjugate(q))
    place = np.array([1.0, 2.0, 3.0])
    r = _pure(place)
    both_orders = product(a, r) + product(r, a)
    commutator = product(a, r) - product(r, a)
    cross = 2 * np.cross(a[1:], place)
    conjugate_rate = conjugate(q_rate)
    exchanged = product(conjugate_rate, q) - product(q, conjugate_rate)
    opposite = product(q, conjugate_rate) + product(q_rate, conjugate(q))
    what = "a = q' q* and r = (0, 1, 2, 3) at t = 1 s of the free rigid body"
    return (
        (f"|a r + r a|, {what}", number(norm(both_orders))),
        ("2 |a . r|", number(2 * abs(float(a[1:] @ place)))),
        ("|q'* q - q q'*|", number(norm(exchanged))),
        ("|(a r - r a) - 2 a x r|", number(norm(commutator[1:] - cross))),
        ("|q q'* + q' q*|", number(norm(opposite))),
    )


def which_ellipsoid_rolls() -> Measured:
    """How far the tangent plane at the tip of omega, and that at the tip of L, turns in space and
    moves from the centre in 3 s of a certified motion.

    The normal of sum J omega^2 = 2 T at omega is L, and that of sum L^2/J = 2 T at L is omega.
    """
    truth = truth_of("free-rigid-body")
    spins = []
    momenta = []
    for t in (0, 3):
        balls = truth.at(Fraction(t))
        turn = matrix(vector_of(balls, "attitude", "wxyz"))
        omega = vector_of(balls, "omega", "xyz")
        spins.append(omega)
        momenta.append(turn @ (INERTIA * (turn.T @ omega)))
    products = [float(omega @ L) for omega, L in zip(spins, momenta, strict=True)]
    by_momentum = products[1] / norm(momenta[1]) - products[0] / norm(momenta[0])
    by_spin = products[1] / norm(spins[1]) - products[0] / norm(spins[0])
    of_omega = "ellipsoid sum J omega^2 = 2 T"
    of_momentum = "ellipsoid (1.138), sum L^2/J = 2 T"
    return (
        (f"{of_omega}: turn of the tangent plane in 3 s [rad]", number(_angle(*momenta))),
        (f"{of_omega}: change of its distance [rad/s]", number(by_momentum)),
        (f"{of_momentum}: turn of the tangent plane in 3 s [rad]", number(_angle(*spins))),
        (f"{of_momentum}: change of its distance [kg m^2/s]", number(by_spin)),
    )


def _pure(v: Array) -> Array:
    """The pure quaternion (0, v) of a vector (3,)."""
    return np.array([0.0, *v])


def _angle(u: Array, v: Array) -> float:
    """The angle [rad] between two vectors (3,), accurate where it is small."""
    return math.atan2(norm(np.cross(u, v)), float(u @ v))


SLIPS = (
    KnownSlip(
        cases=("rotations",),
        where="section 1.3.1, after (1.10)",
        says=(
            "columns that are orthogonal make the matrix orthogonal, its determinant is 1, and"
            " therefore lengths stay"
        ),
        holds=(
            "the columns must have length 1 as well, the determinant is 1 or -1, and what keeps"
            " lengths is that the inverse is the transpose: determinant 1 keeps areas"
        ),
        measure=orthogonal_columns_and_determinant,
    ),
    KnownSlip(
        cases=("quaternions", "rotations"),
        where="caption of figure 1.13",
        says="q and -q* are one rotation, as an axis and its opposite",
        holds=(
            "-q* turns back, as q* does; the opposite angle about the opposite axis is q itself,"
            " and -q is the other quaternion of the same rotation"
        ),
        measure=minus_conjugate_turns_back,
    ),
    KnownSlip(
        cases=("quaternions", "free-rigid-body"),
        where="section 1.3.9, on quaternions in body axes",
        says="in body axes the higher derivatives that predictor-correctors need are missing",
        holds=(
            "q'' = (q' omega + q omega')/2 with Euler's equations for omega': the derivatives are"
            " as available as in space axes"
        ),
        measure=body_axes_have_second_rates,
    ),
    KnownSlip(
        cases=("quaternions",),
        where="before (1.88)",
        says=(
            "q and the conjugate of its rate commute, and pure quaternions change sign when their"
            " product is taken in the other order"
        ),
        holds=(
            "neither: a r + r a = -2 a . r, and only the cross product changes sign; (1.88) rests"
            " on a r - r a = 2 a x r and on q q'* = -q' q*"
        ),
        measure=pure_quaternions_do_not_anticommute,
    ),
    KnownSlip(
        cases=("free-rigid-body", "intermediate-axis"),
        where="section 1.7.3, on Poinsot",
        says="the ellipsoid of L, (1.138), is the one that rolls on a plane",
        holds=(
            "what rolls on a plane fixed in space is the ellipsoid of omega, sum J omega^2 = 2 T,"
            " whose normal at omega is L; the tangent plane of (1.138) has the normal omega, which"
            " wanders"
        ),
        measure=which_ellipsoid_rolls,
    ),
)
