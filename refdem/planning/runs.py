"""The third stage of a campaign: the runs that its tasks need, and their results.

Equal runs are made once, and unchanged ones are read from the store.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import msgspec

from refdem.core.answer_csv import most_rows
from refdem.core.engine import ProgramEngine
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.execution import worker
from refdem.execution.schedule import Job, Progress, Scheduler, counted
from refdem.execution.spool import Spool
from refdem.planning import plan
from refdem.planning.plan import Task

GRACE = 30.0
"""Seconds in addition to an engine's own time limit before its worker is killed: for its start, for
reading the trajectory and for keeping the files of a failed run.
"""
ENOUGH = 2
"""Number of different steps at which a method hung after which it is not run at other steps."""
HELD = 50_000_000
"""Most bytes of packed trajectories of a task that are in memory while it is judged, in addition to
those that a check holds itself.
"""
Place = tuple[int, Variant]
"""A run by the number of its task in the plan, and its variant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RequestedRun:
    """One run that a task needs, and its key: equal runs have equal keys."""

    place: Place
    task: Task
    request: Request
    key: str


@dataclass(kw_only=True)
class Runs:
    """Runs by the number of their task and by variant, without their trajectories, which `spool`
    has under their keys.
    """

    spool: Spool
    by_task: dict[int, dict[Variant, Run]] = field(default_factory=dict)

    def add(self, place: Place, run: Run) -> None:
        """Adds a run at its place."""
        number, variant = place
        self.by_task.setdefault(number, {})[variant] = run

    def of_task(self, number: int, change: str | None = None) -> dict[Variant, Run]:
        """The runs of one task by variant, without their trajectories; `change`, if any, is that of
        the only variants. A run that continues from one that failed is not there.
        """
        runs = self.by_task.get(number, {})
        return {v: run for v, run in runs.items() if change in (None, v.change)}

    def __iter__(self) -> Iterator[Run]:
        for runs in self.by_task.values():
            yield from runs.values()

    def different(self, *, read: bool) -> int:
        """The number of different runs that were read from the store (`read`), or were made."""
        return len({run.key for run in self if run.from_store == read})

    def trajectory(self, run: Run) -> Trajectory | None:
        """The trajectory of one of these runs, unpacked anew; None if the run failed."""
        if run.failure is not None:
            return None
        return Trajectory.from_bytes(self.spool.read(run.key))

    @property
    def is_lasting(self) -> bool:
        """True if every run would end in the same way again: none crashed, hung or failed by
        chance.
        """
        return all(is_lasting(run.failure) for run in self)


class Recent:
    """A least-recently-used cache of the trajectories of runs, of at most HELD bytes.

    Most trajectories are then read only once.
    """

    def __init__(self, runs: Runs) -> None:
        self._runs = runs
        self._held: dict[str, Trajectory] = {}
        """The trajectories by the keys of their runs, the most recently used one last."""

    def trajectory(self, run: Run) -> Trajectory | None:
        """The trajectory of a run; None if the run failed."""
        if run.failure is not None:
            return None
        trajectory = self._held.pop(run.key, None)
        if trajectory is None:
            self._make_room(self._runs.spool.size(run.key))
            trajectory = self._runs.trajectory(run)
            assert trajectory is not None
        self._held[run.key] = trajectory
        return trajectory

    def _make_room(self, size: int) -> None:
        """Drops the least recently used trajectories, to make room for another of `size` bytes."""
        held = sum(map(self._runs.spool.size, self._held))
        for key in list(self._held):
            if held + size <= HELD:
                return
            held -= self._runs.spool.size(key)
            del self._held[key]


def is_lasting(failure: Failure | None) -> bool:
    """True for reproducible ends of a run: a trajectory, or a refusal."""
    return failure is None or failure.kind == "unsupported"


@dataclass(frozen=True)
class Hangs:
    """The steps [s] with which each method hung on each instance of a campaign."""

    steps: dict[tuple[str, str, str], set[float]] = field(default_factory=dict)

    def note(self, requested: RequestedRun, failure: Failure | None) -> None:
        """Remembers the step of a run that hung."""
        if failure is not None and failure.kind == "hang":
            self.steps.setdefault(_method_on_case(requested.task), set()).add(
                _step(requested.request)
            )

    def given_up(self, requested: RequestedRun) -> Failure | None:
        """The failure of a run that is not started because others hung, or None.

        A run takes longer than one with a larger step, so it is not started if that one hung. A
        method that hung with ENOUGH different steps is expected to hang with every step.
        """
        steps = self.steps.get(_method_on_case(requested.task), set())
        takes_longer = any(_step(requested.request) <= step for step in steps)
        if not takes_longer and len(steps) < ENOUGH:
            return None
        return Failure(
            kind="hang",
            sentence=(
                "it was not started: another run of this method on this case exceeded its time"
                " limit"
            ),
            is_begun=False,
        )


def _method(task: Task) -> tuple[str, str]:
    """The names of engine and method."""
    return task.engine.name, task.method.name


def _method_on_case(task: Task) -> tuple[str, str, str]:
    """Engine, method and case with its parameters."""
    return task.engine.name, task.method.name, task.subject.instance.label


def _step(request: Request) -> float:
    """The size of the step [s]; 0 for a run without steps."""
    return abs(request.step or 0.0)


