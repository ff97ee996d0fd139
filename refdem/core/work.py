"""Work that drives and dashpots do along a run, integrated between its samples.

W(t) = int P dt, with the power P = F . v of every force that has no potential. Energy less W is
conserved.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.core.once import once_with_arguments
from refdem.core.trajectory import Trajectory
from refdem.mechanics.interpolation import between_samples
from refdem.scene import Scene

Array = NDArray[np.float64]

WINDOW = 4
"""Samples through which each polynomial goes: degree 7."""
EVENLY = 5.0
"""Safety factor on the reduction of changes, which may be smaller in one interval than over the
whole run.
"""
SAFETY = 1.5
"""Factor on the last change of the work.

Measured on 1371 driven oscillators of van der Pol, whose samples are up to 2 rad of their fastest
motion apart: the error is at most 0.68 of the uncertainty; of the last change alone it is up to 11
times as much, where that is small by chance.
"""
GAUSS_NODES = 8
"""Places in each interval at which the power is taken (Gauss and Legendre)."""


@dataclass(frozen=True, eq=False)
class Work:
    """Work (T,) [J] on the scene since the first sample, and a bound (T,) [J] on its error."""

    done: Array
    uncertainty: Array


def work_along(scene: Scene, run: Trajectory) -> Work | None:
    """The work of all forces without a potential along a run of points; None if it cannot be
    computed from the samples. It is computed once for each run.

    It cannot be computed if some force does not follow from position and velocity (contacts,
    friction that sticks), if bodies turn, or if there are fewer than five samples.

    With W_m the work in an interval by polynomials through m samples, the uncertainty of an
    interval is

        SAFETY max(|W_4 - W_3|, r |W_3 - W_2|),

    the largest of the interval and its two neighbours, plus round-off; `uncertainty` is its sum
    over the intervals. Neighbours are included since a difference may pass zero in one interval,
    and the second difference since the first may be small in all of them. The reduction r is EVENLY
    times the ratio of the largest values of both differences in the run, at most 1. It is 1 where a
    force is singular, such as a drag at a turning point of the motion, since higher degrees are
    then no more accurate. For close samples of a smooth motion the error is smaller than the first
    difference by two orders of the interval.
    """
    is_turning = bool(np.any(scene.bodies.inertia > 0))
    if is_turning or len(run.t) <= WINDOW:
        return None
    return _work_of_points(run, scene)


@once_with_arguments
def _work_of_points(run: Trajectory, scene: Scene) -> Work | None:
    """The same for a run of points with samples enough."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_NODES)
    parts = []
    for window in (WINDOW, WINDOW - 1, WINDOW - 2):
        part = _interval_work(scene, run, nodes, weights, window)
        if part is None:
            return None
        parts.append(part)
    # With W_m the work by polynomials through m samples, in each interval:
    #     last = |W_4 - W_3|,   before = |W_3 - W_2|,
    #     change = SAFETY max(last, reduction before).
    fine, coarse, coarsest = parts
    last = np.abs(fine - coarse)
    before = np.abs(coarse - coarsest)
    reduction = 1.0
    if not scene.singularities() and np.any(before):
        reduction = min(1.0, EVENLY * float(np.max(last) / np.max(before)))
    changes = SAFETY * np.maximum(last, reduction * before)
    rounding = GAUSS_NODES * np.finfo(float).eps * np.abs(fine)
    uncertainty = of_neighbours(changes) + rounding
    return Work(done=_summed(fine), uncertainty=_summed(uncertainty))


def of_neighbours(intervals: Array) -> Array:
    """The largest (T - 1,) of each interval and of the one on either side of it."""
    padded = np.pad(intervals, 1)
    largest: Array = np.maximum.reduce([padded[:-2], intervals, padded[2:]])
    return largest


def _summed(intervals: Array) -> Array:
    """Sums (T,) up to each sample of what T - 1 intervals add."""
    return np.concatenate([[0.0], np.cumsum(intervals)])


def _interval_work(
    scene: Scene, run: Trajectory, nodes: Array, weights: Array, window: int
) -> Array | None:
    """Work (T - 1,) [J] in every interval, by Gauss's rule along the interpolated motion."""
    times, position, velocity = between_samples(run.t, run.position, run.velocity, nodes, window)
    flat_times = times.ravel()
    bodies = run.position.shape[1:]
    flat_position = position.reshape(-1, *bodies)
    flat_velocity = velocity.reshape(-1, *bodies)
    total = np.zeros_like(flat_times)
    for element in scene.elements:
        power = element.power(flat_times, flat_position, flat_velocity)
        if power is None:
            return None
        total += power
    # int P dt = (t_k+1 - t_k)/2 sum w_g P(t_g).
    half_intervals = np.diff(run.t) / 2
    work: Array = half_intervals * (total.reshape(times.shape) @ weights)
    return work


def fastest_drive(scene: Scene) -> float:
    """The largest angular frequency [rad/s] of a periodic drive; 0 without one."""
    return max((getattr(element, "frequency", 0.0) for element in scene.elements), default=0.0)
