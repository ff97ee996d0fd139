"""Running one method on a motion, and its largest difference from certified truth."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Scene


@pytest.fixture
def solved() -> Callable[..., Trajectory]:
    """`solved(scene, times, method, step)` runs one method of the reference."""

    def run(scene: Scene, times: object, method: str, step: float | None = None) -> Trajectory:
        trajectory, _ = ENGINE.run(
            Request(problem=Motion(scene, np.asarray(times, float)), method=method, step=step)
        )
        return trajectory

    return run


@pytest.fixture
def largest_error() -> Callable[..., float]:
    """`largest_error(case, trajectory, names, **parameters)`: the largest difference from truth,
    each over its scale.
    """

    def worst(case: str, trajectory: Trajectory, names: tuple[str, ...], **given: str) -> float:
        instance = discovery.case(case).at(**given)
        seen = instance.observe(trajectory)
        truth = instance.truth()
        largest = 0.0
        for row, t in enumerate(trajectory.t):
            balls = truth.at(Fraction(float(t)))
            for name in names:
                off = abs(balls[name].mid - Fraction(float(seen[name][row]))) + balls[name].radius
                largest = max(largest, float(off) / instance.quantities[name].scale)
        return largest

    return worst
