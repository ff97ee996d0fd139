"""Error against certified truth at every refinement level, point by point, up to the predictability horizon."""

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding, Level
from refdem.core.judgement import MIXED, Array, certified, curve, errors, judged, no_truth, undecided
from refdem.core.problem import Problem
from refdem.core.refinement import COUNTING_FLOOR, scored
from refdem.core.statics import Static
from refdem.core.variant import Variant


class Error(Check):
    """Every quantity stays within its bound at every level."""

    name = "error"
    title = "Error against truth"
    judges = (Problem,)
    kills = "anything that makes the motion wrong beyond the method's own truncation error"

    def applies(self, trial: Trial) -> str | None:
        """Everywhere: without truth it says undecided."""
        return None

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return trial.plain

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """One finding a quantity."""
        truth = certified(trial)
        if truth is None:
            return [undecided(self.name, "state", no_truth(trial))]
        seen = {level: errors(trial.instance, runs[Variant(level)].trajectory, truth, trial.method.delay(level)) for level in trial.levels}
        if not (names := seen[trial.levels[0]]):
            return [undecided(self.name, "state", MIXED)]
        return [self._finding(trial, runs, name, {h: e[name] for h, e in seen.items()}) for name in names] + self._unsaid(trial, names)

    def _unsaid(self, trial: Trial, names: Iterable[str]) -> list[Finding]:
        """One finding for what the engine left out of a question without time: its parts are asked for one by one."""
        left = [name for name in trial.instance.quantities if name not in set(names)]
        if not left or not isinstance(trial.instance.problem, Static):
            return []
        of = ", ".join(dict.fromkeys(name.partition(".")[0] for name in left))
        return [
            Finding(
                check=self.name, quantity="unsaid", outcome="unsupported", sentence=f"The engine says nothing of {len(left)} numbers: {of}."
            )
        ]

    def _finding(self, trial: Trial, runs: Mapping[Variant, Outcome], quantity: str, seen: dict[float, Array]) -> Finding:
        truth = trial.truth
        assert truth is not None
        levels, worst, at = [], -1.0, trial.levels[-1]
        for level, error in seen.items():
            allowed = trial.bound(level)
            count = scored(allowed)
            levels.append(_level(trial, level, error, allowed, runs[Variant(level)].cost.seconds))
            ratio = float(np.max(error[:count] / allowed[:count])) if count >= min(2, len(allowed)) else -1.0
            if not ratio <= worst:
                worst, at = ratio, level
        if worst < 0:
            return undecided(self.name, quantity, "at every level the bound passes a tenth of the scale before the second sample")
        error, allowed = seen[at], trial.bound(at)
        count = scored(allowed)
        point = int(np.argmax(error[:count] / allowed[:count]))
        return judged(
            check=self.name,
            quantity=quantity,
            value=float(error[point]),
            bound=float(allowed[point]),
            unit="1",
            basis=_basis(trial, at),
            what=_what(trial, quantity, at, point, count),
            levels=tuple(levels),
            series=curve(trial.instance.times[:count], error[:count], allowed[:count]),
            order_seen=_order_seen(trial, levels),
            order_claimed=float(trial.method.order_for(trial.instance.problem.features)) if trial.method.control == "step" else None,
            constant_seen=_constant_seen(trial, levels),
        )


def _level(trial: Trial, level: float, error: Array, allowed: Array, seconds: float) -> Level:
    """What the tolerance table and the order need of one level."""
    assert trial.truth is not None
    counts = trial.method.control == "step" and scored(allowed) == len(allowed) and bool(allowed[-1] >= _floor(trial, level))
    return Level(level=level, error=float(np.max(error)), bound=float(allowed[-1]), seconds=seconds, counts=counts)


def _floor(trial: Trial, level: float) -> float:
    """Below 20 x round-off times the sensitivity there is no truncation error to see."""
    assert trial.truth is not None
    return COUNTING_FLOOR * trial.noise(level) * float(trial.truth.growth()[-1])


def _order_seen(trial: Trial, levels: list[Level]) -> float | None:
    """The order of the last pair of counting levels whose errors are truncation errors."""
    seen = [(a, b) for a, b in pairwise(levels) if a.counts and b.counts and b.error > _floor(trial, b.level)]
    return float(np.log2(seen[-1][0].error / seen[-1][1].error)) if seen and seen[-1][0].error > 0 else None


def _constant_seen(trial: Trial, levels: list[Level]) -> float | None:
    """The largest error over (T/tau) (h/tau)^p S among the levels that count: the measured C."""
    assert trial.truth is not None
    growth = trial.truth.growth()[-1]
    sizes = [level.error / float(trial.truncation(level.level)[-1] * growth) for level in levels if level.counts]
    return max(sizes) * trial.method.constant if sizes else None


def _basis(trial: Trial, level: float) -> str:
    """Where the bound comes from, in words."""
    if trial.method.control == "exact":
        return "an exact method may be off by round-off times the sensitivity S of the motion"
    if trial.method.control == "tolerance":
        return f"1e3 times the tolerance {level:.2g}, times the sensitivity S of the motion"
    order = trial.method.order_for(trial.instance.problem.features)
    return f"claimed order {order}: C (1 + t/tau) (h/tau)^{order} S with C = {trial.method.constant:g}"


def _what(trial: Trial, quantity: str, level: float, point: int, count: int) -> str:
    """The measured value in words."""
    times, when = trial.instance.times, trial.instance.problem.when
    end = "" if count == len(times) else f" (scored up to the predictability horizon {when(times[count - 1])})"
    step = {"step": f" at step {level:.3g} s", "tolerance": f" at tolerance {level:.1g}", "exact": ""}[trial.method.control]
    return f"The error of {quantity} in units of its scale{step}, worst against its bound at {when(times[point])}{end},"


CHECK = Error()