@dataclass(frozen=True, kw_only=True)
class Runner:
    """Makes runs with the workers of `schedule`, within `timeout` [s] each, and stores them.

    Trajectories are moved into the `spool` as they arrive, because all of them would need too much
    memory.
    `versions` are those of the engines by name; `deadlines` are the times [s] of the monotonic
    clock after which nothing more is run in an engine.
    """

    schedule: Scheduler
    store: Store
    spool: Spool
    use_store: bool
    timeout: float
    versions: Mapping[str, str]
    deadlines: Mapping[str, float]
    hangs: Hangs
    progress: Progress
    on_request: Callable[[RequestedRun], None] = lambda requested: None
    """Called with each run that is needed, before any of them is made."""

    def runs(self, requested: list[RequestedRun], stage: str) -> Iterator[tuple[RequestedRun, Run]]:
        """Every request with its run, in the order in which they end.

        Equal runs are made once, and unchanged ones are read from the store.
        """
        equal: dict[str, list[RequestedRun]] = {}
        for request_of_task in requested:
            self.on_request(request_of_task)
            equal.setdefault(request_of_task.key, []).append(request_of_task)
        unread = {}
        for key, same in equal.items():
            stored = self._read(key)
            if stored is None:
                unread[key] = same
            else:
                yield from self._answered(same, stored, from_store=True)
        leaking = set()
        jobs = [self._job(same[0]) for same in unread.values()]
        results = self.schedule.results(jobs)
        for job, result in counted(results, stage, len(jobs), self.progress):
            same = unread[job.key]
            reply = self._kept(job.key, result)
            self.hangs.note(same[0], reply.failure)
            if reply.failure is not None and reply.failure.kind == "leak":
                leaking.add(_method(same[0].task))
            yield from self._answered(same, reply, from_store=False)
        # The results of these methods depend on earlier requests, so that none of them can be
        # trusted, including those before the one in which this was detected.
        for key, same in equal.items():
            if _method(same[0].task) in leaking:
                self.store.forget("run", key)

    def _read(self, key: str) -> worker.Reply | None:
        """The stored reply of the run with this key, or None."""
        if not self.use_store:
            return None
        reply = self.store.read("run", key, checked_reply)
        if reply is None:
            return None
        return self._spooled(key, reply)

    def _answered(
        self, same: list[RequestedRun], reply: worker.Reply, *, from_store: bool
    ) -> Iterator[tuple[RequestedRun, Run]]:
        """Equal requests of tasks, each with the run that answers them all."""
        for requested in same:
            yield requested, self._run(requested, reply, from_store=from_store)

    def _job(self, requested: RequestedRun) -> Job:
        """The job that makes one run in a worker, or in a program of its own.

        An engine with a `time_limit` ends its programs itself. It does so before its worker would
        be killed.
        """
        engine = requested.task.engine
        request = requested.request
        limit = None
        if engine.time_limit is not None:
            limit = max(self.timeout, engine.time_limit + GRACE)
        stages = None
        rows = 0
        if isinstance(engine, ProgramEngine):
            stages = worker.stages
            rows = most_rows(request.problem)
        deadline = self.deadlines.get(engine.name, math.inf)
        return Job(
            requested.key,
            worker.run,
            timeout=limit,
            computes=stages is None,
            stages=stages,
            rows=rows,
            given_up=partial(self.hangs.given_up, requested),
            pack=lambda: (engine.address, request.packed(), deadline),
        )

    def _kept(self, key: str, result: bytes | Failure) -> worker.Reply:
        """The reply of a run that ended; it is stored if its end is reproducible."""
        if isinstance(result, Failure):
            return worker.Reply(failure=result)
        reply = msgspec.msgpack.decode(result, type=worker.Reply)
        if is_lasting(reply.failure):
            self.store.put("run", key, result)
        return self._spooled(key, reply)

    def _spooled(self, key: str, reply: worker.Reply) -> worker.Reply:
        """The reply without its trajectory, which goes into the spool."""
        if reply.failure is None:
            self.spool.keep(key, reply.trajectory)
        return worker.Reply(cost=reply.cost, failure=reply.failure)

    def _run(self, requested: RequestedRun, reply: worker.Reply, *, from_store: bool) -> Run:
        """The run that one task requested, from the reply; its trajectory is in the spool."""
        name = requested.task.engine.name
        return Run(
            key=requested.key,
            request=requested.request,
            engine=name,
            version=self.versions[name],
            failure=reply.failure,
            cost=reply.cost,
            from_store=from_store,
        )


def checked_reply(data: bytes) -> worker.Reply:
    """The reply of a worker; raises ValueError for bytes that are none, or whose trajectory is
    none.
    """
    reply = msgspec.msgpack.decode(data, type=worker.Reply)
    reply.unpacked()
    return reply


def requested_runs(
    tasks: list[Task],
    wanted: Mapping[int, tuple[Variant, ...]],
    fingerprints: Mapping[tuple[str, str], str],
    ulps: int,
    first: Runs | None = None,
) -> list[RequestedRun]:
    """The wanted runs of tasks from the start, or those that continue from the end of a `first`
    one.
    """
    needed = []
    for number, variants in wanted.items():
        task = tasks[number]
        for variant in variants:
            if variant.goes_on != (first is not None):
                continue
            base = None
            if first is not None:
                base = first.trajectory(first.of_task(number)[variant.base])
            # There is no end to continue from where the first run failed.
            if variant.goes_on and base is None:
                continue
            request = plan.request(task, variant, base, ulps=ulps)
            engine = task.engine.name
            key = request.key(engine, fingerprints[engine, task.method.name])
            needed.append(
                RequestedRun(place=(number, variant), task=task, request=request, key=key)
            )
    return needed


def fingerprints_of(tasks: Iterable[Task]) -> dict[tuple[str, str], str]:
    """The fingerprint of every engine and method that runs.

    Each is computed once, so that all runs of a campaign belong to one state of the code.
    """
    methods = {(task.engine.name, task.method.name): task for task in tasks if task.variants}
    return {key: task.engine.fingerprint(task.method) for key, task in methods.items()}
