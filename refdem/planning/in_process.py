"""Runs in this process: one task of an engine that need not be discovered, from its plan to its
record; nothing is stored.
"""

from collections.abc import Iterable, Sequence

import msgspec

from refdem.core.case import Instance
from refdem.core.deviation import Deviation
from refdem.core.engine import Engine, finished
from refdem.core.finding import Record
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import RefdemError
from refdem.execution import worker
from refdem.planning import judging, plan
from refdem.planning.kept_truth import kept_truth
from refdem.planning.plan import Task
from refdem.planning.specification import Specification


def truth_of(instance: Instance) -> SampledTruth:
    """The certified samples of an instance: those distributed with refdem unless they are stale,
    else proved now.

    If there are none, `until` is 0 and `reason` states why.
    """
    stored = kept_truth(instance)
    if stored is not None:
        return stored
    data = worker.sampled_truth(instance.case.id, instance.p.given)
    return msgspec.msgpack.decode(data, type=SampledTruth)


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


def record_of(
    task: Task,
    known: dict[Variant, Run] | None = None,
    deviations: Sequence[Deviation] = (),
) -> Record:
    """The record of a task, whose runs are made in this process and judged.

    `known` has runs of the same engine, which are not repeated; new ones are added to it.
    `deviations` are the expected deviations of the engine.
    """
    if known is None:
        runs: dict[Variant, Run] = {}
    else:
        runs = known
    needed: judging.Needs | None = None
    variants: Iterable[Variant] = ()
    if task.unsupported is None:
        variants = task.variants
    while variants:
        for variant in variants:
            base = None
            if variant.goes_on:
                base = runs[variant.base].trajectory
            is_possible = base is not None or not variant.goes_on
            if is_possible and variant not in runs:
                runs[variant] = run_of(task.engine, plan.request(task, variant, base))
        needed = judging.needs(task, runs)
        variants = judging.missing(needed, runs)
    return judging.record(task, task.engine.version(), runs, list(deviations), needed=needed)


def run_of(engine: Engine, request: Request) -> Run:
    """One run in this process; whatever an engine raises becomes a Failure, as does a request that
    cannot be written.
    """
    try:
        # Packed and unpacked, the request is what a worker process would get.
        received = Request.unpacked(request.packed())
    except RefdemError as error:
        reply = worker.Reply(failure=Failure(kind="contract", sentence=str(error)))
    else:
        reply = finished(worker.reply_of(engine.name, received, engine))
    return Run(
        key="",
        request=request,
        engine=engine.name,
        version="",
        trajectory=reply.unpacked(),
        failure=reply.failure,
        cost=reply.cost,
    )
