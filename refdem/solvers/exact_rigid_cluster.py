"""Points that rods join to one free rigid body, by the closed form of the free body
(kernels/free_body.c).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.mechanics.quaternion import matrix
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.solvers._scene_pattern import SOME, ScenePattern, SceneSolver
from refdem.solvers._single_point import Array

FITS = 1e-9
"""Relative error of lengths and speeds at the start that counts as rounding."""
START = np.array([1.0, 0.0, 0.0, 0.0])
"""The identity attitude: principal axes at the start."""


class ExactRigidCluster(SceneSolver):
    """The centre of mass moves uniformly and the points rotate about it.

    Rod forces follow from the accelerations; those of redundant rods by least squares.
    """

    claims = Method(
        name="exact-rigid-cluster",
        summary="points on rods as one free rigid body in closed form: Jacobi and theta functions",
        control="exact",
        conserves=frozenset({"energy", "momentum", "angular-momentum", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("free_body",)

    pattern = ScenePattern(elements={Rod: SOME}, only_points=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for points not in one plane that rods hold as one body, else the reason."""
        scene = problem.scene
        if any(rod.b < 0 for rod in scene.all(Rod)):
            return "a rod to the world; expected rods between the points"
        return _not_rigid(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and the force [N] of every rod at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = np.ascontiguousarray(request.problem.times)
        centre, centre_velocity, arms, tensor, omega = _initial_cluster(scene)
        moments, axes = np.linalg.eigh(tensor)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        attitude = np.empty((len(t), 4))
        omega_body = np.empty((len(t), 3))
        inputs = [
            pointer("free_body", np.ascontiguousarray(column))
            for column in (moments, START, axes.T @ omega)
        ]
        outputs = [pointer("free_body", column, output=True) for column in (attitude, omega_body)]
        started = perf_counter()
        load("free_body").lib.refdem_free_body(
            *inputs, t[0], len(t), pointer("free_body", t), *outputs
        )
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        # The kernel's attitude Q maps the principal axes at the start to those at t. In space the
        # rotation is R = A Q A^T; the columns of A are the principal axes at the start.
        rotation = axes @ matrix(attitude) @ axes.T
        arms_now = np.einsum("tij,nj->tni", rotation, arms)
        omega_space = omega_body @ axes.T
        # v = V + omega x R r, and r = R0 + V t + R r with the initial arm r.
        velocity = centre_velocity + np.cross(omega_space[:, None], arms_now)
        position = (centre + np.outer(t - t[0], centre_velocity))[:, None] + arms_now
        position[0] = scene.bodies.position
        velocity[0] = scene.bodies.velocity
        channels = {"rod_force": _tension(scene, arms_now, velocity)}
        return Trajectory.of_points(t, position, velocity, channels=channels), cost


def _initial_cluster(scene: Scene) -> tuple[Array, Array, Array, Array, Array]:
    """The cluster at the start: centre of mass, its velocity, arms from it (N, 3), inertia tensor
    (3, 3), omega (3,).

    Means are computed from differences to the heaviest point, and arms as means of differences. The
    rounding then stays small relative to the arms, also far from the origin and for a point almost
    at the centre of mass.
    """
    mass = scene.bodies.mass
    bodies = scene.bodies
    weight = mass / mass.sum()
    heaviest = int(np.argmax(mass))

    def mean(column: Array) -> Array:
        """The mass-weighted mean of a column (N, 3)."""
        return np.asarray(column[heaviest] + weight @ (column - column[heaviest]))

    def from_mean(column: Array) -> Array:
        """The column (N, 3) less its mass-weighted mean, as sum over j of weight_j (x_i - x_j)."""
        return np.asarray(np.einsum("j,ijk->ik", weight, column[:, None] - column))

    arms = from_mean(bodies.position)
    rates = from_mean(bodies.velocity)
    # J = sum m (r^2 1 - r r^T), and J omega = sum m r x v.
    squares = np.einsum("n,nk,nk->", mass, arms, arms)
    tensor = squares * np.eye(3) - np.einsum("n,ni,nj->ij", mass, arms, arms)
    omega = np.linalg.solve(tensor, mass @ np.cross(arms, rates))
    return mean(bodies.position), mean(bodies.velocity), arms, tensor, omega


def _jacobian(scene: Scene, arms: Array) -> Array:
    """Constraint Jacobian G (T, rods, N, 3): the unit vector of each rod at its ends, with opposite
    signs.
    """
    rods = scene.all(Rod)
    rows = np.zeros((len(arms), len(rods), len(scene.bodies), 3))
    for index, rod in enumerate(rods):
        direction = arms[:, rod.a] - arms[:, rod.b]
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        rows[:, index, rod.a] = direction
        rows[:, index, rod.b] = -direction
    return rows


def _not_rigid(scene: Scene) -> str | None:
    """None if the rods hold every point, have their lengths, and the points move as one body, else
    the reason.
    """
    bodies = scene.bodies
    n = len(scene.bodies)
    rows = _jacobian(scene, bodies.position[None])[0].reshape(len(scene.all(Rod)), 3 * n)
    # A rigid body has 6 degrees of freedom: the rods must remove the other 3 n - 6.
    if n < 4 or np.linalg.matrix_rank(rows, tol=FITS) < 3 * n - 6:
        return "the rods do not make one rigid body of the points"
    for rod in scene.all(Rod):
        length = float(rod.distance(bodies.position[None], bodies.attitude[None])[0])
        if abs(length - rod.length) > FITS * rod.length:
            return f"a rod of length {rod.length} starts {length} long"
    _, drift, arms, _, omega = _initial_cluster(scene)
    residual = np.abs(bodies.velocity - drift - np.cross(omega, arms)).max()
    if residual > FITS * np.linalg.norm(omega) * np.abs(arms).max():
        return "a rod starts with a speed along it"
    return None


def _tension(scene: Scene, arms: Array, velocity: Array) -> Array:
    """Tension (T, rods) [N] of the rods from the accelerations of rotation.

    A rod of length l keeps its length if e.(a1 - a2) = -|v1 - v2|^2/l. With accelerations -M^-1 G^T
    T this is G M^-1 G^T T = |v1 - v2|^2/l, solved by least squares.
    """
    rods = scene.all(Rod)
    jacobian = _jacobian(scene, arms)
    weighted = jacobian / scene.bodies.mass[:, None]
    coupling = np.einsum("tink,tjnk->tij", jacobian, weighted)
    centripetal = []
    for rod in rods:
        relative = velocity[:, rod.a] - velocity[:, rod.b]
        centripetal.append(np.sum(relative**2, axis=1) / rod.length)
    inverse = np.linalg.pinv(coupling, hermitian=True, rcond=1e-12)
    tension: Any = np.einsum("tij,tj->ti", inverse, np.stack(centripetal, axis=1))
    return np.ascontiguousarray(tension)


METHOD = ExactRigidCluster()
