"""Error against certified truth at every refinement level, point by point, up to the predictability
horizon.
"""

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from refdem.checks._beside_impacts import errors_of, left_by_late_impacts
from refdem.checks._kinks import least_shares, may_straddle, sharpest_kink, straddled
from refdem.core.case import Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding, Level
from refdem.core.judgement import (
    CUT_PREDICTION_FACTOR,
    MIXED,
    Array,
    Sight,
    certified,
    curve,
    difference,
    judged,
    movements,
    no_truth,
    room_of,
    sharpest,
    undecided,
)
from refdem.core.problem import Problem
from refdem.core.refinement import MEMORY, kinked, scored
from refdem.core.static_problems import Static
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene.elements.contact import Contact
from refdem.scene.singularity import KINK

NEARLY = 0.9
"""Part of the largest share of a bound from which on a sample has nearly that share."""
COURSE = 10.0
"""Bound, in scales, beyond which the motion may have changed its course; runs with different steps
may then agree by chance.
"""


class Error(Check):
    """Every quantity of every level stays within its bound."""

    name = "error"
    title = "Error against truth"
    judges = (Problem,)
    kills = "any error of the motion beyond the truncation error of the method"

    def applies(self, subject: Subject) -> str | None:
        """Always: without truth the finding is undecided."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each quantity with certified truth, and one for quantities that the
        engine does not report.
        """
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "state", no_truth(subject))]
        # Scaled errors (until,) by level and quantity.
        errors_at: dict[float, Mapping[str, Array]] = {}
        # The errors (until,) that late impacts leave, likewise.
        left_at: dict[float, dict[str, Array]] = {}
        for level in subject.levels:
            run = runs[Variant(level)].trajectory
            errors_at[level] = errors_of(subject, level, run)
            left_at[level] = left_by_late_impacts(subject, level, run, truth)
        names = list(errors_at[subject.levels[0]])
        if not names:
            return [undecided(self.name, "state", MIXED)]
        signals = _signals(subject, truth)
        estimates = _error_from_halvings(subject, runs)
        findings = []
        for name in names:
            by_level = {level: of_level[name] for level, of_level in errors_at.items()}
            bounds = _bounds(subject, _estimate_of(name, estimates))
            allowed = {
                level: _at_least(bound, left_at[level].get(name)) for level, bound in bounds.items()
            }
            findings.append(self._finding(subject, runs, name, by_level, signals[name], allowed))
        return findings + self._missing_quantities(subject, names)

    def _missing_quantities(self, subject: Subject, names: Iterable[str]) -> list[Finding]:
        """One finding on the quantities of a static question that the engine does not report.

        A static question (mass properties, identities) requests each number separately, so that a
        result may be incomplete.
        """
        reported = set(names)
        missing = [name for name in subject.instance.quantities if name not in reported]
        if not missing or not isinstance(subject.instance.problem, Static):
            return []
        listed = ", ".join(dict.fromkeys(name.partition(".")[0] for name in missing))
        return [
            Finding(
                check=self.name,
                quantity="unsaid",
                outcome="unsupported",
                sentence=(
                    f"The engine does not report {len(missing)} of the requested numbers: {listed}."
                ),
            )
        ]

    def _finding(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        quantity: str,
        errors_by_level: dict[float, Array],
        signal: Array,
        bounds: dict[float, Array],
    ) -> Finding:
        """The finding on one quantity: its error at the level where it is the largest share of its
        bound, at the sample of `_decisive_sample`.

        `errors_by_level` and `bounds` hold arrays (count,) by level, up to each level's horizon;
        `signal` (until,) is how far the true quantity moves. All are in units of the quantity's
        scale.
        """
        if not bounds:
            why = "at every level the bound exceeds a tenth of the scale before the second sample"
            return undecided(self.name, quantity, why)
        sights = {level: sharpest(bound, signal[: len(bound)]) for level, bound in bounds.items()}
        worst_level = _decisive_level(errors_by_level, bounds, sights)
        allowed = bounds[worst_level]
        count = len(allowed)
        error = errors_by_level[worst_level][:count]
        point = _decisive_sample(error, allowed)
        levels = [
            _level(subject, level, error, subject.bound(level), runs[Variant(level)].cost)
            for level, error in errors_by_level.items()
        ]
        claimed = subject.bound(worst_level)[point]
        basis = _basis(subject, worst_level, settled=bool(allowed[point] < claimed))
        if allowed[point] > claimed:
            basis = "the error left by an impact one step late: its velocity change times h"
        sentence_subject = _what(subject, quantity, worst_level, point, count)
        sharpest_sight = min(sights.values(), key=_bound_over_signal)
        errors_in_time = curve(subject.instance.times[:count], error, allowed)
        order_claimed = None
        if subject.method.control == "step":
            order_claimed = float(subject.order)
        return judged(
            check=self.name,
            quantity=quantity,
            value=float(error[point]),
            bound=float(allowed[point]),
            unit="1",
            basis=basis,
            what=sentence_subject,
            sight=sharpest_sight,
            levels=tuple(levels),
            series=errors_in_time,
            order_seen=_observed_order(subject, levels),
            order_claimed=order_claimed,
            constant_seen=_measured_constant(subject, levels),
        )


