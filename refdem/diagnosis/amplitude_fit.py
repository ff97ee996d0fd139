"""The amplitude of a fault that a run shows: least squares over the states, on a window that grows
with the run.
"""

from collections.abc import Callable
from math import inf

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]
Difference = Callable[[float, int], Array | None]
"""Twin less run (M,) at an amplitude over so many samples; None if such a twin cannot run."""

PROBE = 1e-4
"""The amplitude whose effect gives the direction in which a fault moves a run."""
ALIGNED = 0.9
"""A fault whose effect and the run's defect have a smaller cosine is not followed further."""
UNEXPLAINED = 0.3
"""Part of the defect of a window. A fault that leaves more than this part unexplained is not in the
code."""
ROUNDS = 6
"""Rounds of the secant method on each window."""
SETTLED = 1e-13
"""A change of the amplitude, relative to it, that no longer matters."""
LARGEST = 1e3
"""Largest amplitude, in units of the fault of the catalogue: beyond it the fault is another one."""


def states(instance: Instance, run: Trajectory, like: Trajectory) -> Array:
    """Position, velocity, attitude and omega (T, M) of a run in their scales; attitudes with the
    sign that is nearer to `like`.
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
    """Numbers of samples, growing: from where the defect (T,) first shows clearly to the whole
    run.
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
    """The amplitude at which a twin comes nearest to the run.

    It is looked for on the shortest window of `counts` samples, and followed to the longest. 0 if
    the fault does not act; None if no amplitude of it explains the defect of the run.
    """
    plain = difference(0.0, counts[0])
    probe, moved = _probed(difference, counts[0])
    if plain is None or moved is None:
        return None
    effect = (moved - plain) / probe
    if not np.any(effect):
        return 0.0
    effect_norm = float(np.linalg.norm(effect))
    defect_norm = float(np.linalg.norm(plain))
    # The cosine between effect and defect: the code does not have a fault that moves a run in
    # another direction.
    projection = float(effect @ plain)
    if defect_norm == 0 or abs(projection) < ALIGNED * effect_norm * defect_norm:
        return None
    # Least squares of |plain + a effect|^2: a = -effect.plain/|effect|^2.
    a = -projection / effect_norm**2
    for count in counts:
        a = _refined(difference, count, a)
        if not abs(a) <= LARGEST or not _explains(difference, count, a):
            return None
    return a


def _explains(difference: Difference, count: int, amplitude: float) -> bool:
    """True if the fault at this amplitude explains most of the defect over `count` samples; other
    faults are not followed to the end of the run.
    """
    defect = difference(0.0, count)
    remainder = difference(amplitude, count)
    if defect is None or remainder is None:
        return False
    return float(np.linalg.norm(remainder)) <= UNEXPLAINED * float(np.linalg.norm(defect))


def _probed(difference: Difference, count: int) -> tuple[float, Array | None]:
    """A small amplitude, and the difference of the twin at that amplitude from the run (M,), None
    if neither sign of the amplitude can run.

    The amplitude is negative where a positive one makes a number too large for the scene.
    """
    upwards = difference(PROBE, count)
    if upwards is not None:
        return PROBE, upwards
    return -PROBE, difference(-PROBE, count)


def _refined(difference: Difference, count: int, start: float) -> float:
    """The amplitude of least squares over `count` samples, by secants from one that is near.

    `inf` if it is lost.
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
        # d(a) = difference at the amplitude a is nearly a line: slope d' = (d1 - d0)/(a1 - a0), and
        # the least |d1 + d' step|^2 is at step = -d'.d1/|d'|^2.
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
