"""The Poincare section of a point on a belt over the frequency of its drive, with the largest
Lyapunov exponent (kernels/stick_slip.c).
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
"""Parts of the time kept over which the growth of a tangent is taken."""
PER_PERIOD = 8
"""Passages v = 0, x > 0 a period for which there is room."""


class Section(NamedTuple):
    """Frequencies (M,) [rad/s]; for each, places x > 0 [m] from the spring's anchor + `origin` at
    which v = 0; exponents (M,) [1/s].
    """

    frequency: Array
    places: tuple[Array, ...]
    exponent: Exponent


def section(scene: Scene, frequency: Array, *, skip: int, keep: int, workers: int = 2) -> Section:
    """The section after `skip` periods of the drive over `keep` more, for every frequency (M,) > 0
    of the scene's force.
    """
    axis = np.array(scene.all(Slider)[0].axis)
    origin = float(axis @ single.anchor(scene.all(Spring)[0]))
    place = float(axis @ scene.bodies.position[0]) - origin
    speed = float(axis @ scene.bodies.velocity[0])
    start = [place, speed]

    def part(own: Array) -> tuple[list[Array], Array]:
        return _part(scene, own, origin, start, skip, keep)

    with ThreadPoolExecutor(workers) as pool:
        parts = list(pool.map(part, np.array_split(frequency, 4 * workers)))
    growth = np.concatenate([sums for _, sums in parts])
    places = tuple(chain.from_iterable(own for own, _ in parts))
    seconds = 2 * np.pi / frequency * keep
    return Section(frequency, places, exponent(growth, seconds))


def _part(
    scene: Scene, frequency: Array, origin: float, start: list[float], skip: int, keep: int
) -> tuple[list[Array], Array]:
    """Places of some frequencies, and growths (M, BLOCKS); the kernel leaves the interpreter to
    other threads.
    """
    count = len(frequency)
    most = PER_PERIOD * keep
    counts = np.zeros(count)
    sums = np.zeros((count, BLOCKS))
    out = np.zeros((count, most))
    if count:
        call = KernelCall(
            function="refdem_stick_slip_section",
            inputs=(belt_law(scene), count, frequency, origin, *start),
            clock=(skip, keep, BLOCKS, most),
            outputs=(counts, sums, out),
        )
        call.made(FAMILY)
    return [row[: int(n)].copy() for row, n in zip(out, counts, strict=True)], sums