def _bounds(subject: Subject, estimate: Array | None) -> dict[float, Array]:
    """The bound (count,) of every level up to its horizon; levels with fewer than two samples below
    it are left out.

    The bound on the state is the largest error constant allowed times S; where the order is 1 and
    contacts are stiff it soon passes the horizon. At the finest level the error is also estimated
    from the last halvings of the step, as `estimate` (count,), and the smaller of both bounds
    counts.
    """
    bounds: dict[float, Array] = {}
    for level in subject.levels:
        allowed = subject.bound(level)
        if level == subject.levels[-1]:
            allowed = _smaller_bound(allowed, estimate)
        count = scored(allowed)
        if count >= min(2, len(allowed)):
            bounds[level] = allowed[:count]
    return bounds


def _at_least(bound: Array, left: Array | None) -> Array:
    """A bound (count,), or the error (until,) that late impacts leave in a quantity, if that is
    larger.
    """
    if left is None:
        return bound
    larger: Array = np.maximum(bound, left[: len(bound)])
    return larger


def _smaller_bound(allowed: Array, estimate: Array | None) -> Array:
    """The smaller of the bound on the state and of the estimated error `estimate` (count,), until
    the bound exceeds COURSE.
    """
    if estimate is None:
        return allowed
    off_course = np.flatnonzero(allowed > COURSE)
    if len(off_course):
        course = int(off_course[0])
    else:
        course = len(allowed)
    known = min(course, len(estimate))
    bound: Array = np.concatenate([np.minimum(allowed[:known], estimate[:known]), allowed[known:]])
    return bound


def _estimate_of(name: str, estimates: Mapping[str, Array] | None) -> Array | None:
    """The estimate (count,) for one quantity; for an attitude, which is compared as one rotation,
    the largest of any quantity.
    """
    if estimates is None:
        return None
    if name in estimates:
        return estimates[name]
    largest: Array = np.maximum.reduce(list(estimates.values()))
    return largest


