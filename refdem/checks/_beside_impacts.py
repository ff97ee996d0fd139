"""Errors at samples next to an impact, where a run may show the velocities before or after it.

A run with the error E of its positions has an impact of time t* earlier or later by about E/|g'|,
where g is the gap that closes. An engine that collects contacts at the start of a step and then
advances has it up to one step h later still: the bodies overlap at the end of the step in which
they meet, and their velocities change in the next step. So a correct run may show the velocities
before the impact at samples up to t* + E/|g'| + h, and those after it from t* - E/|g'| on. The size
of this error of a velocity does not fall with h; the length of the interval in which it occurs
does.

The error of a position falls with h: it is at most |dv| h, where dv is the change of the velocity
in the impact. The claimed bound C (1 + t/tau) (h/tau)^p S covers it where t/tau is large, but not
soon after the start: a body that bounces off a wall has |dv| = (1 + e) v, up to 2 v.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from dataclasses import replace as replace_columns

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from refdem.checks._crossings import Crossing, crossings, error_at, is_impact, shift
from refdem.checks._impacts import falling, is_sequence
from refdem.core.check import Array, Subject
from refdem.core.judgement import certified, difference, errors, made_of_velocities, room_of
from refdem.core.once import once_with_arguments
from refdem.core.refinement import ROUND_OFF_FACTOR, steps_at
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.mechanics.quaternion import product, turned_by

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]


def errors_of(subject: Subject, level: float, run: Trajectory) -> Mapping[str, Array]:
    """`judgement.errors` of a run against the certified truth. At samples beside an impact a
    velocity has the smaller of its errors against the truth of that sample and of the sample on the
    other side of the impact.

    So a velocity must be the one after the impact or the one before it; places are judged as
    everywhere. Where a body has another impact between the two samples, neither of them shows its
    velocity between the two impacts: at the sample beside the impact that velocity is not judged.
    """
    return _errors_of(run, subject, level)


@once_with_arguments
def _errors_of(run: Trajectory, subject: Subject, level: float) -> Mapping[str, Array]:
    """The same, computed once for each run: the checks `error` and `order` both need it."""
    truth = certified(subject)
    assert truth is not None
    delay = subject.method.delay(level)
    scaled = errors(subject.instance, run, truth, delay)
    if not _meets(subject):
        return scaled
    of_velocities = made_of_velocities(subject.instance, run) & set(scaled)
    of_places = [scaled[name] for name in scaled.keys() - of_velocities]
    if not of_places:
        return scaled
    error = _error_before(subject, level, truth, np.maximum.reduce(of_places))
    for beside in beside_impacts(subject, level, truth, error):
        is_some = beside.late.any() or beside.early.any()
        if not is_some or not 0 < beside.after < truth.until:
            continue
        across = errors(subject.instance, run, truth_at(truth, beside.other_side()), delay)
        for name in of_velocities:
            scaled[name] = np.minimum(scaled[name], across[name])
        for name in of_velocities & _hidden_between(subject, run, beside):
            scaled[name] = np.where(beside.late | beside.early, 0.0, scaled[name])
    return scaled


def _hidden_between(subject: Subject, run: Trajectory, beside: "Beside") -> set[str]:
    """The names of the velocities that have a value between this impact and another one which no
    sample shows.
    """
    if beside.met_again:
        return made_of_velocities(subject.instance, run, beside.met_again)
    return set()


def _error_before(subject: Subject, level: float, truth: SampledTruth, of_places: Array) -> Array:
    """Bound (until,) on the error of the state before an impact that lies between each sample and
    the one before it: the smaller of the claimed bound and of the observed one.

    The observed bound is the largest error of a position up to the sample before, to which the
    impact itself adds nothing, with a factor of safety. Where positions exceed the claimed bound,
    as in a run that missed an impact, the bound is 0: such errors do not excuse a late impact.
    """
    before = np.concatenate([[0.0], np.maximum.accumulate(of_places)[:-1]])
    claimed = subject.bound(level)
    rounding = subject.floor(level) * truth.growth()
    shown = room_of(subject) * before + rounding
    return np.where(before > claimed, 0.0, np.minimum(shown, claimed))


def _meets(subject: Subject) -> bool:
    """True for fixed steps where rigid bodies meet."""
    if subject.method.control != "step":
        return False
    scene = subject.instance.scene
    return is_impact(scene) or is_sequence(scene)


def may_detect_late(subject: Subject) -> bool:
    """True for scenes with rigid impacts and methods of fixed steps that claim first order and do
    not claim to locate events.

    A claim of a higher order across impacts, or of located events, excludes late impacts.
    """
    return _meets(subject) and not subject.method.locates_events and subject.order <= 1


@dataclass(frozen=True, eq=False)
class Beside:
    """The samples beside an impact: True in `late` (T,) for those after it at which a run may show
    the velocities before it, in `early` (T,) for those before it at which a run may show the
    velocities after it. `after` is the number of the first sample after the impact; `met_again` are
    the bodies of the impact that have another one between the samples before and after it.
    """

    late: Mask
    early: Mask
    after: int
    met_again: tuple[int, ...] = ()

    def other_side(self) -> Whole:
        """The number (T,) of the sample whose true velocities each sample may show instead of its
        own: beside the impact that on its other side, elsewhere the sample itself.
        """
        own = np.arange(len(self.late))
        return np.where(self.late, self.after - 1, np.where(self.early, self.after, own))

    def around(self) -> tuple[int, int]:
        """The numbers of the last sample that shows the velocities of before the impact in every
        run, and of the first that shows those of after it.
        """
        before, after = self.after - 1, self.after
        samples = np.flatnonzero(self.late | self.early)
        if len(samples):
            before = min(int(samples[0]), after) - 1
            after = max(int(samples[-1]), after) + 1
        return max(0, before), min(len(self.late) - 1, after)


def beside_impacts(
    subject: Subject, level: float, truth: SampledTruth, error: Array
) -> Iterator[Beside]:
    """The samples, if any, beside each certified impact, in runs at a level whose state has the
    error `error` (T,), in units of the scales, at the first T samples.
    """
    method = subject.method
    times = subject.instance.times[: len(error)] - method.delay(level)
    roundings = ROUND_OFF_FACTOR
    detection_delay = 0.0
    if method.control == "step":
        roundings = max(roundings, steps_at(subject.instance, method, level))
    if may_detect_late(subject):
        detection_delay = level
    impacts = crossings(subject, truth).get("contact", [])
    for impact in impacts:
        # A step may end at the impact itself, up to the rounding of its clock.
        rounding = impact.radius + method.round_off * roundings * abs(impact.time)
        moved = shift(error_at(impact, error, times), impact) + rounding
        since = times - impact.time
        after = int(np.searchsorted(since, 0.0))
        late = (since >= 0.0) & (since <= moved + detection_delay)
        early = (since < 0.0) & (since >= -moved)
        yield Beside(late, early, after, _met_again(impact, impacts, times, after))


def _met_again(
    impact: Crossing, impacts: list[Crossing], times: Array, after: int
) -> tuple[int, ...]:
    """The bodies of an impact that have another one in the same interval between samples, that
    ends with sample number `after`.
    """
    if not 0 < after < len(times):
        return ()
    others: set[int] = set()
    for other in impacts:
        if other is not impact and times[after - 1] < other.time < times[after]:
            others.update(other.bodies)
    return tuple(body for body in impact.bodies if body in others)


def left_by_late_impacts(
    subject: Subject, level: float, run: Trajectory, truth: SampledTruth
) -> dict[str, Array]:
    """The error (until,) of every quantity from impacts that act one step h late, in units of its
    scale; empty for methods without late impacts.

    After an impact that changes velocity and angular velocity of a body by dv and dw, the error of
    the position is dv h, and that of the attitude is a rotation by dw h.
    """
    if not may_detect_late(subject):
        return {}
    instance = subject.instance
    gravity = falling(instance.scene)
    moved = {name: np.zeros(truth.until) for name in instance.quantities}
    observed = instance.observe(run)
    for beside in beside_impacts(subject, level, truth, subject.bound(level)):
        if not 0 < beside.after < truth.until:
            continue
        before, after = beside.around()
        # dv = v' - v - g (t' - t),   dw = omega' - omega.
        fallen = (run.t[after] - run.t[before]) * gravity
        velocity_change = run.velocity[after] - run.velocity[before] - fallen
        spin_change = run.omega[after] - run.omega[before]
        position = run.position.copy()
        # r + dv h.
        position[beside.after :] += velocity_change * level
        attitude = run.attitude.copy()
        # q(dw h) q: a rotation by dw h in space axes after that of the body.
        attitude[beside.after :] = product(turned_by(spin_change * level), attitude[beside.after :])
        shifted = instance.observe(replace_columns(run, position=position, attitude=attitude))
        for name, quantity in instance.quantities.items():
            if name in observed:
                a, b = shifted[name][: truth.until], observed[name][: truth.until]
                # Sum over impacts of |x(shifted) - x|/scale.
                change = difference(a, b, is_angle=quantity.angle)
                moved[name] += np.abs(change) / quantity.scale
    return moved


def nearest_velocities(
    subject: Subject, level: float, run: Trajectory, truth: SampledTruth, error: Array
) -> list[Trajectory]:
    """The runs that are equivalent to a run for each of its impacts: with the velocities before and
    with those after the impact at all samples beside it.

    `error` (T,) is the error that its state may have. Velocities of falling bodies change by g t
    from one sample to another.
    """
    replaced = []
    gravity = falling(subject.instance.scene)
    for beside in beside_impacts(subject, level, truth, error):
        samples = np.flatnonzero(beside.late | beside.early)
        if not len(samples):
            continue
        for source in beside.around():
            velocity = run.velocity.copy()
            omega = run.omega.copy()
            # v(t_source) + g (t - t_source), and omega(t_source).
            fallen = (run.t[samples] - run.t[source])[:, None, None] * gravity
            velocity[samples] = run.velocity[source] + fallen
            omega[samples] = run.omega[source]
            replaced.append(replace_columns(run, velocity=velocity, omega=omega))
    return replaced


def truth_at(truth: SampledTruth, samples: Whole) -> SampledTruth:
    """The truth whose sample number k has the values of sample number `samples[k]`."""
    earlier = {
        delay: (_taken(values, samples), _taken(radii, samples))
        for delay, (values, radii) in truth.earlier.items()
    }
    return replace(
        truth,
        values=_taken(truth.values, samples),
        radii=_taken(truth.radii, samples),
        earlier=earlier,
    )


def _taken(columns: dict[str, list[float]], samples: Whole) -> dict[str, list[float]]:
    """Every column with its values at these samples."""
    return {name: [column[k] for k in samples] for name, column in columns.items()}
