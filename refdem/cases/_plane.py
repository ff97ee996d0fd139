"""What the cases of one point in the plane share: x, y, vx and vy of body 0."""

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
