"""Resolution: the smallest relative misreading of a number of the scene that makes a finding fail.

The number is multiplied by 1 + a in every request that an engine gets, and its runs are judged as
if it had been read correctly. The smallest a at which a finding fails is found by trials. Errors
are proportional to a, so that a ratio r of error to bound at a predicts the threshold a/r. The
resolution is the smallest misreading that a pass of the unchanged run excludes.
"""

import hashlib
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import msgspec
import numpy as np

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.deviation import Deviation
from refdem.core.engine import Engine
from refdem.core.finding import Finding
from refdem.core.judgement import distances
from refdem.core.problem import Motion, Request
from refdem.core.resolution import NumberResolution, Resolution
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.execution.schedule import Job, Progress, Schedule, counted
from refdem.faults.fault import Carrier, Fault
from refdem.faults.numbers import Number, numbers
from refdem.planning import plan, unchanged
from refdem.planning.deviations import of_engine
from refdem.planning.in_process import record_of
from refdem.planning.plan import Task
from refdem.planning.specification import Specification
from refdem.planning.truths import sampled_truths

SECONDS = 600.0
"""Limit on the CPU time [s] for all numbers of one method on one case."""
FIRST = 1e-3
"""The misreading that is tried first."""
LEAST = 1e-12
"""The smallest misreading that is tried, a few thousand units of binary64 round-off."""
CLOSE = 1.5
"""Ratio of the smallest detected misreading to the largest undetected one at which a search ends.
"""
MOST_TRIALS = 16
"""Largest number of trials; then the smallest misreading detected so far is the result."""
STILL = 1e-12
"""Change of a run by the first misreading, in units of its scales, up to which it is round-off."""
_DECODER = msgspec.msgpack.Decoder(Resolution)


@dataclass(frozen=True)
class Trial:
    """The findings of a run with a number misread, and its finest run, or the reason why the engine
    refused it.
    """

    findings: tuple[Finding, ...] = ()
    finest: Run | None = None
    refused: str = ""

    @property
    def run(self) -> Trajectory:
        """The trajectory of the finest run of a trial that was not refused."""
        assert self.finest is not None
        assert self.finest.trajectory is not None
        return self.finest.trajectory

    @property
    def excess(self) -> float:
        """The largest ratio of a value and its bound; 0 if no finding fails, infinite if one fails
        that has no finite ratio.
        """
        if not self._failing:
            return 0.0
        return float(10.0 ** -min(map(_margin, self._failing)))

    @property
    def by(self) -> str:
        """The check and quantity that is farthest beyond its bound."""
        worst = min(self._failing, key=_margin)
        return f"{worst.check}/{worst.quantity}"

    @property
    def _failing(self) -> list[Finding]:
        return [finding for finding in self.findings if finding.outcome == "fail"]


def _margin(finding: Finding) -> float:
    """The margin of a finding [decades]; minus infinity without one."""
    if finding.margin is None:
        return -math.inf
    return finding.margin


def measured(
    specification: Specification,
    store: Store,
    workers: int,
    progress: Progress,
    *,
    use_store: bool = True,
) -> list[Resolution]:
    """The resolution of every method of every engine on every case of a campaign, in the order of
    its rows.

    Each is measured in a worker process. Results are kept in the store, and are read from there if
    nothing has changed, unless `use_store` is False.
    """
    engines, _ = plan.engines(specification)
    # Static questions and maps have no scene. An instance may be in several rows.
    by_label = {
        row.instance.label: row
        for row in plan.rows(specification, engines)
        if row.is_judged and isinstance(row.instance.problem, Motion)
    }
    rows = list(by_label.values())
    names = {engine.address: engine.name for engine in engines}
    found: dict[_Place, Resolution] = {}
    places = _places(rows)
    keys: dict[_Place, str | None] = {}
    if use_store:
        keys = _keys(specification, engines, rows)
    for place, key in keys.items():
        kept = key and store.read("resolution", key, _DECODER.decode)
        if kept:
            found[place] = kept
    missing = [row for row in rows if any(place not in found for place in _places([row]))]
    with Schedule(workers, SECONDS) as schedule:
        requested = [(row.instance, row.delays) for row in missing]
        truths = sampled_truths(schedule, store, requested, progress)
        jobs = []
        for row, truth in zip(missing, truths, strict=True):
            jobs += [
                _job(specification, row.instance, truth, place)
                for place in _places([row])
                if place not in found
            ]
        results = schedule.results(jobs)
        for job, result in counted(results, "resolution", len(jobs), progress):
            if isinstance(result, Failure):
                _, address, _ = job.key
                found[job.key] = _unknown(job.key, names[address], result)
                continue
            found[job.key] = _DECODER.decode(result)
            key = keys.get(job.key)
            if key:
                store.put("resolution", key, result)
    return [found[place] for place in places]


