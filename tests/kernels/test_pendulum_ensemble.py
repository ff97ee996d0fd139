"""The kernel of many pendulums against a plain numpy twin: any number of stages up to the most, and
of members beside whole blocks.
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from refdem.kernels import load, pointer

Array = NDArray[np.float64]
FAMILY = "pendulum_ensemble"
MOST_STAGES = 63
BLOCK = 512


def advanced(weights: Array, square: float, h: float, steps: int, angle: Array, rate: Array) -> int:
    """The status of the kernel, which advances angles [rad] and rates [rad/s] in place."""
    status: int = load(FAMILY).lib.refdem_pendulum_ensemble(
        len(weights),
        pointer(FAMILY, weights[: len(weights) // 2 + 1].copy()),
        square,
        h,
        steps,
        len(angle),
        pointer(FAMILY, angle, output=True),
        pointer(FAMILY, rate, output=True),
    )
    return status


def plain(
    weights: Array, square: float, h: float, steps: int, angle: Array, rate: Array
) -> tuple[Array, Array]:
    """For each stage half of its drift, its kick, and the other half."""
    for _ in range(steps):
        for weight in weights:
            angle = angle + weight * h / 2 * rate
            rate = rate - weight * h * square * np.sin(angle)
            angle = angle + weight * h / 2 * rate
    return angle, rate


def symmetric_weights(stages: int) -> Array:
    """Weights that read the same from both ends, some below zero; their sum is 1."""
    half = np.cos(np.arange(stages // 2 + 1) * 1.7) + 0.3
    both = np.concatenate([half[: stages // 2], half[::-1]])
    weights: Array = both / both.sum()
    return weights


@pytest.mark.parametrize("stages", [1, 3, 17, MOST_STAGES])
@pytest.mark.parametrize("members", [1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 3])
@pytest.mark.parametrize("h", [0.0625, -0.0625])
def test_it_moves_as_the_twin_does(stages: int, members: int, h: float) -> None:
    """Over many turns in both senses, at rest, and next to the top."""
    weights = symmetric_weights(stages)
    angle = np.linspace(-np.pi, np.pi, members)
    rate = np.linspace(-40.0, 50.0, members)[::-1].copy()
    expected = plain(weights, 2.25, h, 5, angle, rate)
    assert advanced(weights, 2.25, h, 5, angle, rate) == 0
    np.testing.assert_allclose(angle, expected[0], atol=1e-11)
    np.testing.assert_allclose(rate, expected[1], atol=1e-11)


def test_more_stages_than_it_has_room_for_are_refused_and_change_nothing() -> None:
    angle = np.array([0.5])
    rate = np.array([0.25])
    assert advanced(symmetric_weights(MOST_STAGES + 2), 1.0, 0.125, 3, angle, rate) == 1
    assert (angle.tolist(), rate.tolist()) == ([0.5], [0.25])
