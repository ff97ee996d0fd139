"""Runs of REBOUND on scenes of a few lines."""

from collections.abc import Callable

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.rebound import ENGINE
from refdem.scene import Scene

Run = Callable[..., Trajectory]


@pytest.fixture
def run() -> Run:
    """`run(scene, duration, samples, method)` gives the trajectory, duration < 0 a run backwards; a
    refusal fails the test.
    """

    def trajectory(
        scene: Scene, duration: float, samples: int, method: str, **control: float
    ) -> Trajectory:
        problem = Motion(scene, np.arange(samples + 1) * (duration / samples))
        assert ENGINE.unsupported_motion(problem, ENGINE.method(method)) is None
        request = Request(problem=problem, method=method, **control)
        found, _ = ENGINE.run(request)
        request.refuse_misaligned(found.t)
        return found

    return trajectory
