"""Answers to questions without time: rotation algebra, degrees of freedom and bifurcations by the
functions of `mechanics`, and points of Poincare sections by a motion.
"""

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Identity, Request
from refdem.core.static_problems import results
from refdem.core.trajectory import Cost, Trajectory
from refdem.mechanics import freedom, koenig, mass_properties, response, rotation
from refdem.mechanics.multiple_angle import (
    cosine_by_powers,
    cosine_by_recurrence,
    cosine_product,
    cosines_mixed,
)
from refdem.mechanics.period_doubling import doubling_point, share_below, two_cycle
from refdem.mechanics.quaternion import conjugate, matrix, product, rotated
from refdem.mechanics.vectors import rejection
from refdem.solvers import _belt_points
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


def turn(axis: Array, angle: Array) -> Array:
    """The rotation matrix (3, 3) about a unit vector by an angle (1,) [rad]."""
    return matrix(rotation.about_axis_quaternion(axis, angle[0]))


def plane(angle: Array) -> Array:
    """The rotation matrix (2, 2) by an angle (1,) [rad]."""
    return rotation.about_axis(2, angle[0])[:2, :2]


def mirror(angle: Array) -> Array:
    """The reflection matrix (2, 2) about the line at this angle from x: R(2 angle) diag(1, -1)."""
    return plane(2 * angle) * (1, -1)


def upper_eigenvalue(eigenvalues: NDArray[Any]) -> Array:
    """Real part, and imaginary part >= 0, of the first of two conjugate eigenvalues."""
    return np.array([eigenvalues[0].real, abs(eigenvalues[0].imag)])


def falling(eigenvalues: NDArray[Any]) -> Array:
    """The real parts of eigenvalues, the largest first."""
    return np.sort(eigenvalues.real)[::-1]


def real_and_imaginary(z: complex) -> Array:
    """Real and imaginary part (2,) of a complex number."""
    return np.array([z.real, z.imag])


def turn_angle(m: Array) -> Array:
    """Angle (1,) [rad] of a rotation matrix, 2 atan2(|vector part|, w) of its quaternion."""
    q = rotation.quaternion_of_matrix(m)
    return np.array([2 * np.arctan2(np.linalg.norm(q[1:]), q[0])])


def complex_product(p: Array, q: Array) -> Array:
    """The product of quaternions by the product of their complex matrices.

    The first column of the matrix of (w, x, y, z) is (w - i z, y - i x).
    """
    (first, _), (second, _) = rotation.complex_matrix(p) @ rotation.complex_matrix(q)
    return np.array([first.real, -second.imag, second.real, -first.imag])


def pure(v: Array) -> Array:
    """The quaternion (0, v) (4,) of a vector (3,)."""
    return np.concatenate([[0.0], v])


def pairs(rods: Array) -> list[tuple[int, int]]:
    """The pairs of points that the rods (2 R,) connect."""
    return [(int(a), int(b)) for a, b in rods.reshape(-1, 2)]


def balanced_drives(amplitude: Array, spring: Array, force: Array) -> Array:
    """The two drives (2,) [rad/s] of an amplitude (1,) on a spring (alpha, beta, delta)."""
    alpha, beta, delta = spring
    return np.concatenate(response.balanced_drives(amplitude, alpha, beta, delta, force[0]))


def balanced_forces(amplitude: Array, spring: Array, drives: Array) -> list[float]:
    """The forces that give an amplitude (1,) at each of the drives (2,) [rad/s]."""
    alpha, beta, delta = spring
    return [response.balanced_force(amplitude[0], drive, alpha, beta, delta) for drive in drives]


def fold(side: str, spring: Array, force: Array) -> Array:
    """Drive and amplitude (2,) of the lower or the upper fold; nan where there is none."""
    alpha, beta, delta = spring
    found = response.folds(alpha, beta, delta, force[0])
    if found is None:
        return np.full(2, np.nan)
    return np.array(getattr(found, side))


def square(m: Array) -> Array:
    """The matrix (3, 3) of nine numbers (9,), row by row."""
    return m.reshape(3, 3)


def vectors(numbers: Array) -> Array:
    """The vectors (N, 3) of three numbers a point (3 N,)."""
    return numbers.reshape(-1, 3)


