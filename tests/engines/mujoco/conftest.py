"""Running a scene in MuJoCo, in one line."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request

ENGINE = discovery.engine("mujoco")


@pytest.fixture
def engine():
    if (reason := ENGINE.missing()) is not None:
        raise RuntimeError(f"the tests of the MuJoCo adapter need it: {reason}")
    return ENGINE


@pytest.fixture
def played(engine):
    """played(scene, step=, duration=, method=, samples=, start=) -> (trajectory, cost)."""

    def run(scene, *, step=2.0**-8, duration=2.0, method="rk4", samples=16, start=0.0):
        problem = Motion(scene, start + duration / samples * np.arange(samples + 1))
        assert engine.unsupported_motion(problem, engine.method(method)) is None
        return engine.run(Request(problem=problem, method=method, step=step))

    return run
