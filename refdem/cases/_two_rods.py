"""What the cases of two rods in the plane share: the angles theta1, theta2 of the rods from the
vertical, and their rates.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.quantity import Quantity

Array = NDArray[np.float64]


def quantities(tau: float) -> tuple[Quantity, ...]:
    """The angles [rad], and their rates [rad/s] on the scale 1/tau."""
    return (
        Quantity("theta1", "rad", 1.0, angle=True),
        Quantity("theta2", "rad", 1.0, angle=True),
        Quantity("thetadot1", "rad/s", 1.0 / tau),
        Quantity("thetadot2", "rad/s", 1.0 / tau),
    )


def observe(r: Array, v: Array) -> dict[str, Array]:
    """Angles and rates (T,) from the vectors r along the rods and their rates v, (T, 2, 3)."""
    theta = np.arctan2(r[..., 0], -r[..., 1])
    # theta' = (r x v)_z/r^2.
    cross = r[..., 0] * v[..., 1] - r[..., 1] * v[..., 0]
    thetadot = cross / np.sum(r[..., :2] ** 2, axis=-1)
    return {
        "theta1": theta[:, 0],
        "theta2": theta[:, 1],
        "thetadot1": thetadot[:, 0],
        "thetadot2": thetadot[:, 1],
    }
