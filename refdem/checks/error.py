"""Error against certified truth at every refinement level, point by point, up to the predictability
horizon.
"""

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from refdem.core.case import Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding, Level
from refdem.core.judgement import (
    MIXED,
    ROOM,
    Array,
    Sight,
    certified,
    curve,
    errors,
    judged,
    movements,
    no_truth,
    room_of,
    sharpest,
    undecided,
)
from refdem.core.problem import Problem
from refdem.core.refinement import COUNTING_FLOOR, kinked, scored
from refdem.core.statics import Static
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant

COURSE = 10.0
"""A bound above this many scales says that the motion may have taken another course, in which steps
may agree by chance.
"""


class Error(Check):
    """Every quantity stays within its bound at every level."""

    name = "error"
    title = "Error against truth"
    judges = (Problem,)
    kills = "any error of the motion beyond the truncation error of the method"

    def applies(self, subject: Subject) -> str | None:
        """Everywhere: without truth it says undecided."""
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each quantity with certified truth."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "state", no_truth(subject))]
        seen = {
            level: errors(
                subject.instance,
                runs[Variant(level)].trajectory,
                truth,
                subject.method.delay(level),
            )
            for level in subject.levels
        }
        if not (names := seen[subject.levels[0]]):
            return [undecided(self.name, "state", MIXED)]
        moved = _signals(subject, truth)
        bounds = _bounds(subject, runs)
        found = [
            self._finding(
                subject, runs, name, {h: e[name] for h, e in seen.items()}, moved[name], bounds
            )
            for name in names
        ]
        return found + self._unsaid(subject, names)

    def _unsaid(self, subject: Subject, names: Iterable[str]) -> list[Finding]:
        """One finding for what the engine left out of a question without time: its parts are asked
        for one by one.
        """
        left = [name for name in subject.instance.quantities if name not in set(names)]
        if not left or not isinstance(subject.instance.problem, Static):
            return []
        of = ", ".join(dict.fromkeys(name.partition(".")[0] for name in left))
        return [
            Finding(
                check=self.name,
                quantity="unsaid",
                outcome="unsupported",
                sentence=f"The engine does not report {len(left)} of the requested numbers: {of}.",
            )
        ]

    def _finding(
        self,
        subject: Subject,
        runs: Mapping[Variant, CompletedRun],
        quantity: str,
        seen: dict[float, Array],
        moved: Array,
        bounds: dict[float, Array],
    ) -> Finding:
        """The level that comes nearest to its bound, of those whose bound is sharp; one that is
        beyond its bound always counts.
        """
        sights: dict[float, Sight] = {}
        ratios: dict[float, float] = {}
        for level, allowed in bounds.items():
            count = len(allowed)
            sights[level] = sharpest(allowed, moved[:count])
            ratios[level] = float(np.max(seen[level][:count] / allowed))
        if not bounds:
            return undecided(
                self.name,
                quantity,
                "at every level the bound exceeds a tenth of the scale before the second sample",
            )
        telling = [
            level for level in bounds if not sights[level].is_blind or not ratios[level] <= 1
        ]
        at = _worst_level(telling or list(bounds), ratios)
        count = len(bounds[at])
        error = seen[at][:count]
        allowed = bounds[at]
        point = int(np.argmax(error / allowed))
        levels = [
            _level(subject, level, error, subject.bound(level), runs[Variant(level)].cost.seconds)
            for level, error in seen.items()
        ]
        has_settled = bool(allowed[point] < subject.bound(at)[point])
        order_claimed = None
        if subject.method.control == "step":
            order_claimed = float(subject.order)
        return judged(
            check=self.name,
            quantity=quantity,
            value=float(error[point]),
            bound=float(allowed[point]),
            unit="1",
            basis=_basis(subject, at, settled=has_settled),
            what=_what(subject, quantity, at, point, count),
            sight=min(sights.values(), key=_part),
            levels=tuple(levels),
            series=curve(subject.instance.times[:count], error, allowed),
            order_seen=_order_seen(subject, levels),
            order_claimed=order_claimed,
            constant_seen=_constant_seen(subject, levels),
        )


def _bounds(subject: Subject, runs: Mapping[Variant, CompletedRun]) -> dict[float, Array]:
    """The bound of every level that can be judged (count,), up to the horizon; of the finest the
    smaller of two.

    The bound on the state multiplies the largest error constant that is allowed by S, and soon
    passes the horizon where the order is 1 and contacts are stiff. What the last halvings of the
    step leave is measured, and goes on beyond it.
    """
    found: dict[float, Array] = {}
    for level in subject.levels:
        allowed = subject.bound(level)
        if level == subject.levels[-1]:
            allowed = _sharpened(allowed, _settling(subject, runs))
        count = scored(allowed)
        if count >= min(2, len(allowed)):
            found[level] = allowed[:count]
    return found


def _sharpened(allowed: Array, settled: Array | None) -> Array:
    """The smaller of the bound on the state and of what has settled (count,), as long as the motion
    cannot have changed its course.
    """
    if settled is None:
        return allowed
    beyond = np.flatnonzero(allowed > COURSE)
    if len(beyond):
        course = int(beyond[0])
    else:
        course = len(allowed)
    known = min(course, len(settled))
    found: Array = np.concatenate([np.minimum(allowed[:known], settled[:known]), allowed[known:]])
    return found