def _error_from_halvings(
    subject: Subject, runs: Mapping[Variant, CompletedRun]
) -> dict[str, Array] | None:
    """Bound (count,) by quantity on the error at the finest level from the change at the last
    halvings, in units of the scales; None if unknown.

    With an error e(h) = C h^p the run changes by (2^p - 1) e(h/2) from h to h/2. So e(h/2) is at
    most PREDICTION_FACTOR times that change over 2^p - 1, whatever C is. Where terms of the last
    change cancel, 2^-p times the change before may be larger, and is taken. Each quantity has the
    bound that follows from its own changes, or from a part (`least_shares`) of the largest of any
    quantity.

    Where kinks scatter C from step to step, an error is still part of the change to either side of
    it, but may be nearly the same at both steps: the division by 2^p - 1 is left out, the changes
    of all levels count, and the error of a step that straddles a kink is added. C h^p itself does
    not scatter, and the division stays, in two cases. A method that claims a higher order than
    fixed steps can have across these kinks cuts its steps there, and the part that is cut off has
    an error of h^(p+1), however long it is. And a force that varies as |s|^n at its kink leaves
    an error of h^(n+1) (see scene/singularity.py), which is of higher order than h^p where
    p < n + 1.

    An error falls with a tolerance as well, but not smoothly. Where the tolerance does not change
    the run, as where samples are closer than any step, the error cannot be estimated: None.

    Neither can it where a multistep method has made fewer than MEMORY steps at the coarsest of
    these levels: it starts with another rule, which has another error constant.
    """
    method = subject.method
    instance = subject.instance
    if method.control == "exact" or len(subject.levels) < 3 or subject.truth is None:
        return None
    count = subject.truth.until
    if method.control == "tolerance":
        count = scored(subject.bound(subject.levels[-3]))
    if count < 2:
        return None
    count = subject.truth.until
    straddles = may_straddle(subject)
    used = subject.levels[-3:]
    if straddles:
        used = subject.levels
    observed = [instance.observe(runs[Variant(level)].trajectory) for level in used]
    by_quantity = [_changes(instance, a, b, count) for a, b in pairwise(observed)]
    changes = [np.maximum.reduce(list(change.values())) for change in by_quantity]
    finest = runs[Variant(subject.levels[-1])].trajectory
    floor = subject.floor(subject.levels[-1])
    rounding = floor * subject.truth.growth()[:count]
    ratio = _ratio_of(subject, changes, rounding)
    if ratio is None:
        return None
    beside = rounding
    if method.control == "step" and not method.complete_state:
        times = instance.times[:count]
        beside = np.where(np.abs(times - times[0]) < MEMORY * used[0], np.inf, beside)
    # bound = safety change + floor(h) S, plus the error of steps that straddle kinks.
    safety = _safety(subject, ratio, len(changes), finest)
    implied = _implied_changes(subject, by_quantity, ratio)
    bounds = {name: safety * change + beside for name, change in implied.items()}
    if straddles:
        off = straddled(subject, subject.levels[-1], finest, count)
        bounds = {name: bound + off[name] for name, bound in bounds.items()}
    return bounds


def _implied_changes(
    subject: Subject, changes: list[dict[str, Array]], ratio: float
) -> dict[str, Array]:
    """The change (count,) of every quantity at the last halving: the running maximum of that change
    and of those that earlier halvings imply for it.
    """
    so_far = {
        name: [np.maximum.accumulate(change[name]) for change in changes] for name in changes[-1]
    }
    own = {}
    for name, of_levels in so_far.items():
        # max over k of c_k ratio^-k, where c_k is the change k halvings before the last.
        implied = [change / ratio**k for k, change in enumerate(reversed(of_levels))]
        own[name] = np.maximum.reduce(implied)
    largest = np.maximum.reduce(list(own.values()))
    if subject.method.control == "tolerance":
        # A few steps with chosen orders are not representative, so the change of the whole run
        # counts.
        return {name: np.full_like(largest, largest[-1]) for name in own}
    shares = least_shares(so_far)
    return {
        name: np.maximum(change, np.maximum.accumulate(shares[name] * largest))
        for name, change in own.items()
    }


def _ratio_of(subject: Subject, changes: list[Array], rounding: Array) -> float | None:
    """Factor by which the error falls from one level to the next: 2^p of the claimed order p; None
    if the changes (count,) do not fall.

    If the ratio of the last two changes is less than half of 2^p, that ratio is returned: steps may
    be short relative to the motion and not yet to a force that changes fast, as of a spring whose
    ends pass close to each other. The check `order` judges whether a method has its claimed order.
    """
    if subject.method.control == "tolerance":
        if np.any(changes[0] > rounding):
            return subject.levels[-2] / subject.levels[-1]
        return None
    # 2^p, or c_before/c_last if that is less than half of it and above 1.
    claimed: float = 2.0**subject.order
    if kinked(subject.instance, subject.method) or not np.any(changes[-1] > rounding):
        return claimed
    before, last = (float(np.max(change)) for change in changes[-2:])
    ratio = before / last
    if ratio >= claimed / 2:
        return claimed
    if ratio > 1:
        return ratio
    return None


