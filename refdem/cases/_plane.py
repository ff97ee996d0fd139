"""What the cases of one point in the plane share: x, y, vx and vy of body 0."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.quantity import Quantity
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]


def quantities(length: float, speed: float) -> tuple[Quantity, ...]:
    """Place and velocity, on the scales [m] and [m/s]."""
    kinds = (("", "m", length), ("v", "m/s", speed))
    return tuple(
        Quantity(f"{kind}{axis}", unit, size) for kind, unit, size in kinds for axis in "xy"
    )


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """Place and velocity at the samples (T,)."""
    x, y, _ = trajectory.position[:, 0].T
    vx, vy, _ = trajectory.velocity[:, 0].T
    return {"x": x, "y": y, "vx": vx, "vy": vy}