def _settling(subject: Subject, runs: Mapping[Variant, CompletedRun]) -> Array | None:
    """What the last halvings of the step leave of the error at the finest level (count,), in units
    of the scales; None if unknown.

    With an error e(h) = C h^p the run changes by (2^p - 1) e(h/2) from h to h/2. So e(h/2) is at
    most ROOM times the change over 2^p - 1, whatever C is, or 2^-p of that of the pair before,
    where terms of the last pair cancel. Where kinks scatter C from step to step, an error is still
    part of the change to either side of it, but may be nearly the same at both steps.

    An error falls with a tolerance as well, in stairs. Where no tolerance changes the run, as where
    samples leave no room for longer steps, it says nothing.
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
    order = subject.order
    coarse, middle, fine = (
        instance.observe(runs[Variant(level)].trajectory) for level in subject.levels[-3:]
    )
    before = _changes(instance, coarse, middle, count)
    last = _changes(instance, middle, fine, count)
    rounding = COUNTING_FLOOR * subject.noise(subject.levels[-1]) * subject.truth.growth()[:count]
    room = room_of(subject)
    falls = 2.0**order
    if method.control == "tolerance":
        falls = subject.levels[-2] / subject.levels[-1]
        if not np.any(before > rounding):
            return None
    elif not kinked(instance):
        room /= falls - 1.0
    change = np.maximum.accumulate(np.maximum(before / falls, last))
    if method.control == "tolerance":
        change = np.full(
            count, change[-1]
        )  # where orders are chosen as well, that of a few steps says little
    is_cut = method.control == "step" and kinked(instance) and not method.locates_events
    allowed: Array = room * change + rounding
    if is_cut:
        allowed = allowed + ROOM * (_straddled(instance, fine, count) * subject.levels[-1])
    return allowed


def _straddled(instance: Instance, run: Mapping[str, Array], count: int) -> Array:
    """The fastest that any quantity has changed so far [1/s] (count,), in its scale, from sample to
    sample to either side.

    A step that straddles a kink goes on for the rest of it with the force of before, and is off by
    that much a second. Halved steps end where the long ones do, so that every one that is longer
    than this rest is off by the same.
    """
    fastest = np.zeros(len(instance.times) - 1)
    for name, quantity in instance.quantities.items():
        if name in run and not quantity.angle:
            fastest = np.maximum(fastest, np.abs(np.diff(run[name])) / quantity.scale)
    beside = np.maximum(np.append(0.0, fastest), np.append(fastest, 0.0))
    so_far: Array = np.maximum.accumulate(beside)[:count] / abs(instance.problem.interval)
    return so_far


def _changes(
    instance: Instance, coarse: Mapping[str, Array], fine: Mapping[str, Array], count: int
) -> Array:
    """Largest scaled difference of any quantity between two levels (count,)."""
    largest = np.zeros(count)
    for name, quantity in instance.quantities.items():
        if name not in coarse or name not in fine:
            continue
        difference = np.abs(fine[name] - coarse[name])[:count]
        if quantity.angle:
            difference = np.abs(np.remainder(difference + np.pi, 2 * np.pi) - np.pi)
        largest = np.maximum(largest, difference / quantity.scale)
    return largest


def _signals(subject: Subject, truth: SampledTruth) -> dict[str, Array]:
    """How far the truth of every quantity has moved (until,), in units of its scale; 0 for one that
    stays within round-off.
    """
    rounding = subject.noise(subject.levels[-1]) * truth.growth()
    moved = movements(subject.instance, truth)
    signals = {}
    for name, away in moved.items():
        if np.any(away > rounding):
            signals[name] = away
        else:
            signals[name] = np.zeros_like(away)
    return signals


def _worst_level(levels: list[float], ratios: dict[float, float]) -> float:
    """The level whose error is the largest part of its bound; one whose error is not a number comes
    first.
    """
    broken = [level for level in levels if np.isnan(ratios[level])]
    if broken:
        return broken[0]
    return max(levels, key=lambda level: ratios[level])


def _part(sight: Sight) -> float:
    """The bound over the signal; infinite without a signal."""
    if sight.sharpness is None:
        return np.inf
    return sight.sharpness


def _level(subject: Subject, level: float, error: Array, allowed: Array, seconds: float) -> Level:
    """What the tolerance table and the order need of one level."""
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
        seconds=seconds,
        counts=counts,
    )


def _floor(subject: Subject, level: float) -> float:
    """Below 20 x round-off times the sensitivity there is no truncation error to see."""
    assert subject.truth is not None
    return COUNTING_FLOOR * subject.noise(level) * float(subject.truth.growth()[-1])


def _order_seen(subject: Subject, levels: list[Level]) -> float | None:
    """The order of the last pair of counting levels whose errors are truncation errors."""
    seen = [
        (a, b)
        for a, b in pairwise(levels)
        if a.counts and b.counts and b.error > _floor(subject, b.level)
    ]
    if seen and seen[-1][0].error > 0:
        return float(np.log2(seen[-1][0].error / seen[-1][1].error))
    return None


def _constant_seen(subject: Subject, levels: list[Level]) -> float | None:
    """The largest error over (T/tau) (h/tau)^p S among the levels that count: the measured C."""
    assert subject.truth is not None
    growth = subject.truth.growth()[-1]
    sizes = [
        level.error / float(subject.truncation(level.level)[-1] * growth)
        for level in levels
        if level.counts
    ]
    if sizes:
        return max(sizes) * subject.method.constant
    return None


def _basis(subject: Subject, level: float, *, settled: bool) -> str:
    """Where the bound comes from, in words; `settled` if it is what the run still changed by."""
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
    constant = subject.method.constant
    return (
        f"claimed order {order}: |error| <= C (1 + t/tau) (h/tau)^{order} S with C = {constant:g}"
    )


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
