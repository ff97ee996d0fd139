"""Common base of the methods for free bodies: centres move uniformly, and a kernel computes the
attitudes.
"""

from abc import abstractmethod
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import repeats
from refdem.scene import Bodies
from refdem.solvers._kernel_solver import KernelCall, steps_of, steps_to_samples
from refdem.solvers._scene_pattern import ScenePattern, SceneSolver

Array = NDArray[np.float64]


class FreeBodies(SceneSolver):
    """Bodies on which nothing acts; each rotates by itself, by one call of a kernel."""

    pattern = ScenePattern()

    @abstractmethod
    def turn(self, request: Request, body: int) -> KernelCall:
        """The kernel call that fills attitude (T, 4) and omega (T, 3) [rad/s] of one rotating
        body.
        """

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Centres at x0 + v (t - t0); attitude and omega from `turn` for the bodies that
        rotate.
        """
        begun = perf_counter()
        t = request.problem.times
        bodies = request.problem.scene.bodies
        # r(t) = r0 + v0 (t - t0).
        position = bodies.position + bodies.velocity * (t - t[0])[:, None, None]
        # Bodies without spin keep all of their state; the others are overwritten.
        velocity, attitude, omega = (
            np.repeat(column[None], len(t), axis=0)
            for column in (bodies.velocity, bodies.attitude, bodies.omega)
        )
        seconds = 0.0
        steps = 0
        for body in spinning(bodies):
            call = self.turn(request, body)
            spent, _ = call.answered(self.kernels[0])
            seconds += spent
            steps = call.steps
            attitude[:, body], omega[:, body] = call.outputs
        setup = perf_counter() - begun - repeats() * seconds
        trajectory = Trajectory(
            t=t, position=position, velocity=velocity, attitude=attitude, omega=omega
        )
        return trajectory, Cost(seconds=seconds, setup=setup, steps=steps)


class SteppedFreeBodies(FreeBodies):
    """Bodies that rotate by steps of one function of kernels/rigid_body.c."""

    kernels = ("rigid_body",)

    @property
    @abstractmethod
    def function(self) -> str:
        """Name of the kernel's function."""

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if some body rotates, else the reason."""
        if "rotation" not in problem.scene.features:
            return "nothing turns; uniform motion needs no steps"
        return None

    def turn(self, request: Request, body: int) -> KernelCall:
        """Attitude (T, 4) and omega (T, 3) after every `stride` steps."""
        count = len(request.problem.times)
        return KernelCall(
            function=self.function,
            inputs=first_state(request.problem.scene.bodies, body),
            clock=steps_to_samples(request),
            outputs=(np.empty((count, 4)), np.empty((count, 3))),
            steps=steps_of(request),
        )


def spinning(bodies: Bodies) -> list[int]:
    """Indices of the bodies with an angular velocity."""
    return [int(body) for body in np.flatnonzero(bodies.omega.any(axis=1))]


def first_state(bodies: Bodies, body: int) -> tuple[Array, Array, Array]:
    """Principal moments of inertia (3,), attitude (4,) and omega (3,) of one body at the start."""
    return bodies.inertia[body], bodies.attitude[body], bodies.omega[body]