ANSWERS: dict[str, Callable[..., Any]] = {
    "sum": np.add,
    "dot": np.dot,
    "difference": np.subtract,
    "quotient": np.divide,
    "scalar-sum": np.add,
    "vector-sum": np.add,
    "vector-difference": np.subtract,
    "vector-dot": np.dot,
    "cross": np.cross,
    # Lagrange's identity: |v x w|^2 = (v . v)(w . w) - (v . w)^2.
    "cross-square": lambda v, w: (v @ v) * (w @ w) - (v @ w) ** 2,
    "rejection": lambda a, b: rejection(tuple(a), tuple(b)),
    "length": lambda v: math.hypot(*v),
    # R(a) v, or exp(i a) (x + i y); the eigenvalues of R are exp(+-i a), its determinant is 1.
    "plane-turn": lambda angle, v: plane(angle) @ v,
    "complex-turn": lambda angle, v: real_and_imaginary(np.exp(1j * angle[0]) * complex(*v)),
    "plane-eigenvalue": lambda angle: upper_eigenvalue(np.linalg.eigvals(plane(angle))),
    "plane-determinant": lambda angle: np.linalg.det(plane(angle)),
    # The reflection R(2 a) diag(1, -1), with the determinant -1.
    "mirror": lambda angle, v: mirror(angle) @ v,
    "mirror-determinant": lambda angle: np.linalg.det(mirror(angle)),
    # cos(n a) in two ways, and cos(a) cos(b) = (cos(a - b) + cos(a + b))/2.
    "cosine-by-recurrence": lambda angle, n: cosine_by_recurrence(angle[0], int(n[0])),
    "cosine-by-powers": lambda angle, n: cosine_by_powers(angle[0], int(n[0])),
    "cosine-product": lambda a, b: cosine_product(a[0], b[0]),
    "cosines-mixed": lambda a, b: cosines_mixed(a[0], b[0]),
    # Matrices (3, 3), given as nine numbers row by row.
    "turn-about": turn,
    "matrix-product": lambda m, n: square(m) @ square(n),
    "matrix-difference": np.subtract,
    "matrix-vector": lambda m, v: square(m) @ v,
    "transpose": lambda m: square(m).T,
    "determinant": lambda m: np.linalg.det(square(m)),
    "turn-angle": lambda m: turn_angle(square(m)),
    # (1 + [v]) M, M^T M - 1, U V^T of M = U S V^T, and the dimension of the rates that leave M^T M
    # constant.
    "first-order-turn": lambda m, v: rotation.first_order_turn(square(m), v),
    "orthogonality": lambda m: rotation.orthogonality(square(m)),
    "nearest-turn": lambda m: rotation.nearest_turn(square(m)),
    "orthogonal-freedom": lambda m: freedom.orthogonal_freedom(square(m)),
    # Quaternions (w, x, y, z): (cos(a/2), sin(a/2) axis). The product p q is also that of the real
    # matrix (4, 4) of p with q, and that of the complex matrices (2, 2).
    "quaternion-about": lambda axis, angle: rotation.about_axis_quaternion(axis, angle[0]),
    "product": product,
    "real-product": lambda p, q: rotation.real_matrix(p) @ q,
    "complex-product": complex_product,
    # The complex matrix of q = (w, v) has the eigenvalues w +- i |v|, the Pauli matrix of v has
    # +-|v|.
    "complex-eigenvalue": lambda q: upper_eigenvalue(np.linalg.eigvals(rotation.complex_matrix(q))),
    "pauli-eigenvalues": lambda v: falling(np.linalg.eigvals(rotation.pauli_matrix(v))),
    "conjugate": conjugate,
    # q^-1 = q*/|q|^2.
    "inverse": lambda q: conjugate(q) / (q @ q),
    "absolute": np.linalg.norm,
    "unit": lambda q: q / np.linalg.norm(q),
    "negative": np.negative,
    "rotated": rotated,
    "matrix-of-quaternion": matrix,
    "quaternion-of-matrix": lambda m: rotation.quaternion_of_matrix(square(m)),
    "matrix-of-euler": lambda euler: rotation.matrix_of_euler(*euler),
    "quaternion-of-euler": lambda euler: rotation.quaternion_of_euler(*euler),
    "euler-of-matrix": lambda m: rotation.euler_of_matrix(square(m)),
    "euler-rates": lambda euler, omega: rotation.euler_rates(euler[0], euler[1], omega),
    "euler-rate-matrix": lambda euler: rotation.euler_rate_matrix(euler[0], euler[1]),
    "euler-rate-inverse": lambda euler: rotation.euler_rate_inverse(euler[0], euler[1]),
    # q' = omega q/2 with omega in space axes; q'' = (omega' q + omega q')/2, where `rise` is
    # omega'.
    "rate": rotation.quaternion_rate,
    "second-rate": (
        lambda q, omega, rise: (
            (product(pure(rise), q) + product(pure(omega), rotation.quaternion_rate(q, omega))) / 2
        )
    ),
    # omega = 2 q' q* in space axes, 2 q* q' in body axes.
    "omega-of-rate": lambda q, rate: 2 * product(rate, conjugate(q))[1:],
    "body-omega-of-rate": lambda q, rate: 2 * product(conjugate(q), rate)[1:],
    # About a principal axis: J omega^2/2, L = J omega, and L^2/(2 J).
    "rotation-energy": lambda inertia, omega: inertia * omega**2 / 2,
    "spin-momentum": np.multiply,
    "momentum-energy": lambda momentum, inertia: momentum**2 / (2 * inertia),
    "principal-moments": lambda m: mass_properties.principal_moments(square(m)),
    # Koenig: sum m v^2/2 = M V^2/2 + sum m |v - V|^2/2, with the velocity V of the centre R, and
    # sum m r x v = M R x V + sum m (r - R) x (v - V).
    "points-energy": lambda m, v: koenig.energy(m, vectors(v)),
    "centre-energy": lambda m, v: koenig.energy_of_centre(m, vectors(v)),
    "energy-about-centre": lambda m, v: koenig.energy_about_centre(m, vectors(v)),
    "points-angular-momentum": (lambda m, r, v: koenig.angular_momentum(m, vectors(r), vectors(v))),
    "centre-angular-momentum": (
        lambda m, r, v: koenig.angular_momentum_of_centre(m, vectors(r), vectors(v))
    ),
    "angular-momentum-about-centre": (
        lambda m, r, v: koenig.angular_momentum_about_centre(m, vectors(r), vectors(v))
    ),
    # sum m |omega x r|^2/2 = omega . J omega/2.
    "swept-energy": lambda m, r, omega: koenig.swept_energy(m, vectors(r), omega),
    "tensor-energy": lambda m, r, omega: koenig.tensor_energy(m, vectors(r), omega),
    # N D - rank of the Jacobian of the rods' lengths; `size` (1,) is the dimension D.
    "first-order-freedom": lambda size, x, rods: freedom.first_order_freedom(
        x.reshape(-1, int(size[0])), pairs(rods)
    ),
    "rigid-freedom": lambda size, x: freedom.rigid_freedom(x.reshape(-1, int(size[0]))),
    # Harmonic balance of Duffing's oscillator; `spring` is (alpha, beta, delta).
    "balanced-drives": balanced_drives,
    "balanced-forces": balanced_forces,
    "lower-fold": lambda spring, force: fold("lower", spring, force),
    "upper-fold": lambda spring, force: fold("upper", spring, force),
    # The map x -> eta x (1 - x): the share 2/pi asin(sqrt x) of its iterates below x at eta = 4,
    # the two iterates of the cycle of period 2, and the eta of the next doubling.
    "share-below": lambda x: share_below(x[0]),
    "two-cycle": lambda eta: two_cycle(eta[0]),
    "belt-strobe": _belt_points.strobe,
    "belt-passage": _belt_points.passage,
    "doubling-point": lambda doublings: doubling_point(int(doublings[0])),
}
"""The function that computes each operation of core.algebra."""


class RotationAlgebra(Solver):
    """Every operation of core.algebra."""

    claims = Method(
        name="rotation-algebra",
        summary="matrices, quaternions and Euler angles, exact up to rounding",
        control="exact",
        cost_rank=0,
    )
    answers = Identity

    def unsupported(self, problem: Identity) -> str | None:
        """None: every operation is supported."""
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The result of every operation."""
        problem = request.problem
        assert isinstance(problem, Identity)
        started = perf_counter()
        trajectory = Trajectory.of_values(problem.times, results(problem, ANSWERS))
        return trajectory, Cost(seconds=perf_counter() - started)


METHOD = RotationAlgebra()
