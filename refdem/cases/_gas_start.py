"""The initial state of a gas: positions without overlap, Maxwell's velocities, momentum exactly
zero; both drawn from numpy's PCG64 with the seed.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.errors import UsageError
from refdem.mechanics.neighbours import near_pairs
from refdem.scene import Sphere
from refdem.scene.bodies import Bodies

Array = NDArray[np.float64]

TRIES = 1000
"""Rounds in which overlapping spheres are drawn anew; each leaves a fraction of them that is about
8 times the packing fraction.
"""
GRID = 2.0**-40
"""Spacing of the velocities in units of a power of two near the thermal speed: they are whole
multiples of it, so that sums of up to 1e6 of them are exact.
"""


def places(
    rng: np.random.Generator, n: int, diameter: float, edge: float, *, periodic: bool
) -> Array:
    """Positions (N, 3) [m] in the cube [0, edge]^3: uniform, and drawn anew for a sphere that
    overlaps one of a lower number, until none does.

    Raises UsageError for a box that is too full for that.
    """
    if periodic:
        low = 0.0
        high = edge
        period = edge
    else:
        # A sphere keeps its radius from the walls.
        low = diameter / 2
        high = edge - diameter / 2
        period = 0.0
    position = rng.uniform(low, high, (n, 3))
    # Only spheres drawn in the last round can overlap; None stands for all of them.
    redrawn = None
    for _ in range(TRIES):
        i, j = near_pairs(position, diameter * (1 + 1e-9), period, redrawn)
        if not len(i):
            return position
        redrawn = np.unique(np.maximum(i, j))
        position[redrawn] = rng.uniform(low, high, (len(redrawn), 3))
    raise UsageError(
        f"parameter density: {n} spheres found no place without overlap after {TRIES} rounds;"
        " expected a gas that is less dense"
    )


def velocities(rng: np.random.Generator, n: int, mean_square: float) -> Array:
    """Gaussian velocities (N, 3) [m/s] whose sum is exactly zero.

    Their sum of squares is 3 (N - 1) `mean_square` [m^2/s^2] to 1e-11.
    """
    speed = np.sqrt(mean_square)
    drawn = rng.standard_normal((n, 3))
    drawn -= drawn.mean(axis=0)
    drawn *= speed * np.sqrt(3 * (n - 1) / np.sum(drawn * drawn))
    # Rounded to whole multiples of a grid, the velocities have an exact sum. What is left of it is
    # taken off in equal parts, and its remainder by one unit from each of the first bodies.
    grid = GRID * 2.0 ** np.ceil(np.log2(speed))
    multiples = np.round(drawn / grid)
    for axis in range(3):
        total = int(multiples[:, axis].sum())
        multiples[: abs(total) % n, axis] -= np.sign(total)
        multiples[:, axis] -= np.sign(total) * (abs(total) // n)
    velocity: Array = multiples * grid
    return velocity


def bodies(position: Array, velocity: Array, mass: float, diameter: float) -> Bodies:
    """Equal homogeneous spheres, which do not spin, at these positions and velocities (N, 3)."""
    n = len(position)
    # J = 2/5 m R^2 = m D^2/10.
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
