"""Plane pendulums theta'' = -w0^2 sin(theta), many starts stepped together by symplectic methods of
order 8 and 10 (kernels/pendulum_ensemble.c).

A step is a symmetric composition of Verlet steps of lengths weight_i h.
"""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Ensemble, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.solvers import _single_point as single
from refdem.solvers import carried_ensemble
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]
FAMILY = "pendulum_ensemble"
# The weights c_i of a whole step, both halves and the middle one, have the sum 1.
WEIGHTS = {
    8: (
        0.13020248308889008088,
        0.56116298177510838456,
        -0.38947496264484728641,
        0.15884190655515560090,
        -0.39590389413323757734,
        0.18453964097831570709,
        0.25837438768632204729,
        0.29501172360931029887,
        -0.60550853383003451170,
    ),
    10: (
        0.07879572252168641926,
        0.31309610341510852776,
        0.02791838323507806611,
        -0.22959284159390709415,
        0.13096206107716486317,
        -0.26973340565451071434,
        0.07497334315589143567,
        0.11199342399981020489,
        0.36613344954622675119,
        -0.39910563013603589788,
        0.10308739852747107732,
        0.41143087395589023782,
        -0.00486636058313526176,
        -0.39203335370863990644,
        0.05194250296244964704,
        0.05066509075992449634,
        0.04967437063972987905,
        0.04931773575959453792,
    ),
}
"""Weights of a step, by order: the first half and the middle one; the second half mirrors the
first. Order 8: W. Kahan and R.-C. Li, Math. Comp. 66 (1997) 1089; order 10: M. Sofroniou and G.
Spaletta, Optim. Methods Softw. 20 (2005) 597; both in Hairer, Lubich and Wanner, Geometric
Numerical Integration, V.3.2."""


def claimed(name: str, order: int) -> Method:
    """The claims of a composition of the given order."""
    return Method(
        name=name,
        summary=(
            f"pendulums stepped together: Verlet composed to order {order}, the sine in vectors"
        ),
        control="step",
        order=order,
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=10,
    )


class EnsembleSymplectic(Solver):
    """Angles and angular velocities of all starts, in blocks that fit in the cache."""

    answers = Ensemble
    kernels = (FAMILY,)

    def __init__(self) -> None:
        self.weights = np.array(WEIGHTS[self.claims.order])

    def unsupported(self, problem: Ensemble) -> str | None:
        """None for starts of one point on a rod that swings in a plane with gravity, else the
        reason.
        """
        if not problem.scene.all(Rod) or not single.gravity(problem.scene).any():
            return "no rod in gravity"
        return carried_ensemble.METHOD.unsupported(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Trajectory with `position` [m] and `velocity` [m/s] (T, M, 1, 3) of M starts."""
        begun = perf_counter()
        problem = request.problem
        assert isinstance(problem, Ensemble)
        frame = _Frame(problem.scene)
        # Drifts theta += d_i theta', kicks theta' -= c_i h w0^2 sin(theta); 2 len(weights) - 1
        # kicks.
        kernel = load(FAMILY).lib.refdem_pendulum_ensemble
        seconds = 0.0
        law = (2 * len(self.weights) - 1, pointer(FAMILY, self.weights), frame.square)
        angle, rate = frame.angles(problem.position[:, 0], problem.velocity[:, 0])
        shape = (len(problem.times), len(angle), 1, 3)
        position = np.empty(shape)
        velocity = np.empty(shape)
        position[0] = problem.position
        velocity[0] = problem.velocity
        # The kernel advances angle and rate in place, by `stride` steps from row to row.
        state = [pointer(FAMILY, column, output=True) for column in (angle, rate)]
        for row in range(1, len(problem.times)):
            started = perf_counter()
            kernel(*law, request.signed_step, request.stride, len(angle), *state)
            seconds += perf_counter() - started
            position[row, :, 0], velocity[row, :, 0] = frame.placed(angle, rate)
        cost = Cost(
            seconds=seconds,
            setup=perf_counter() - begun - seconds,
            steps=request.stride * (len(problem.times) - 1),
        )
        return (
            Trajectory.of_values(problem.times, {"position": position, "velocity": velocity}),
            cost,
        )


class _Frame:
    """The plane of the swing: unit vectors `down` along gravity and `across`, the anchor, the
    length l, and w0^2 = g/l [1/s^2] as `square`.

    A point at angle theta is at anchor + l (cos(theta) down + sin(theta) across).
    """

    def __init__(self, scene: Scene) -> None:
        rod = scene.all(Rod)[0]
        gravity = single.gravity(scene)
        arm = scene.bodies.position[0] - single.anchor(rod)
        magnitude = float(np.linalg.norm(gravity))
        self.anchor = single.anchor(rod)
        self.length = rod.length
        self.square = magnitude / rod.length
        self.down = gravity / magnitude
        # The components of arm and velocity across gravity. Both lie in the plane of the swing, so
        # that either gives its direction; the longer one is taken.
        components = [
            vector - (vector @ self.down) * self.down for vector in (arm, scene.bodies.velocity[0])
        ]
        longest = max(components, key=lambda vector: float(np.linalg.norm(vector)))
        length = np.linalg.norm(longest)
        # The zero vector if the point hangs at rest, where the direction has no effect.
        self.across = longest
        if length > 0:
            self.across = longest / length

    def angles(self, position: Array, velocity: Array) -> tuple[Array, Array]:
        """Angles [rad] and angular velocities [rad/s] (M,) of positions and velocities (M, 3)."""
        arm = position - self.anchor
        # arm = l (cos(theta) down + sin(theta) across).
        angle = np.arctan2(arm @ self.across, arm @ self.down)
        # theta' = v . (cos(theta) across - sin(theta) down)/l.
        sideways = velocity @ self.across
        downwards = velocity @ self.down
        rate = (np.cos(angle) * sideways - np.sin(angle) * downwards) / self.length
        return angle, rate

    def placed(self, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Positions and velocities (M, 3) at angles [rad] and angular velocities [rad/s] (M,)."""
        s = np.sin(angle)[:, None]
        c = np.cos(angle)[:, None]
        # r = anchor + l e and v = l theta' e', with the unit vectors e = cos(theta) down +
        # sin(theta) across along the rod and e' = de/dtheta across it.
        along = c * self.down + s * self.across
        across = c * self.across - s * self.down
        position = self.anchor + self.length * along
        velocity = (self.length * rate)[:, None] * across
        return position, velocity