_Place = tuple[str, str, str]
"""Label of the instance, address of the engine, and method."""


def _places(rows: Iterable[plan.Row]) -> list[_Place]:
    """Every method that is judged on some row, in the order of the rows."""
    return [
        (row.instance.label, engine.address, subject.method.name)
        for row in rows
        for engine, supported in row.subjects
        for subject, reason in supported
        if reason is None
    ]


def _keys(
    specification: Specification, engines: list[Engine], rows: Iterable[plan.Row]
) -> dict[_Place, str | None]:
    """The keys in the store of the places of rows: digests of the place and of everything that its
    verdicts depend on; None where that cannot be determined.
    """
    by_address = {engine.address: engine for engine in engines}
    states: dict[tuple[int, str], str | None] = {}
    keys: dict[_Place, str | None] = {}
    for row in rows:
        narrow = msgspec.structs.replace(specification.of_one(row.instance), name="")
        for place in _places([row]):
            _, address, _ = place
            of_levels = (narrow.levels, address)
            if of_levels not in states:
                states[of_levels] = unchanged.key_of(narrow, [by_address[address]])
            state = states[of_levels]
            keys[place] = state and hashlib.sha256("\0".join([state, *place]).encode()).hexdigest()
    return keys


def _unknown(place: _Place, engine: str, failure: Failure) -> Resolution:
    """The resolution, without results, of a method whose job failed."""
    label, _, method = place
    unknown = NumberResolution(
        number="any number", reason=f"it could not be measured: {failure.sentence}"
    )
    return Resolution(label=label, engine=engine, method=method, numbers=(unknown,))


def _job(
    specification: Specification, instance: Instance, truth: SampledTruth, place: _Place
) -> Job:
    """The job of one method on one case."""
    _, address, method = place
    return Job(
        place,
        of_method,
        (
            msgspec.json.encode(specification.of_one(instance, method)),
            instance.case.id,
            instance.p.given,
            msgspec.msgpack.encode(truth),
            address,
        ),
    )


def of_method(
    specification: bytes, case: str, given: dict[str, str], truth: bytes, address: str
) -> bytes:
    """The resolution of the method that the specification names, as MessagePack of a Resolution."""
    requested = msgspec.json.decode(specification, type=Specification)
    instance = discovery.case(case).at(**given)
    sampled = msgspec.msgpack.decode(truth, type=SampledTruth)
    engine = discovery.engine(address)
    return msgspec.msgpack.encode(resolution(requested, engine, instance, sampled))


def resolution(
    specification: Specification, engine: Engine, instance: Instance, truth: SampledTruth
) -> Resolution:
    """The resolution of the method that the specification names, for each number of the scene.

    Only checks that read nothing but plain runs of the refinement levels are used. In runs of the
    scene shifted, boosted, relabelled or reversed a number is mostly misread in the same way, so
    that their comparison detects nothing. It may detect a misread start, or a number of one body:
    1.05 (x + s) - s is not 1.05 x. The verdict of all checks is therefore at least as sharp.
    """
    (task,) = plan.tasks(specification, instance, (), engine, truth, truth.reason)
    narrow = msgspec.structs.replace(specification, checks=checks_of_plain_runs(task))
    judge = _Judge(narrow, engine, instance, truth, of_engine(engine))
    sound = judge.trial(None, 0.0)
    if any(finding.outcome in ("fail", "error") for finding in sound.findings):
        why = "a finding fails without any misreading"
        resolutions = [
            NumberResolution(number=number.name, reason=why) for number in numbers(instance.scene)
        ]
    else:
        resolutions = [judge.resolution_of(number, sound) for number in numbers(instance.scene)]
    return Resolution(
        label=instance.label,
        engine=engine.name,
        method=specification.method,
        numbers=tuple(resolutions),
    )


def checks_of_plain_runs(task: Task) -> list[str]:
    """Names of the checks that read nothing but plain runs of the refinement levels."""
    plain = set(task.subject.plain)
    return [check.name for check in task.checks if set(check.needs(task.subject)) <= plain]


