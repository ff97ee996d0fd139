"""Points that rods hold as one rigid body, on which nothing acts: the free body's closed form
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
"""Part of a length, or of a speed, by which the start may miss what rigid rods allow: rounding."""
START = np.array([1.0, 0.0, 0.0, 0.0])


class ExactRigidCluster(SceneSolver):
    """Centre of mass in a straight line, all else turned about it; rod forces from the
    accelerations, of least squares if redundant.
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

    def unfit(self, problem: Motion) -> str | None:
        """None for points that are not in one plane, all held by rods."""
        scene = problem.scene
        if any(rod.b < 0 for rod in scene.all(Rod)):
            return "a rod to the world; expected rods between the points"
        return _loose(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and the force [N] of every rod at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = np.ascontiguousarray(request.problem.times)
        place, drift, arms, tensor, omega = _body(scene)
        moments, axes = np.linalg.eigh(tensor)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        attitude = np.empty((len(t), 4))
        spin = np.empty((len(t), 3))
        given = [
            pointer("free_body", np.ascontiguousarray(column))
            for column in (moments, START, axes.T @ omega)
        ]
        out = [pointer("free_body", column, output=True) for column in (attitude, spin)]
        started = perf_counter()
        load("free_body").lib.refdem_free_body(*given, t[0], len(t), pointer("free_body", t), *out)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        turn = axes @ matrix(attitude) @ axes.T
        away = np.einsum("tij,nj->tni", turn, arms)
        omega_space = spin @ axes.T
        velocity = drift + np.cross(omega_space[:, None], away)
        position = (place + np.outer(t - t[0], drift))[:, None] + away
        position[0] = scene.bodies.position
        velocity[0] = scene.bodies.velocity
        channels = {"rod_force": _tension(scene, away, velocity)}
        return Trajectory.of_points(t, position, velocity, channels=channels), cost


def _body(scene: Scene) -> tuple[Array, Array, Array, Array, Array]:
    """Centre of mass, its velocity, the points about it (N, 3), tensor of inertia (3, 3) and omega
    (3,) at the start.

    By differences from the heaviest point: far from the origin the mean of the places would be
    rounded on their scale. Arms and rates are means of differences: of a point that is nearly the
    centre of mass they are small, and rounded as such.
    """
    mass = scene.bodies.mass
    bodies = scene.bodies
    part = mass / mass.sum()
    base = int(np.argmax(mass))

    def mean(column: Array) -> Array:
        return np.asarray(column[base] + part @ (column - column[base]))

    def from_mean(column: Array) -> Array:
        return np.asarray(np.einsum("j,ijk->ik", part, column[:, None] - column))

    arms = from_mean(bodies.position)
    rates = from_mean(bodies.velocity)
    # J = sum m (r^2 1 - r r^T), and J omega = sum m r x v.
    squares = np.einsum("n,nk,nk->", mass, arms, arms)
    tensor = squares * np.eye(3) - np.einsum("n,ni,nj->ij", mass, arms, arms)
    omega = np.linalg.solve(tensor, mass @ np.cross(arms, rates))
    return mean(bodies.position), mean(bodies.velocity), arms, tensor, omega


def _rows(scene: Scene, away: Array) -> Array:
    """Constraint Jacobian (T, rods, N, 3): the direction of each rod at its ends."""
    rods = scene.all(Rod)
    rows = np.zeros((len(away), len(rods), len(scene.bodies), 3))
    for number, rod in enumerate(rods):
        apart = away[:, rod.a] - away[:, rod.b]
        apart = apart / np.linalg.norm(apart, axis=1, keepdims=True)
        rows[:, number, rod.a] = apart
        rows[:, number, rod.b] = -apart
    return rows


def _loose(scene: Scene) -> str | None:
    """None if the rods hold every point, have their lengths, and the points move as one body."""
    bodies = scene.bodies
    n = len(scene.bodies)
    rows = _rows(scene, bodies.position[None])[0].reshape(len(scene.all(Rod)), 3 * n)
    if n < 4 or np.linalg.matrix_rank(rows, tol=FITS) < 3 * n - 6:
        return "the rods do not make one rigid body of the points"
    for rod in scene.all(Rod):
        found = float(rod.distance(bodies.position[None], bodies.attitude[None])[0])
        if abs(found - rod.length) > FITS * rod.length:
            return f"a rod of length {rod.length} starts {found} long"
    _, drift, arms, _, omega = _body(scene)
    off = np.abs(bodies.velocity - drift - np.cross(omega, arms)).max()
    if off > FITS * np.linalg.norm(omega) * np.abs(arms).max():
        return "a rod starts with a speed along it"
    return None


def _tension(scene: Scene, away: Array, velocity: Array) -> Array:
    """Tension (T, rods) [N]: what makes the points turn, G M^-1 G^T T = |relative
    velocity|^2/length, of least squares.
    """
    rods = scene.all(Rod)
    rows = _rows(scene, away)
    weighted = rows / scene.bodies.mass[:, None]
    coupling = np.einsum("tink,tjnk->tij", rows, weighted)
    wanted = []
    for rod in rods:
        relative = velocity[:, rod.a] - velocity[:, rod.b]
        wanted.append(np.sum(relative**2, axis=1) / rod.length)
    inverse = np.linalg.pinv(coupling, hermitian=True, rcond=1e-12)
    solved: Any = np.einsum("tij,tj->ti", inverse, np.stack(wanted, axis=1))
    return np.ascontiguousarray(solved)


METHOD = ExactRigidCluster()
