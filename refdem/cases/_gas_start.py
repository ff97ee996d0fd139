"""How a gas begins: places without overlap and Maxwell's velocities, both from numpy's PCG64 and
the seed, momentum exactly zero.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.errors import UsageError
from refdem.mechanics.neighbours import near_pairs
from refdem.scene import Sphere
from refdem.scene.bodies import Bodies

Array = NDArray[np.float64]

TRIES = 1000
"""Rounds in which those that overlap are put elsewhere; each leaves about 8 times the packing
fraction of them.
"""
GRID = 2.0**-40
"""Of a power of two near the thermal speed: velocities are whole multiples, so that sums of up to
1e6 of them are exact.
"""


def places(
    rng: np.random.Generator, n: int, diameter: float, size: float, *, periodic: bool
) -> Array:
    """Positions (N, 3) [m] in a box from 0 to `size`: uniform, put anew while a sphere overlaps one
    of a lower number.

    Raises UsageError for a box that is too full for that.
    """
    low, high = (0.0, size) if periodic else (diameter / 2, size - diameter / 2)
    found = rng.uniform(low, high, (n, 3))
    again = None
    for _ in range(TRIES):
        i, j = near_pairs(found, diameter * (1 + 1e-9), size if periodic else 0.0, again)
        if not len(i):
            return found
        again = np.unique(np.maximum(i, j))
        found[again] = rng.uniform(low, high, (len(again), 3))
    raise UsageError(
        f"parameter density: {n} spheres found no place without overlap after {TRIES} rounds;"
        " expected a gas that is less dense"
    )


def velocities(rng: np.random.Generator, n: int, mean_square: float) -> Array:
    """Velocities (N, 3) [m/s], Gaussian, with sum exactly zero and sum of squares 3 (N - 1)
    `mean_square`, to 1e-11.
    """
    speed = np.sqrt(mean_square)
    drawn = rng.standard_normal((n, 3))
    drawn -= drawn.mean(axis=0)
    drawn *= speed * np.sqrt(3 * (n - 1) / np.sum(drawn * drawn))
    grid = GRID * 2.0 ** np.ceil(np.log2(speed))
    whole = np.round(drawn / grid)
    for axis in range(3):
        left = int(whole[:, axis].sum())
        whole[: abs(left) % n, axis] -= np.sign(left)
        whole[:, axis] -= np.sign(left) * (abs(left) // n)
    velocity: Array = whole * grid
    return velocity


def bodies(position: Array, velocity: Array, mass: float, diameter: float) -> Bodies:
    """Equal homogeneous spheres at rest in rotation, as columns."""
    n = len(position)
    moment = mass * diameter**2 / 10
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    columns = {
        "position": position,
        "velocity": velocity,
        "attitude": attitude,
        "omega": np.zeros((n, 3)),
    }
    shape = (Sphere(radius=diameter / 2),) * n
    return Bodies(
        mass=np.full(n, mass),
        inertia=np.full((n, 3), moment),
        shape=shape,
        fixed=np.zeros(n, bool),
        **columns,
    )
