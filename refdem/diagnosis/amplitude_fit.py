"""The amplitude at which a fault explains a run, by least squares over the states, on windows of
growing length.

With the difference d(a) = twin(a) - run at the amplitude a, |d(a)|^2 is minimised.
"""

from collections.abc import Callable
from math import inf

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]
Difference = Callable[[float, int], Array | None]
"""Twin minus run (M,) at an amplitude, over a number of samples; None if the twin cannot run."""

PROBE = 1e-4
"""The amplitude of the finite difference that gives the effect of a fault on a run."""
ALIGNED = 0.9
"""Least cosine of the angle between the effect of a fault and the defect of the run."""
UNEXPLAINED = 0.3
"""Part of the defect of a window. A fault that leaves a larger part unexplained is rejected."""
ROUNDS = 6
"""Rounds of the secant method on each window."""
SETTLED = 1e-13
"""Relative change of the amplitude at which the iteration ends."""
LARGEST = 1e3
"""Largest amplitude, in units of the fault of the catalogue; larger ones are rejected."""


def states(instance: Instance, run: Trajectory, like: Trajectory) -> Array:
    """Position, velocity, attitude and omega (T, M) of a run in units of their scales. Of the
    quaternions q and -q the one nearer to that of `like` is taken.
    """
    scales = instance.scales
    count = len(run.t)
    columns = [run.position / scales.length, run.velocity / scales.speed]
    if "rotation" in instance.scene.features:
        nearer = np.where(
            np.sum(run.attitude * like.attitude, axis=-1, keepdims=True) < 0, -1.0, 1.0
        )
        columns += [run.attitude * nearer, run.omega * scales.tau]
    return np.concatenate([column.reshape(count, -1) for column in columns], axis=1)


def windows(defect: Array) -> list[int]:
    """Growing numbers of samples, from the first clear defect to the whole run.

    The first window ends just after the defect (T,) reaches 2 % of its maximum; each next one is
    twice as long.
    """
    whole = len(defect)
    shown = np.flatnonzero(defect >= 0.02 * defect.max(initial=0.0))
    if len(shown):
        count = max(3, int(shown[0]) + 2)
    else:
        count = whole
    counts = []
    while count < whole:
        counts.append(count)
        count *= 2
    return [*counts, whole]


def amplitude(difference: Difference, counts: list[int]) -> float | None:
    """The amplitude of least distance between twin and run.

    It is found on the shortest window of `counts` samples and refined on each longer one. 0 if the
    fault does not act; None if no amplitude explains the defect of the run.
    """
    plain = difference(0.0, counts[0])
    probe, moved = _probed(difference, counts[0])
    if plain is None or moved is None:
        return None
    # effect = (d(probe) - d(0))/probe, about dd/da.
    effect = (moved - plain) / probe
    if not np.any(effect):
        return 0.0
    effect_norm = float(np.linalg.norm(effect))
    defect_norm = float(np.linalg.norm(plain))
    # The cosine between effect and defect is effect . d(0)/(|effect| |d(0)|). A small one excludes
    # the fault.
    projection = float(effect @ plain)
    if defect_norm == 0 or abs(projection) < ALIGNED * effect_norm * defect_norm:
        return None
    # The minimum of |d(0) + a effect|^2 is at a = -effect . d(0)/|effect|^2.
    a = -projection / effect_norm**2
    for count in counts:
        a = _refined(difference, count, a)
        if not abs(a) <= LARGEST or not _explains(difference, count, a):
            return None
    return a


def _explains(difference: Difference, count: int, amplitude: float) -> bool:
    """True if |d(a)| <= UNEXPLAINED |d(0)| over `count` samples."""
    defect = difference(0.0, count)
    remainder = difference(amplitude, count)
    if defect is None or remainder is None:
        return False
    return float(np.linalg.norm(remainder)) <= UNEXPLAINED * float(np.linalg.norm(defect))


def _probed(difference: Difference, count: int) -> tuple[float, Array | None]:
    """A small amplitude, and the difference of the twin at that amplitude from the run (M,), None
    if neither sign of the amplitude can run.

    It is negative if a positive one makes a number of the scene inadmissible.
    """
    upwards = difference(PROBE, count)
    if upwards is not None:
        return PROBE, upwards
    return -PROBE, difference(-PROBE, count)


def _refined(difference: Difference, count: int, start: float) -> float:
    """The amplitude of least squares over `count` samples, by secants from a near one; `inf` if the
    twin cannot run at some iterate.
    """
    before = start * (1.0 - 1e-3)
    last = start
    old = difference(before, count)
    new = difference(last, count)
    for _ in range(ROUNDS):
        if old is None or new is None:
            return inf
        if last == before:
            return last
        # With d' = (d1 - d0)/(a1 - a0) the minimum of |d1 + d' step|^2 is at step = -d' .
        # d1/|d'|^2.
        slope = (new - old) / (last - before)
        steepness = float(slope @ slope)
        if steepness == 0 or not np.isfinite(steepness):
            return last
        step = -float(slope @ new) / steepness
        before = last
        old = new
        last = last + step
        if abs(step) <= SETTLED * abs(last):
            return last
        new = difference(last, count)
    return last
