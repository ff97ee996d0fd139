"""The error of a step across a kink of the force.

A step that straddles a kink uses the force before the kink for its remainder. The place of the kink
within the step is practically random, so that one run may by chance have nearly no error, while the
same run with another step, or backward in time, has one.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from refdem.checks.contact_impulse import alternating_slip
from refdem.core.check import Array, Subject
from refdem.core.judgement import PREDICTION_FACTOR
from refdem.core.refinement import kinked
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.contact import Contact
from refdem.scene.singularity import JUMP, sharpest_exponent

OWN_SHARE = 0.1
"""Lower bound on the change at a halving, or on the rate, that is used for a single quantity, as a
part of the largest of any quantity. A smaller change of its own may be due to terms that cancel.
"""
SEVERAL = 3
"""Halvings of the step that are needed to accept a smaller lower bound, OWN_SHARE^2."""
ALIKE = 2.0
"""Largest ratio of the parts of a quantity at several halvings that count as equal."""


def may_straddle(subject: Subject) -> bool:
    """True if a fixed step may go across a kink."""
    method = subject.method
    return (
        method.control == "step" and kinked(subject.instance, method) and not method.locates_events
    )


def sharpest_kink(subject: Subject, step: float, run: Trajectory) -> float:
    """The exponent n of the force |s|^n through the sharpest kink that a run passes at this step
    [s]; infinite without one.

    Friction without a tangential spring jumps where the slip changes its sign. Where the slip of
    the run does not, the sharpest kink is that of the normal force.
    """
    scene = subject.instance.scene
    limits = [limit for _, limit in scene.singularities()]
    jumping = {limit.feature for limit in limits if limit.exponent == JUMP}
    if jumping == {"contact:friction"} and alternating_slip(subject, run, step) == 0.0:
        return min(law.exponent for law in scene.all(Contact))
    return sharpest_exponent(limits)


def least_shares(changes: Mapping[str, Sequence[Array]]) -> dict[str, Array]:
    """Lower bound (count,) on the change of each quantity, as a part of the largest change c of any
    quantity, from the `changes` so far (count,) of every quantity at each halving.

    Errors that one kink scatters have a constant ratio c_q/c at all halvings. Terms of several
    kinks that cancel by chance leave another ratio at the next halving. So a ratio that is the same
    within the factor ALIKE at SEVERAL halvings or more is taken to be genuine, however small, and
    the lower bound is OWN_SHARE^2; otherwise it is OWN_SHARE.
    """
    largest = np.maximum.reduce([np.array(own) for own in changes.values()])
    shares = {}
    for name, own in changes.items():
        # Parts c_q/c of the change c_q at each halving; none where nothing has changed.
        parts = np.divide(own, largest, out=np.zeros_like(largest), where=largest > 0)
        least, most = parts.min(axis=0), parts.max(axis=0)
        is_own = (len(parts) >= SEVERAL) & (least > 0) & (most <= ALIKE * least)
        shares[name] = np.where(is_own, OWN_SHARE**2, OWN_SHARE)
    return shares


def straddled(subject: Subject, step: float, run: Trajectory, count: int) -> dict[str, Array]:
    """Bound (count,) on the error in every quantity due to a step h [s] that straddles a kink, in
    units of its scale.

    Within a step of its kink, a force that varies as |s|^n is at most (h/tau)^n of its later value,
    so the bound is

        PREDICTION_FACTOR min(1, h/tau)^n h max|dq/dt|,

    with the largest rate so far of the quantity q in `run`, in its scale. The rate is taken to be
    at least OWN_SHARE of the largest rate of any quantity, since errors of one quantity cause
    errors of others; for an angle it is the largest rate of any quantity.
    """
    share = min(1.0, step / subject.instance.scales.tau) ** sharpest_kink(subject, step, run)
    rates = _fastest(subject, run)
    still = np.zeros(len(subject.instance.times) - 1)
    largest = np.maximum.reduce([still, *rates.values()])
    bounds = {}
    for name, quantity in subject.instance.quantities.items():
        # An angle may turn by many turns between two samples: its rate is not known.
        rate = largest
        if name in rates and not quantity.angle:
            rate = np.maximum(rates[name], OWN_SHARE * largest)
        bounds[name] = PREDICTION_FACTOR * share * step * _so_far(subject, rate, count)
    return bounds


def _fastest(subject: Subject, run: Trajectory) -> dict[str, Array]:
    """The change (T - 1,) of every quantity between samples, in its scale; angles left out.

    A step that straddles a kink uses the force before the kink for its remainder. Its error is at
    most that rate times the remainder, and less where the force does not jump. Halved steps end at
    the same times, so that every step longer than the remainder has the same error: halvings do not
    show it.
    """
    instance = subject.instance
    observed = instance.observe(run)
    return {
        name: np.abs(np.diff(observed[name])) / quantity.scale
        for name, quantity in instance.quantities.items()
        if name in observed and not quantity.angle
    }


def _so_far(subject: Subject, changes: Array, count: int) -> Array:
    """The largest rate so far [1/s] (count,), over the intervals beside each sample, of changes
    (T - 1,) between samples.
    """
    beside = np.maximum(np.append(0.0, changes), np.append(changes, 0.0))
    rates: Array = np.maximum.accumulate(beside)[:count] / abs(subject.instance.problem.interval)
    return rates
