"""Rods in a plane in angles: theta is measured from (0, -1), and a rod of length l is the vector l
(sin theta, -cos theta).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FITS = 1e-9
"""Relative error of lengths and speeds at the start that counts as rounding."""


def inconsistent(arm: Array, relative_velocity: Array, length: float) -> str | None:
    """None if a rod fits its start: the vector (3,) [m] to its end and that end's velocity relative
    to the other one; else the reason.
    """
    distance = float(np.linalg.norm(arm))
    if abs(distance - length) > FITS * length:
        return f"a rod of length {length} starts {distance} long"
    speed = float(np.linalg.norm(relative_velocity))
    if abs(float(arm @ relative_velocity)) > FITS * length * speed:
        return "a rod starts with a speed along it"
    return None


def directions_and_rates(arms: Array, relative_velocities: Array) -> tuple[Array, Array]:
    """Sine and cosine (N, 2) of the angles of rods, and their rates (N,), from vectors and relative
    velocities (N, 3) of their ends.
    """
    length = np.linalg.norm(arms, axis=1, keepdims=True)
    directions = np.stack([arms[:, 0], -arms[:, 1]], axis=1) / length
    # theta' = (r x v)_z/r^2.
    moment = arms[:, 0] * relative_velocities[:, 1] - arms[:, 1] * relative_velocities[:, 0]
    return directions, moment / np.sum(arms**2, axis=1)


def turned(rods_at_start: Array, states: Array) -> tuple[Array, Array]:
    """Vectors (T, N, 3) [m] of rods, and the velocities of their ends relative to each other.

    `rods_at_start` (N, 2) are l (sin theta0, cos theta0); `states` (T, 2 N) are the turns since and
    their rates.
    """
    turn, rate = np.split(states, 2, axis=1)
    sine = np.sin(turn)
    cosine = np.cos(turn)
    zero = np.zeros_like(turn)
    # l sin(theta0 + turn) and l cos(theta0 + turn); the rod is (x, -down).
    x = rods_at_start[:, 0] * cosine + rods_at_start[:, 1] * sine
    down = rods_at_start[:, 1] * cosine - rods_at_start[:, 0] * sine
    rods = np.stack([x, -down, zero], axis=2)
    return rods, rate[..., None] * np.stack([down, x, zero], axis=2)
