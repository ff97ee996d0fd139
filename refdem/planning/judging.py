"""From the runs of a task to its record: every applicable check judges, runs that failed become one
error finding, expected deviations are applied.

A *task* is one method of one engine on one instance; a *variant* is one of its runs: a step and at
most one change, such as a rotated scene.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain

import msgspec

from refdem.core import symmetry
from refdem.core.check import Check, CompletedRun
from refdem.core.deviation import Deviation
from refdem.core.finding import DECIDED, Finding, Record
from refdem.core.judgement import undecided
from refdem.core.run import Failure, Run
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.errors import RefdemError
from refdem.planning import plan
from refdem.planning.deviations import applied
from refdem.planning.plan import Task

Needs = Mapping[str, tuple[Variant, ...]]
"""The runs that each check of a task needs, by its name."""


def record(
    task: Task,
    version: str,
    runs: Mapping[Variant, Run],
    deviations: list[Deviation],
    read: Callable[[Run], Trajectory | None] = lambda run: run.trajectory,
    needed: Needs | None = None,
) -> Record:
    """The record of one task; it has an error finding if no check could decide anything.

    `read` returns the trajectory of a run whose trajectory is not in memory. `needed` is the result
    of `needs` for these runs, if it is known.
    """
    instance = task.subject.instance
    if needed is None:
        needed = needs(task, runs, read)
    findings = _findings(task, runs, read, needed)
    if _is_void(task, findings):
        reasons = "; ".join(dict.fromkeys(f.sentence for f in findings)) or "no check applies"
        says = f"Nothing was decided: {reasons}"
        findings.append(Finding(check="record", quantity="decided", outcome="error", sentence=says))
    costs = [run.cost for run in runs.values() if run.cost]
    seconds = sum(cost.seconds for cost in costs)
    keys = tuple(run.key for run in runs.values())
    judged_record = Record(
        case=instance.case.id,
        label=instance.label,
        parameters=instance.p.texts(),
        engine=task.engine.name,
        version=version,
        method=task.method.name,
        is_reference=task.engine.is_reference,
        runs=keys,
        findings=tuple(findings),
        seconds=seconds,
    )
    return applied(judged_record, deviations)


def _is_void(task: Task, findings: list[Finding]) -> bool:
    """True if nothing was decided and nothing explains it: no refusal, no error, and no selection
    of checks.

    A selected check may be unable to decide anything for a method, and then its own reason is
    reported.
    """
    if any(finding.outcome in (*DECIDED, "error") for finding in findings):
        return False
    is_refused = bool(findings) and all(finding.outcome == "unsupported" for finding in findings)
    is_honest = bool(findings) and task.is_selection
    return not (is_refused or is_honest)


@dataclass(frozen=True, eq=False)
class _Completed(Mapping[Variant, CompletedRun]):
    """The runs of a task that did not fail.

    Each trajectory is read when a check needs it: all trajectories of a large gas at once would
    take most of the memory of a campaign.
    """

    runs: Mapping[Variant, Run]
    read: Callable[[Run], Trajectory | None]

    def __getitem__(self, variant: Variant) -> CompletedRun:
        run = self.runs[variant]
        trajectory = self.read(run)
        assert trajectory is not None
        assert run.cost is not None
        return CompletedRun(trajectory, run.cost)

    def __contains__(self, variant: object) -> bool:
        return variant in self.runs

    def __iter__(self) -> Iterator[Variant]:
        return iter(self.runs)

    def __len__(self) -> int:
        return len(self.runs)


def _findings(
    task: Task,
    runs: Mapping[Variant, Run],
    read: Callable[[Run], Trajectory | None],
    needed_by_check: Needs,
) -> list[Finding]:
    """The findings of a task: how its runs failed, then the findings of its checks."""
    if task.unsupported is not None:
        sentence = f"{task.unsupported[:1].upper()}{task.unsupported[1:]}."
        return [Finding(check="run", quantity="scene", outcome="unsupported", sentence=sentence)]
    completed = _completed(runs, read)
    failed = {variant: run.failure for variant, run in runs.items() if run.failure is not None}
    refused = {variant for variant, failure in failed.items() if failure.kind == "unsupported"}
    permitted = {variant for variant in refused if _may_refuse(task, variant, runs[variant])}
    # A permitted refusal is a failure only where nothing ran at all.
    reported = {
        variant: failure
        for variant, failure in failed.items()
        if variant not in permitted or not completed
    }
    findings = _failures(task, reported, ran=bool(completed))
    dispensable = _dispensable(runs)
    for check in task.checks:
        needed = needed_by_check[check.name]
        if check.synchronous and task.method.velocity_time != "synchronous":
            reason = "the method reports velocities half a step before its positions"
            findings.append(undecided(check.name, "state", reason))
        elif completed.keys() | dispensable >= set(needed):
            findings += _judged(task, check, completed)
        if completed:
            changes = dict.fromkeys(variant.change for variant in needed if variant in permitted)
            findings += [_refused_variant(check, change, failed) for change in changes]
    return findings


def _completed(runs: Mapping[Variant, Run], read: Callable[[Run], Trajectory | None]) -> _Completed:
    """The runs of a task that did not fail."""
    return _Completed({variant: run for variant, run in runs.items() if run.failure is None}, read)


def _dispensable(runs: Mapping[Variant, Run]) -> set[Variant]:
    """The refused variants without which a check can still judge.

    These are symmetric and perturbed runs, because each is compared with the plain run separately.
    """
    return {
        variant
        for variant, run in runs.items()
        if run.failure is not None
        and run.failure.kind == "unsupported"
        and variant.change in (*symmetry.NAMES, "perturbed")
    }


def _needed(
    task: Task, check: Check, completed: _Completed, dispensable: set[Variant]
) -> tuple[Variant, ...]:
    """The runs that a check needs at first, and once these are there, its further ones."""
    needed = check.needs(task.subject)
    if completed.keys() | dispensable >= set(needed):
        return (*needed, *check.further(task.subject, completed))
    return needed


def needs(
    task: Task,
    runs: Mapping[Variant, Run],
    read: Callable[[Run], Trajectory | None] = lambda run: run.trajectory,
) -> Needs:
    """The runs that each check of a task needs, given the results so far; none where the task is
    not supported.
    """
    if task.unsupported is not None:
        return {}
    completed = _completed(runs, read)
    dispensable = _dispensable(runs)
    return {check.name: _needed(task, check, completed, dispensable) for check in task.checks}


def missing(needed: Needs, runs: Mapping[Variant, Run]) -> tuple[Variant, ...]:
    """The runs among those needed that were not tried yet; a run precedes those that continue from
    it.
    """
    return tuple(
        variant
        for variant in plan.in_order(chain.from_iterable(needed.values()))
        if variant not in runs and _is_possible(variant, runs)
    )


def _is_possible(variant: Variant, runs: Mapping[Variant, Run]) -> bool:
    """False for a run that continues from the end of one that failed."""
    base = runs.get(variant.base)
    return not variant.goes_on or base is None or base.failure is None


_ERROR = Finding(check="run", quantity="trajectory", outcome="error", sentence="")


def _may_refuse(task: Task, variant: Variant, run: Run) -> bool:
    """True if the engine declares that it cannot make this run.

    Either the variant is among those that it may refuse, or it does not support the start of this
    particular run. The start was not known when the runs were planned: it may be the end of another
    run, and bodies may no longer touch at a start moved by an ulp.
    """
    if variant.change in task.engine.may_refuse:
        return True
    return task.engine.unsupported(run.request.problem, task.method) is not None


def _refused_variant(check: Check, change: str, failed: Mapping[Variant, Failure]) -> Finding:
    """The finding on a variant that the engine refused, as it declares that it may."""
    failure = next(failure for variant, failure in failed.items() if variant.change == change)
    sentence = f"The engine refused the variant `{change}` during the run: {failure.sentence}."
    return Finding(check=check.name, quantity=change, outcome="unsupported", sentence=sentence)


def _failures(task: Task, failed: Mapping[Variant, Failure], *, ran: bool) -> list[Finding]:
    """At most one finding for all runs that failed: the worst of them, an error before a refusal.

    A program that refuses every run does not support the scene. Any other refusal is an error: a
    program that runs a scene must run it at every step and in every variant, and the reference may
    refuse only before it runs.
    """
    if not failed:
        return []
    broken = {
        variant: failure for variant, failure in failed.items() if failure.kind != "unsupported"
    }
    if not broken and not ran and not task.engine.is_reference:
        sentence = _failure_sentence(failed, len(failed))
        return [msgspec.structs.replace(_ERROR, outcome="unsupported", sentence=sentence)]
    sentence = _failure_sentence(broken or failed, len(failed))
    if not broken:
        if task.engine.is_reference:
            sentence += _REFUSED_BY_THE_REFERENCE
        else:
            sentence += _REFUSED_IN_PART
    return [msgspec.structs.replace(_ERROR, sentence=sentence)]


_REFUSED_BY_THE_REFERENCE = " The reference must report before a run what it cannot run."
_REFUSED_IN_PART = (
    " The engine ran the same scene in other variants; an engine that supports a scene must run it"
    " at every step and in every variant (exceptions are listed as engine.may_refuse in"
    " refdem.toml)."
)


def _failure_sentence(failures: Mapping[Variant, Failure], count: int) -> str:
    """The first of some failures in a sentence, with the number of all runs that failed, `count`.

    A run that was started precedes those that were not, because it is the cause. Which runs were
    not started depends on the number of runs in parallel.
    """
    begun = {variant: failure for variant, failure in failures.items() if failure.is_begun}
    variant, failure = next(iter((begun or failures).items()))
    if count > 1:
        total = f" ({count} runs failed)"
    else:
        total = ""
    cause = failure.sentence.rstrip(".")
    return f"The run at {variant} ended without a trajectory ({failure.kind}){total}: {cause}."


def _judged(task: Task, check: Check, outcomes: Mapping[Variant, CompletedRun]) -> list[Finding]:
    """The findings of a check; a trajectory that it cannot process is an error of the engine."""
    try:
        return check.judge(task.subject, outcomes)
    except RefdemError as error:
        return [msgspec.structs.replace(_ERROR, check=check.name, sentence=str(error))]