@dataclass(frozen=True)
class _Judge:
    """Judges runs of one method in which a number is misread."""

    specification: Specification
    engine: Engine
    instance: Instance
    truth: SampledTruth
    deviations: list[Deviation]

    def resolution_of(self, number: Number, sound: Trial) -> NumberResolution:
        """The resolution for one number; `sound` is the trial without any misreading."""
        sign = 1.0
        first = self.trial(number, sign * FIRST)
        if first.refused:
            # Some numbers cannot be larger, such as a restitution of 1.
            sign = -1.0
            first = self.trial(number, sign * FIRST)
        if first.refused:
            return NumberResolution(number=number.name, reason=first.refused)
        found = threshold(lambda amount: self.trial(number, sign * amount), first)
        if found.detected is not None:
            return NumberResolution(number=number.name, smallest=found.detected, by=found.by)
        return NumberResolution(
            number=number.name, reason=self._reason(sound, first, found.undetected)
        )

    def _reason(self, sound: Trial, first: Trial, undetected: float) -> str:
        """Why no misreading of a number was detected; `undetected` is the largest possible one."""
        change = float(np.max(distances(self.instance, first.run, sound.run)))
        if change <= STILL:
            return "the motion does not depend on it"
        return (
            f"misread by {FIRST:g} it moves the run by {change:.1g} of its scales, and misread by"
            f" {undetected:g} no finding on its own runs fails either"
        )

    def trial(self, number: Number | None, amount: float) -> Trial:
        """The runs with a number multiplied by 1 + amount, judged; without a number as they are."""
        engine = self.engine
        if number is not None:
            misreads = number.misread

            def before(request: Request) -> Request:
                return misreads(request, 1.0 + amount)

            fault = Fault(
                name=f"{number.name} x {1.0 + amount!r}",
                kind="misread",
                sentence="",
                on=(),
                sees=("", ""),
                before=before,
            )
            engine = Carrier(self.engine, fault)
        (task,) = plan.tasks(
            self.specification, self.instance, (), engine, self.truth, self.truth.reason
        )
        runs: dict[Variant, Run] = {}
        record = record_of(task, runs, self.deviations)
        finest = runs.get(task.subject.finest)
        return Trial(record.findings, finest, _refused(runs.values()))


def _refused(runs: Iterable[Run]) -> str:
    """Why some run ended without a trajectory; empty if none did."""
    for run in runs:
        if run.failure is not None:
            return f"it cannot be misread here: {run.failure.sentence}"
    return ""


@dataclass
class Threshold:
    """The search for the smallest misreading that makes a finding fail.

    It is between `undetected`, the largest undetected misreading, and `detected`, the smallest
    detected one, which the check and quantity `by` detected. A ratio r of error to bound at a
    misreading a predicts the threshold a/r, since errors are proportional to a. The next trial is
    1.2 a/r for r > 2 and 0.8 a/r otherwise, so that trials soon enclose the threshold within the
    factor CLOSE.
    """

    undetected: float = 0.0
    detected: float | None = None
    by: str = ""

    def add(self, amount: float, trial: Trial) -> None:
        """Updates the bracket with the result of a trial."""
        if trial.excess == 0.0:
            self.undetected = max(self.undetected, amount)
        elif self.detected is None or amount < self.detected:
            self.detected = amount
            self.by = trial.by

    @property
    def is_found(self) -> bool:
        """True if nothing more is to be tried."""
        if self.detected is None:
            return self.undetected >= 1.0
        return self.detected <= LEAST or self.detected <= CLOSE * self.undetected

    def next_amount(self, amount: float, trial: Trial) -> float:
        """The misreading to try after that of `amount`."""
        excess = trial.excess
        if excess == 0.0:
            following = 10.0 * amount
        elif not math.isfinite(excess):
            following = amount / 10.0
        elif excess > 2.0:
            following = 1.2 * amount / excess
        else:
            following = 0.8 * amount / excess
        if self.detected is not None and not self.undetected < following < self.detected:
            following = math.sqrt(max(self.undetected, LEAST) * self.detected)
        return min(1.0, max(LEAST, following))


def threshold(trial: Callable[[float], Trial], first: Trial) -> Threshold:
    """The threshold of the misreadings that `trial` judges; `first` is its result at FIRST."""
    found = Threshold()
    amount = FIRST
    latest = first
    for _ in range(MOST_TRIALS):
        found.add(amount, latest)
        if found.is_found:
            break
        amount = found.next_amount(amount, latest)
        latest = trial(amount)
        if latest.refused:
            break
    return found
