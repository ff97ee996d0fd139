"""What the cases of one body in the plane share: x, y, vx, vy of body 0, and omega if it turns."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.quantity import Quantity
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]


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
