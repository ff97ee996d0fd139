"""Runs of pymunk on scenes of a few lines."""

from collections.abc import Callable

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.pymunk import ENGINE
from refdem.scene import Scene

Run = Callable[..., Trajectory]


@pytest.fixture
def run() -> Run:
    """`run(scene, duration, samples, step)` gives the trajectory; a refusal fails the test."""

    def trajectory(scene: Scene, duration: float, samples: int, step: float) -> Trajectory:
        problem = Motion(scene, np.arange(samples + 1) * (duration / samples))
        assert ENGINE.unsupported_motion(problem, ENGINE.methods[0]) is None
        found, cost = ENGINE.run(Request(problem=problem, method="semi-implicit-euler", step=step))
        assert cost.steps == round(duration / step)
        return found

    return trajectory