def _safety(subject: Subject, ratio: float, count: int, finest: Trajectory) -> float:
    """Factor on the largest of `count` changes that bounds the error at the finest level, whose run
    is `finest`; `ratio` is that by which the error falls from one level to the next.

    Two changes are by chance as rarely equal to within 1/64 as three are to within 1/16.
    """
    safety = room_of(subject)
    if subject.method.control == "tolerance":
        return safety
    if not kinked(subject.instance, subject.method) or _cuts_steps(subject):
        return safety / (ratio - 1.0)
    if subject.order < sharpest_kink(subject, subject.levels[-1], finest) + 1.0:
        return CUT_PREDICTION_FACTOR / (ratio - 1.0)
    if may_straddle(subject):
        safety **= 2 / count
    return safety


def _cuts_steps(subject: Subject) -> bool:
    """True if the method claims that its steps end at each kink, or the order that it claims can be
    had across the kinks of the scene only by such steps.

    A method that locates events may do so by interpolation and not cut its steps; across a kink
    that allows the claimed order anyway, such a method scatters the error. The smoothest kink of a
    contact is that of its normal force, or one of the first kind: a spring that starts to slip, a
    damped force that ends.
    """
    method = subject.method
    if method.cuts_steps or not method.locates_events:
        return method.cuts_steps
    scene = subject.instance.scene
    exponents = [KINK]
    exponents += [law.exponent for law in scene.all(Contact)]
    exponents += [limit.exponent for _, limit in scene.singularities()]
    # Across a force that varies as |s|^n, fixed steps have at most the order n + 1.
    return subject.order > max(exponents) + 1.0


def _changes(
    instance: Instance, coarse: Mapping[str, Array], fine: Mapping[str, Array], count: int
) -> dict[str, Array]:
    """Difference (count,) of every quantity between two levels, in units of its scale."""
    changes = {}
    for name, quantity in instance.quantities.items():
        if name not in coarse or name not in fine:
            continue
        change = difference(fine[name][:count], coarse[name][:count], is_angle=quantity.angle)
        changes[name] = np.abs(change) / quantity.scale
    return changes


def _signals(subject: Subject, truth: SampledTruth) -> dict[str, Array]:
    """How far the truth of every quantity has moved (until,), in units of its scale; 0 for one that
    stays within round-off.
    """
    rounding = subject.resolution(subject.levels[-1]) * truth.growth()
    moved = movements(subject.instance, truth)
    signals = {}
    for name, movement in moved.items():
        if np.any(movement > rounding):
            signals[name] = movement
        else:
            signals[name] = np.zeros_like(movement)
    return signals


def _decisive_sample(error: Array, allowed: Array) -> int:
    """The sample of the largest error, among those where the error is NEARLY the largest share of
    its bound.

    A bound that follows from the error at another step has the same share at many samples, and
    rounding would choose between them, while a baseline needs the same sample after every change.
    If an error exceeds its bound, the sample of the largest share is taken.
    """
    share = error / allowed
    # NaN is beyond its bound: `not share <= 1`.
    if not np.max(share) <= 1:
        return int(np.argmax(share))
    # The largest error among samples with share >= NEARLY max(share).
    is_candidate = share >= NEARLY * np.max(share)
    return int(np.argmax(np.where(is_candidate, error, -1.0)))


def _decisive_level(
    errors_by_level: Mapping[float, Array],
    bounds: Mapping[float, Array],
    sights: Mapping[float, Sight],
) -> float:
    """The level whose error is the largest share of its bound.

    Only levels with a sharp bound (at most a tenth of the signal) count, if there are any; a level
    beyond its bound always counts.
    """
    shares: dict[float, float] = {}
    for level, bound in bounds.items():
        # max over t of error/bound.
        shares[level] = float(np.max(errors_by_level[level][: len(bound)] / bound))
    # NaN counts as beyond its bound: `not share <= 1`.
    decisive = [level for level in bounds if not sights[level].is_blind or not shares[level] <= 1]
    return _worst_level(decisive or list(bounds), shares)


