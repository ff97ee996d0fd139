"""The error of a step across a kink of the force.

A step that straddles a kink uses the force before the kink for its remainder. The place of the kink
within the step is practically random, so that one run may by chance have nearly no error, while the
same run with another step, or backward in time, has one.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.case import Instance
from refdem.core.check import Array, Subject
from refdem.core.judgement import PREDICTION_FACTOR
from refdem.core.refinement import kinked


def may_straddle(subject: Subject) -> bool:
    """True if a fixed step may go across a kink."""
    method = subject.method
    return (
        method.control == "step" and kinked(subject.instance, method) and not method.locates_events
    )


def sharpest_kink(instance: Instance) -> float:
    """The exponent n of the force |s|^n through the sharpest kink of the scene; infinite without
    one.
    """
    exponents = [limit.exponent for _, limit in instance.scene.singularities()]
    return min(exponents, default=float(np.inf))


def straddled(subject: Subject, step: float, run: Mapping[str, Array], count: int) -> Array:
    """Bound (count,) on the error of a step h [s] that straddles a kink, in units of the scales.

    `run` holds the observed quantities at that step. Within a step of its kink, a force that varies
    as |s|^n is at most (h/tau)^n of its later value, so the bound is

        PREDICTION_FACTOR min(1, h/tau)^n h max|dq/dt|,

    with the largest rate so far of any quantity q in its scale.
    """
    instance = subject.instance
    share = min(1.0, step / instance.scales.tau) ** sharpest_kink(instance)
    off: Array = PREDICTION_FACTOR * share * (_kink_rate(instance, run, count) * step)
    return off


def _kink_rate(instance: Instance, run: Mapping[str, Array], count: int) -> Array:
    """Fastest change of any quantity so far [1/s] (count,), in its scale, over the intervals beside
    each sample.

    A step that straddles a kink uses the force before the kink for its remainder. Its error is at
    most that rate times the remainder, and less where the force does not jump. Halved steps end at
    the same times, so that every step longer than the remainder has the same error: halvings do not
    show it.
    """
    fastest = np.zeros(len(instance.times) - 1)
    for name, quantity in instance.quantities.items():
        if name in run and not quantity.angle:
            fastest = np.maximum(fastest, np.abs(np.diff(run[name])) / quantity.scale)
    beside = np.maximum(np.append(0.0, fastest), np.append(fastest, 0.0))
    so_far: Array = np.maximum.accumulate(beside)[:count] / abs(instance.problem.interval)
    return so_far
