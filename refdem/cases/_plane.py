"""What the cases of one body in the plane share: x, y, vx, vy of body 0, and omega if it turns."""

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity
from refdem.core.trajectory import Trajectory
from refdem.truth.exact import number

Array = NDArray[np.float64]

TURN = Fraction("6.283185307179586476925286766559005768394338798750211641949889")
"""2 pi, to so many digits that 1e30 turns are known to 1e-29 rad."""


def sine_and_cosine(p: Parameters, name: str) -> tuple[Any, Any]:
    """Sine and cosine of an angle [rad], or of a vector of angles, each rounded from the exact one.

    Whole turns are taken off before the angle is a double: of 1000 rad that is off by 1e-13.
    """
    exact = p[name]
    theta: Any
    if isinstance(exact, tuple):
        theta = np.array([_within_a_turn(angle) for angle in exact])
    else:
        theta = _within_a_turn(number(p, name))
    return np.sin(theta), np.cos(theta)


def _within_a_turn(angle: Fraction) -> float:
    """The angle [rad] less whole turns, in [-pi, pi]."""
    return float(angle - round(angle / TURN) * TURN)


def quantities(length: float, speed: float) -> tuple[Quantity, ...]:
    """The quantities x, y and vx, vy on the scales `length` [m] and `speed` [m/s]."""
    return (
        Quantity("x", "m", length),
        Quantity("y", "m", length),
        Quantity("vx", "m/s", speed),
        Quantity("vy", "m/s", speed),
    )


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """Place and velocity at the samples (T,)."""
    x, y, _ = trajectory.position[:, 0].T
    vx, vy, _ = trajectory.velocity[:, 0].T
    return {"x": x, "y": y, "vx": vx, "vy": vy}


def quantities_with_spin(length: float, speed: float, spin: float) -> tuple[Quantity, ...]:
    """The quantities x, y, vx, vy and omega, which is on the scale `spin` [rad/s]."""
    return (*quantities(length, speed), Quantity("omega", "rad/s", spin))


def observe_with_spin(trajectory: Trajectory) -> dict[str, Array]:
    """Place, velocity and angular velocity about z at the samples (T,)."""
    return observe(trajectory) | {"omega": trajectory.omega[:, 0, 2]}
