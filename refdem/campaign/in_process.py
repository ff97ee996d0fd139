"""Runs in this process: one task of an engine that need not be discovered, from its plan to its
record; nothing is stored.
"""

from collections.abc import Iterable

import msgspec

from refdem.campaign import judging, plan, worker
from refdem.campaign.kept_truth import kept_truth
from refdem.campaign.plan import Task
from refdem.campaign.specification import Specification
from refdem.core.case import Instance
from refdem.core.engine import Engine, finished
from refdem.core.finding import Record
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import RefdemError


def truth_of(instance: Instance) -> SampledTruth:
    """The certified samples of an instance, those kept where they are not stale; until = 0 and a
    reason if there are none.
    """
    kept = kept_truth(instance)
    if kept is not None:
        return kept
    return msgspec.msgpack.decode(
        worker.sampled_truth(instance.case.id, instance.p.given), type=SampledTruth
    )


def task_of(
    engine: Engine,
    method: str,
    instance: Instance,
    truth: SampledTruth,
    levels: int,
    checks: Iterable[str] = (),
) -> Task:
    """The task of one method on an instance with only these checks (none: all that apply)."""
    specification = Specification(
        name="in process", case=[], levels=levels, method=method, checks=list(checks)
    )
    (task,) = plan.tasks(specification, instance, (), engine, truth, truth.reason)
    return task


def record_of(task: Task, known: dict[Variant, Run] | None = None) -> Record:
    """Runs and judges a task; runs of the same engine that are `known` are not made again, and new
    ones become known.
    """
    if known is None:
        runs: dict[Variant, Run] = {}
    else:
        runs = known
    variants: Iterable[Variant] = ()
    if task.unsupported is None:
        variants = task.variants
    for variant in variants:
        base = None
        if variant.goes_on:
            base = runs[variant.base].trajectory
        is_possible = base is not None or not variant.goes_on
        if is_possible and variant not in runs:
            runs[variant] = run_of(task.engine, plan.request(task, variant, base))
    return judging.record(task, task.engine.version(), runs, [])


def run_of(engine: Engine, request: Request) -> Run:
    """One run; whatever an engine raises becomes a Failure, as does a request that cannot be
    written.
    """
    try:
        # As a worker gets it.
        asked = Request.unpacked(request.packed())
    except RefdemError as error:
        reply = worker.Reply(failure=Failure(kind="contract", sentence=str(error)))
    else:
        reply = finished(worker.reply_of(engine.name, asked, engine))
    return Run(
        key="",
        request=request,
        engine=engine.name,
        version="",
        trajectory=reply.unpacked(),
        failure=reply.failure,
        cost=reply.cost,
    )
