"""Copies of a polyhedron that falls and turns under the weights of its corners, each of which adds
those up in another order (section 1.6.4).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, permutations

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import angle_between, conjugate, product, rotated

Array = NDArray[np.float64]
CORNERS = 0.5 * np.array(
    [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float
)
"""The corners (6, 3) [m] of an octahedron in its principal axes, two opposite ones in a row."""
MASSES = np.array([5.0, 5, 3, 3, 1, 1])
"""What the corners weigh (6,) [kg]; faces and edges weigh nothing."""
INERTIA = np.array([2.0, 3.0, 4.0])
"""The principal moments (3,) [kg m^2]: J1 = sum m (y^2 + z^2), and so on."""
GRAVITY = 9.7
"""Acceleration [m/s^2] towards -z, with which the sum of the weights depends on the order."""
TILTED = np.array([1.0, 2, 3, 4]) / np.sqrt(30.0)
"""The attitude (4,) at the start: no principal axis is level or upright, so that sums of torques
round about all of them."""
SPIN = 4.0
"""The angular velocity [rad/s] about a principal axis."""
STEP = 1 / 64
"""The step [s] of the Runge-Kutta method; its relative error of a rate is (SPIN STEP)^4/120."""
ALL_ORDERS = 720
"""Orders of six corners."""
COPIES = 24
"""Copies of the body: every thirtieth order in the dictionary, first that of CORNERS, in which
opposite torques follow each other and cancel to the last bit.
"""
HEIGHT = 0
"""Where the height [m] is in a state."""
SPEED = 1
"""Where the upward velocity [m/s] is in a state."""
ATTITUDE = slice(2, 6)
"""Where the attitude, body to space, is in a state."""
OMEGA = slice(6, 9)
"""Where the angular velocity [rad/s] in body axes is in a state."""
NEXT = np.array([1, 2, 0])
"""The axis that follows each principal axis (3,), in cyclic order."""
LAST = np.array([2, 0, 1])
"""The axis after that."""


@dataclass(frozen=True, eq=False)
class Copies:
    """Heights (T, N) [m] of the centres and attitudes (T, N, 4) of N copies at t (T,) [s]."""

    t: Array
    height: Array
    attitude: Array

    @property
    def distance(self) -> Array:
        """How far the centres (T, N - 1) are from that of the first copy [m]."""
        return np.abs(self.height[:, 1:] - self.height[:, :1])

    @property
    def angle(self) -> Array:
        """The rotations (T, N - 1) [rad] from the attitude of the first copy to the others'."""
        return angle_between(self.attitude[:, 1:], self.attitude[:, :1])


def orders() -> NDArray[np.int64]:
    """The orders of summation (COPIES, 6), as numbers of corners."""
    chosen = islice(permutations(range(len(CORNERS))), 0, None, ALL_ORDERS // COPIES)
    return np.array(list(chosen))


def fallen(axes: Sequence[int], duration: float) -> list[Copies]:
    """The motion of all copies from rest at height 0, for each of the principal `axes` (0 to 2)
    about which they turn at first.
    """
    count = round(duration / STEP)
    corner_order = orders()
    body = _Body(np.tile(corner_order, (len(axes), 1)))
    state = np.concatenate([_start(axis) for axis in axes])
    history = np.empty((count + 1, *state.shape))
    history[0] = state
    for n in range(count):
        state = _stepped(body, state)
        history[n + 1] = state
    t = STEP * np.arange(count + 1, dtype=np.float64)
    of_axes = np.split(history, len(axes), axis=1)
    return [Copies(t, each[:, :, HEIGHT], each[:, :, ATTITUDE]) for each in of_axes]


def _start(axis: int) -> Array:
    """States (COPIES, 9) at rest, TILTED, with the SPIN about one axis."""
    state = np.zeros((COPIES, 9))
    state[:, ATTITUDE] = TILTED
    state[:, OMEGA.start + axis] = SPIN
    return state


def _stepped(body: "_Body", state: Array) -> Array:
    """The states after a STEP of the classical Runge-Kutta method (Kutta 1901)."""
    k1 = body.rates(state)
    k2 = body.rates(state + STEP / 2 * k1)
    k3 = body.rates(state + STEP / 2 * k2)
    k4 = body.rates(state + STEP * k3)
    after: Array = state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return after


class _Body:
    """The octahedron, with the corners of each copy in its order of summation (N, 6)."""

    def __init__(self, corner_order: NDArray[np.int64]) -> None:
        self.corner = CORNERS[corner_order]
        self.weight = -GRAVITY * MASSES[corner_order]
        self.acceleration = _added(self.weight) / MASSES.sum()

    def rates(self, state: Array) -> Array:
        """The derivatives (N, 9): the weights and their torques about the centre, added one by one,
        and Euler's equations (1.35)-(1.37).
        """
        q = state[:, ATTITUDE]
        omega = state[:, OMEGA]
        arm = rotated(q[:, None, :], self.corner)
        # The torque arm x (0, 0, weight).
        torque = np.zeros((len(q), 3))
        torque[:, 0] = _added(arm[..., 1] * self.weight)
        torque[:, 1] = -_added(arm[..., 0] * self.weight)
        rate = np.empty_like(state)
        rate[:, HEIGHT] = state[:, SPEED]
        rate[:, SPEED] = self.acceleration
        # q' = q (0, omega_body)/2.
        spin = np.zeros_like(q)
        spin[:, 1:] = omega
        rate[:, ATTITUDE] = 0.5 * product(q, spin)
        # J omega' = torque - omega x J omega, in body axes.
        gyroscopic = (INERTIA[NEXT] - INERTIA[LAST]) * omega[:, NEXT] * omega[:, LAST]
        rate[:, OMEGA] = (rotated(conjugate(q), torque) + gyroscopic) / INERTIA
        return rate


def _added(terms: Array) -> Array:
    """The sums (N,) of terms (N, 6), from the first to the last."""
    total = np.zeros(len(terms))
    for term in terms.T:
        total = total + term
    return total
