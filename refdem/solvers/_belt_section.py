"""Poincare section of a point on a belt for many drive frequencies, with the largest Lyapunov
exponent (kernels/stick_slip.c).
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.poincare import Exponent, exponent
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall
from refdem.solvers.stick_slip import FAMILY, belt_law

Array = NDArray[np.float64]
BLOCKS = 16
"""Blocks of the recorded time; the growth of a tangent vector is summed in each, for a standard
error.
"""
PER_PERIOD = 8
"""Largest number of passages v = 0, x > 0 that are recorded per period of the drive."""


class Section(NamedTuple):
    """The section at M drive `frequency` (M,) [rad/s].

    `places` holds, for each, the positions x > 0 [m] from the spring's anchor at which v = 0;
    `exponent` the Lyapunov exponents (M,) [1/s] with their errors.
    """

    frequency: Array
    places: tuple[Array, ...]
    exponent: Exponent


def section(scene: Scene, frequency: Array, *, skip: int, keep: int, workers: int = 2) -> Section:
    """The section over `keep` periods of the drive, after `skip` periods of transient, for
    frequencies (M,) > 0.
    """
    axis = np.array(scene.all(Slider)[0].axis)
    origin = float(axis @ single.anchor(scene.all(Spring)[0]))
    x0 = float(axis @ scene.bodies.position[0]) - origin
    v0 = float(axis @ scene.bodies.velocity[0])
    start = [x0, v0]

    def blockwise(frequencies: Array) -> tuple[list[Array], Array]:
        return _part(scene, frequencies, origin, start, skip, keep)

    with ThreadPoolExecutor(workers) as pool:
        results = list(pool.map(blockwise, np.array_split(frequency, 4 * workers)))
    growth = np.concatenate([block_sums for _, block_sums in results])
    places = tuple(chain.from_iterable(frequencies for frequencies, _ in results))
    # The recorded time is `keep` periods of 2 pi/eta each.
    seconds = 2 * np.pi / frequency * keep
    return Section(frequency, places, exponent(growth, seconds))


def _part(
    scene: Scene, frequency: Array, origin: float, start: list[float], skip: int, keep: int
) -> tuple[list[Array], Array]:
    """Section positions for some frequencies, and the logarithmic growths (M, BLOCKS) of a tangent
    vector.

    Runs in a thread: the kernel releases the interpreter's lock.
    """
    count = len(frequency)
    capacity = PER_PERIOD * keep
    counts = np.zeros(count)
    block_sums = np.zeros((count, BLOCKS))
    positions = np.zeros((count, capacity))
    if count:
        call = KernelCall(
            function="refdem_stick_slip_section",
            inputs=(belt_law(scene), count, frequency, origin, *start),
            clock=(skip, keep, BLOCKS, capacity),
            outputs=(counts, block_sums, positions),
        )
        call.made(FAMILY)
    return [row[: int(n)].copy() for row, n in zip(positions, counts, strict=True)], block_sums
