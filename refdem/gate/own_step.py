"""A user's integrator, given by a function for one step, as an engine that the checks judge in
process.
"""

from collections.abc import Callable
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.refusal import engine_cannot
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import UsageError
from refdem.scene.acceleration import Acceleration, acceleration, unsupported_feature

Array = NDArray[np.float64]
Step = Callable[[float, Array, Array, float, Acceleration], tuple[Array, Array]]
"""`step(t, r, v, h, a)` returns the positions and velocities (N, 3) [m], [m/s] at t + h [s], where
`a(t, r, v)` are the accelerations (N, 3) [m/s^2] of all bodies."""


class OwnStep(Engine):
    """An engine for points under the forces of a scene, from a function for one step."""

    title = "Own integrator"

    def __init__(self, step: Step, method: Method) -> None:
        self.name = method.name
        self.methods = (method,)
        self.step = step

    def missing(self) -> str | None:
        """None: the function is here."""
        return None

    def version(self) -> str:
        """The name of the function."""
        return self.step.__name__

    def fingerprint(self, method: Method) -> str:
        """The name of the function; its runs are never stored."""
        return self.version()

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None for points in forces, else the unsupported feature of the scene."""
        feature = unsupported_feature(problem.scene)
        if feature is None:
            return None
        return engine_cannot(f"{feature} in a step of points")

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Makes the steps from sample to sample; raises UsageError for a step that returns anything
        but positions and velocities.
        """
        assert isinstance(request.problem, Motion)
        scene = request.problem.scene
        of_scene = acceleration(scene)
        h = request.signed_step
        start = float(request.problem.times[0])
        r = scene.bodies.position.copy()
        v = scene.bodies.velocity.copy()
        states = [(r, v)]
        began = perf_counter()
        for sample in range(len(request.problem.times) - 1):
            for number in range(request.stride):
                now = start + (sample * request.stride + number) * h
                r, v = self._checked(self.step(now, r, v, h, of_scene), r.shape)
            states.append((r, v))
        cost = Cost(seconds=perf_counter() - began)
        times = np.array([start + n * request.stride * h for n in range(len(states))])
        places, velocities = (np.array(column) for column in zip(*states, strict=True))
        return Trajectory.of_points(times, places, velocities), cost

    def _checked(self, state: object, shape: tuple[int, ...]) -> tuple[Array, Array]:
        """Positions and velocities returned by a step; raises UsageError for anything else."""
        try:
            r, v = (np.array(column, np.float64) for column in state)  # type: ignore[attr-defined]
        except (TypeError, ValueError):
            r = v = np.empty(0)
        if r.shape != shape or v.shape != shape:
            raise UsageError(
                f"{self.version()} returned {type(state).__name__}; expected two arrays of shape"
                f" {shape}: places and velocities after the step"
            )
        return r, v
