"""What the methods for free bodies share: centres move uniformly, each attitude is a kernel's."""

from abc import abstractmethod
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer, repeats
from refdem.scene import Bodies
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


class FreeBodies(Solver):
    """Bodies on which nothing acts.

    `turn` fills in the attitude and omega of one of them, and says how long the kernel took.
    """

    def unsupported(self, problem: Motion) -> str | None:
        """None if nothing acts on any body."""
        scene = problem.scene
        if scene.elements:
            return f"{scene.elements[0].kind} acts on the bodies; only free bodies are done"
        if scene.bodies.fixed.any():
            return "a body is fixed"
        return None

    @abstractmethod
    def turn(self, request: Request, number: int, attitude: Array, omega: Array) -> float:
        """Fills attitude (T, 4) and omega (T, 3) [rad/s] of one body that spins; seconds in the
        kernel.
        """

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Centres at x0 + v (t - t0), attitudes by `turn` for the bodies that spin."""
        begun = perf_counter()
        t = request.problem.times
        bodies = request.problem.scene.bodies
        position = bodies.position + bodies.velocity * (t - t[0])[:, None, None]
        velocity, attitude, omega = (
            np.repeat(column[None], len(t), axis=0)
            for column in (bodies.velocity, bodies.attitude, bodies.omega)
        )
        seconds = 0.0
        for number in spinning(bodies):
            alone = len(bodies) == 1
            if alone:
                turned = attitude.reshape(-1, 4)
            else:
                turned = np.empty((len(t), 4))
            if alone:
                rate = omega.reshape(-1, 3)
            else:
                rate = np.empty((len(t), 3))
            seconds += self.turn(request, number, turned, rate)
            if not alone:
                attitude[:, number] = turned
                omega[:, number] = rate
        if request.step is None:
            steps = 0
        else:
            steps = request.stride * (len(t) - 1)
        setup = perf_counter() - begun - repeats() * seconds
        found = Trajectory(
            t=t, position=position, velocity=velocity, attitude=attitude, omega=omega
        )
        return found, Cost(seconds=seconds, setup=setup, steps=steps)


class SteppedFreeBodies(FreeBodies):
    """Bodies that turn by the steps of one function of kernels/rigid_body.c."""

    kernels = ("rigid_body",)

    @property
    @abstractmethod
    def function(self) -> str:
        """Name of the kernel's function."""

    def unsupported(self, problem: Motion) -> str | None:
        """None if nothing acts on any body and some body turns."""
        reason = super().unsupported(problem)
        if reason:
            return reason
        if "rotation" not in problem.scene.features:
            return "nothing turns; uniform motion needs no steps"
        return None

    def turn(self, request: Request, number: int, attitude: Array, omega: Array) -> float:
        """Attitude (T, 4) and omega (T, 3) after every `stride` steps."""
        state = [
            pointer("rigid_body", column)
            for column in first_state(request.problem.scene.bodies, number)
        ]
        out = [pointer("rigid_body", column, output=True) for column in (attitude, omega)]
        steps = getattr(load("rigid_body").lib, self.function)
        started = perf_counter()
        steps(*state, request.signed_step, len(request.problem.times), request.stride, *out)
        return perf_counter() - started


def spinning(bodies: Bodies) -> list[int]:
    """Numbers of the bodies that turn at all."""
    return [int(number) for number in np.flatnonzero(bodies.omega.any(axis=1))]


def first_state(bodies: Bodies, number: int) -> tuple[Array, Array, Array]:
    """Principal inertia (3,), attitude (4,) and omega (3,) of one body, each contiguous."""
    return (
        bodies.inertia[number].copy(),
        bodies.attitude[number].copy(),
        bodies.omega[number].copy(),
    )
