"""Two answers to one request agree bit by bit, but for the sign of an attitude."""

from dataclasses import replace

import numpy as np

from refdem.core.trajectory import Trajectory
from refdem.engines.external.leaks import _difference

HALF = 0.5**0.5
RUN = Trajectory(
    t=np.array([0.0, 1.0]),
    position=np.zeros((2, 1, 3)),
    velocity=np.zeros((2, 1, 3)),
    attitude=np.array([[[1.0, 0.0, 0.0, 0.0]], [[HALF, HALF, 0.0, 0.0]]]),
    omega=np.zeros((2, 1, 3)),
)


def test_the_opposite_quaternion_is_the_same_attitude():
    flipped = RUN.attitude * np.array([1.0, -1.0])[:, None, None]
    assert _difference(RUN, replace(RUN, attitude=flipped)) == ""


def test_another_attitude_is_a_difference_that_names_its_place():
    turned = RUN.attitude.copy()
    turned[1, 0, 1] = np.nextafter(HALF, 1.0)
    said = _difference(RUN, replace(RUN, attitude=turned))
    assert said.startswith("attitude[1][0][1] at t = 1 s")
