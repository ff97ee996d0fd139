"""Errors at the samples within one step after an impact, where a method of first order may still
show the velocities of before.

An engine that gathers contacts when a step begins and then advances sees an impact at t* one step
late: the bodies overlap at the end t_k of the step in which they meet, and their velocities change
in the step that follows. At a sample at t_k <= t* + h velocities are those of before. No step is so
short that this error of a velocity falls; it is the time in which it is there that falls with h,
and so does the error h v of a place, which the claim of first order covers.
"""

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from refdem.checks._crossings import crossings, is_impact
from refdem.checks._impacts import is_sequence
from refdem.core.check import Array, Subject
from refdem.core.judgement import errors, made_of_velocities
from refdem.core.refinement import ROUND_OFF_FACTOR, steps_at
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth


def errors_of(
    subject: Subject, level: float, run: Trajectory, truth: SampledTruth
) -> dict[str, Array]:
    """`judgement.errors` of a run. At samples within one step after an impact a velocity has the
    smaller of its errors against the truth of that sample and of the sample before.

    That is so for methods that may see impacts late (`may_see_late`): the velocity must be the one
    after the impact or the one before it, and places are judged as everywhere.
    """
    delay = subject.method.delay(level)
    scaled = errors(subject.instance, run, truth, delay)
    if not may_see_late(subject):
        return scaled
    late = samples_after_impacts(subject, level, truth) & (np.arange(truth.until) > 0)
    if not late.any():
        return scaled
    of_velocities = made_of_velocities(subject.instance, run)
    before = errors(subject.instance, run, sample_before(truth), delay)
    for name in of_velocities & set(scaled):
        smaller = np.minimum(scaled[name], before[name])
        scaled[name] = np.where(late, smaller, scaled[name])
    return scaled


def may_see_late(subject: Subject) -> bool:
    """True for fixed steps that claim first order and not to locate events, where rigid bodies
    meet.

    A higher order across impacts, and located events, claim that impacts are seen in time.
    """
    method = subject.method
    if method.control != "step" or method.locates_events or subject.order > 1:
        return False
    scene = subject.instance.scene
    return is_impact(scene) or is_sequence(scene)


def samples_after_impacts(subject: Subject, level: float, truth: SampledTruth) -> NDArray[np.bool_]:
    """True (until,) at samples that show the velocities of at most one step after an impact."""
    method = subject.method
    times = np.array(truth.t[: truth.until]) - method.delay(level)
    roundings = max(ROUND_OFF_FACTOR, steps_at(subject.instance, method, level))
    late = np.zeros(len(times), dtype=bool)
    for impact in crossings(subject, truth).get("contact", []):
        # A step may end at the impact itself, to the rounding of a clock.
        rounding = impact.radius + method.round_off * roundings * abs(impact.time)
        since = times - impact.time
        late |= (since >= -rounding) & (since <= level + rounding)
    return late


def sample_before(truth: SampledTruth) -> SampledTruth:
    """The truth whose every sample has the values of the sample before it, and the first its
    own.
    """
    earlier = {
        delay: (_moved_on(values), _moved_on(radii))
        for delay, (values, radii) in truth.earlier.items()
    }
    return replace(
        truth, values=_moved_on(truth.values), radii=_moved_on(truth.radii), earlier=earlier
    )


def _moved_on(columns: dict[str, list[float]]) -> dict[str, list[float]]:
    """Every column with its values one sample later."""
    return {name: [*column[:1], *column[:-1]] for name, column in columns.items()}
