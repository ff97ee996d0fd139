"""From runs to records: every applicable check judges, failures become one error finding, deviations are applied."""

from collections.abc import Mapping

import msgspec

from refdem.campaign.deviations import applied
from refdem.campaign.plan import Task
from refdem.core import symmetry
from refdem.core.check import Check, Outcome
from refdem.core.deviation import Deviation
from refdem.core.finding import DECIDED, Finding, Record
from refdem.core.judgement import undecided
from refdem.core.run import Run
from refdem.core.variant import Variant
from refdem.errors import RefdemError


def record(task: Task, version: str, runs: Mapping[Variant, Run], deviations: list[Deviation]) -> Record:
    """What was found for one task; an error if nothing could be decided."""
    instance = task.trial.instance
    findings = _findings(task, runs)
    if not any(f.outcome in (*DECIDED, "error", "unsupported") for f in findings):
        reasons = "; ".join(dict.fromkeys(f.sentence for f in findings)) or "no check applies"
        findings.append(Finding(check="record", quantity="decided", outcome="error", sentence=f"Nothing was decided: {reasons}"))
    found = Record(
        case=instance.case.id,
        label=instance.label,
        parameters=instance.p.texts(),
        engine=task.engine.name,
        version=version,
        method=task.method.name,
        is_reference=task.engine.is_reference,
        runs=tuple(run.key for run in runs.values()),
        findings=tuple(findings),
        seconds=sum(run.cost.seconds for run in runs.values() if run.cost),
    )
    return applied(found, deviations)


def _findings(task: Task, runs: Mapping[Variant, Run]) -> list[Finding]:
    """The findings of a task, as they come from its checks."""
    if task.refusal is not None:
        return [Finding(check="run", quantity="scene", outcome="unsupported", sentence=f"Not supported: {task.refusal}.")]
    failed = {variant: run.failure for variant, run in runs.items() if run.failure is not None}
    optional = (*symmetry.NAMES, "perturbed")
    unshown = {variant for variant, failure in failed.items() if failure.kind == "unsupported" and variant.change in optional}
    broken = {variant: failure for variant, failure in failed.items() if variant not in unshown}
    findings = []
    if broken:
        variant, failure = next(iter(broken.items()))
        more = f" ({len(broken)} of {len(runs)} runs failed)" if len(broken) > 1 else ""
        outcome = "unsupported" if all(f.kind == "unsupported" for f in broken.values()) else "error"
        sentence = f"The run at {variant} ended without a trajectory ({failure.kind}){more}: {failure.sentence}"
        findings.append(msgspec.structs.replace(_ERROR, outcome=outcome, sentence=sentence))
    outcomes = {v: Outcome(run.trajectory, run.cost) for v, run in runs.items() if run.trajectory is not None and run.cost is not None}
    for check in task.checks:
        if check.synchronous and task.method.velocity_time != "synchronous":
            findings.append(undecided(check.name, "state", "the method gives velocities half a step before its positions"))
        elif all(variant in outcomes or variant in unshown for variant in check.needs(task.trial)):
            findings += _judged(task, check, outcomes)
    return findings


_ERROR = Finding(check="run", quantity="trajectory", outcome="error", sentence="")


def _judged(task: Task, check: Check, outcomes: Mapping[Variant, Outcome]) -> list[Finding]:
    """A check's findings; what a check cannot read of an engine's trajectory is that engine's error."""
    try:
        return check.judge(task.trial, outcomes)
    except RefdemError as error:
        return [msgspec.structs.replace(_ERROR, check=check.name, sentence=str(error))]