def _worst_level(levels: list[float], ratios: dict[float, float]) -> float:
    """The level with the largest error relative to its bound; a level whose error is NaN comes
    first.
    """
    broken = [level for level in levels if np.isnan(ratios[level])]
    if broken:
        return broken[0]
    return max(levels, key=lambda level: ratios[level])


def _bound_over_signal(sight: Sight) -> float:
    """The bound over the signal; infinite without a signal."""
    if sight.sharpness is None:
        return np.inf
    return sight.sharpness


def _level(subject: Subject, level: float, error: Array, allowed: Array, cost: Cost) -> Level:
    """The entry of one level: error, bound, cost, and whether the order is observed from it.

    A level counts for the order if its bound stays below the horizon and above 20 x round-off.
    """
    assert subject.truth is not None
    counts = (
        subject.method.control == "step"
        and scored(allowed) == len(allowed)
        and bool(allowed[-1] >= _floor(subject, level))
    )
    return Level(
        level=level,
        error=float(np.max(error)),
        bound=float(allowed[-1]),
        seconds=cost.seconds,
        counts=counts,
        steps=cost.steps,
    )


def _floor(subject: Subject, level: float) -> float:
    """20 x round-off times the sensitivity S at the end: smaller errors show no truncation."""
    assert subject.truth is not None
    return subject.floor(level) * float(subject.truth.growth()[-1])


def _observed_order(subject: Subject, levels: list[Level]) -> float | None:
    """The order log2(e(h)/e(h/2)) of the finest pair of counting levels above round-off; None
    without one.
    """
    pairs = [
        (a, b)
        for a, b in pairwise(levels)
        if a.counts and b.counts and b.error > _floor(subject, b.level)
    ]
    if not pairs:
        return None
    coarse, fine = pairs[-1]
    if coarse.error > 0:
        return float(np.log2(coarse.error / fine.error))
    return None


def _measured_constant(subject: Subject, levels: list[Level]) -> float | None:
    """The measured constant C of |error| <= C (T/tau) (h/tau)^p S: the largest over the counting
    levels; None without one.
    """
    assert subject.truth is not None
    growth = subject.truth.growth()[-1]
    ratios = [
        level.error / float(subject.truncation(level.level)[-1] * growth)
        for level in levels
        if level.counts
    ]
    if ratios:
        return max(ratios) * subject.constant
    return None


def _basis(subject: Subject, level: float, *, settled: bool) -> str:
    """The basis of the bound in words; `settled` if it was estimated from the last change."""
    if settled and subject.method.control == "tolerance":
        return (
            "error implied by the last change of tolerance, if the error falls in proportion to it"
        )
    if settled:
        order = subject.order
        return f"error implied by the change at the last halving of the step, for order {order}"
    if subject.method.control == "exact":
        return "round-off times the sensitivity S of the motion, for an exact method"
    if subject.method.control == "tolerance":
        factor = float(subject.truncation(level)[-1]) / level
        return (
            f"{factor:.3g} times the tolerance {level:.2g}, times the sensitivity S of the motion"
        )
    order = subject.order
    basis = f"claimed order {order}: |error| <= C (1 + t/tau) (h/tau)^{order} S with C ="
    claimed = subject.method.constant
    if subject.constant == claimed:
        return f"{basis} {claimed:g}"
    times = subject.constant / claimed
    return f"{basis} {subject.constant:.3g}, {times:.3g} times as much where friction alternates"


def _what(subject: Subject, quantity: str, level: float, point: int, count: int) -> str:
    """The phrase that names the measured value."""
    times = subject.instance.times
    when = subject.instance.problem.when
    if count == len(times):
        end = ""
    else:
        end = f" (scored up to the predictability horizon {when(times[count - 1])})"
    step = {
        "step": f" with step {level:.3g} s",
        "tolerance": f" with tolerance {level:.1g}",
        "exact": "",
    }[subject.method.control]
    return f"The error of {quantity}{step} at {when(times[point])}{end}, relative to its scale,"


CHECK = Error()
