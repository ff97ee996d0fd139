"""The third stage of a campaign: the runs that its tasks need, and their results.

Equal runs are made once, and unchanged ones are read from the store.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import msgspec

from refdem.campaign import judging, plan, worker
from refdem.campaign.plan import Task
from refdem.campaign.schedule import Job, Progress, Scheduler, counted
from refdem.campaign.spool import Spool
from refdem.core.answer_csv import most_rows
from refdem.core.engine import ProgramEngine
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

GRACE = 30.0
"""Seconds beyond an engine's own time limit before its worker is killed: to start, to read the
trajectory, to keep what failed.
"""
ENOUGH = 2
"""A method that hung at so many different steps is not tried at others."""
HELD = 50_000_000
"""Packed bytes of the trajectories of a task that are held while it is judged, beside those that a
check holds itself.
"""
Place = tuple[int, Variant]
"""A run by the number of its task in the plan, and its variant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """One run that a task needs, and its key: equal runs have equal keys."""

    place: Place
    task: Task
    request: Request
    key: str


@dataclass(frozen=True, kw_only=True)
class Runs:
    """Runs by their places, without their trajectories, which `spool` has under their keys; how
    many different ones were made now, and how many were read.
    """

    by_place: Mapping[Place, Run]
    spool: Spool
    made: int
    read: int

    @cached_property
    def by_task(self) -> Mapping[int, Mapping[Variant, Run]]:
        """The same runs by the number of their task, and by variant."""
        found: dict[int, dict[Variant, Run]] = {}
        for (number, variant), run in self.by_place.items():
            found.setdefault(number, {})[variant] = run
        return found

    def with_more(self, more: "Runs") -> "Runs":
        """Runs of the same tasks: these, and more of them."""
        return Runs(
            by_place={**self.by_place, **more.by_place},
            spool=self.spool,
            made=self.made + more.made,
            read=self.read + more.read,
        )

    def of_task(self, number: int, change: str | None = None) -> dict[Variant, Run]:
        """The runs of one task by variant, without their trajectories; `change`, if any, is that of
        the only variants. A run that goes on from one that failed is not there.
        """
        runs = self.by_task.get(number, {})
        return {v: run for v, run in runs.items() if change in (None, v.change)}

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
        return all(is_lasting(run.failure) for run in self.by_place.values())


class Recent:
    """The trajectories of runs, read when they are asked for; the last ones are held, up to HELD
    bytes of them, so that most are read once.
    """

    def __init__(self, runs: Runs) -> None:
        self._runs = runs
        self._held: dict[str, Trajectory] = {}
        """By the keys of their runs, the one asked for last at the end."""

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
        """Lets go of the trajectories that were not asked for longest, for another of `size`
        bytes.
        """
        held = sum(map(self._runs.spool.size, self._held))
        for key in list(self._held):
            if held + size <= HELD:
                return
            held -= self._runs.spool.size(key)
            del self._held[key]


def is_lasting(failure: Failure | None) -> bool:
    """True for ends that a run comes to every time: a trajectory, or a refusal."""
    return failure is None or failure.kind == "unsupported"


@dataclass(frozen=True)
class Hangs:
    """The steps [s] with which a method hung on an instance, remembered from run to run."""

    steps: dict[tuple[str, str, str], set[float]] = field(default_factory=dict)

    def note(self, asked: Asked, failure: Failure | None) -> None:
        """Remembers the step of a run that hung."""
        if failure is not None and failure.kind == "hang":
            self.steps.setdefault(_method_on_case(asked.task), set()).add(_step(asked.request))

    def given_up(self, asked: Asked) -> Failure | None:
        """The failure of a run that is not started because others hung, or None.

        A run takes longer than one with a larger step that hung; and a method that hung with ENOUGH
        different steps is expected to hang with every step.
        """
        steps = self.steps.get(_method_on_case(asked.task), set())
        takes_longer = any(_step(asked.request) <= step for step in steps)
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
    """Makes runs: with the workers of `schedule`, within `timeout` [s] each, kept in `store`.

    Their trajectories go into the `spool` as they come: all of them at once need much memory.
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

    def runs(self, asked: list[Asked], stage: str) -> Runs:
        """Everything that is asked for: equal runs once, unchanged ones from the store."""
        equal: dict[str, list[Asked]] = {}
        for request_of_task in asked:
            equal.setdefault(request_of_task.key, []).append(request_of_task)
        read = self._read(equal)
        jobs = [self._job(same[0]) for key, same in equal.items() if key not in read]
        computed: dict[str, worker.Reply] = {}
        results = self.schedule.results(jobs)
        for job, result in counted(results, stage, len(jobs), self.progress):
            reply = self._kept(job.key, result)
            computed[job.key] = reply
            self.hangs.note(equal[job.key][0], reply.failure)
        self._forget_leaking(equal, computed)
        replies = read | computed
        by_place = {
            request_of_task.place: self._run(
                request_of_task,
                replies[request_of_task.key],
                from_store=request_of_task.key in read,
            )
            for request_of_task in asked
        }
        return Runs(by_place=by_place, spool=self.spool, made=len(computed), read=len(read))

    def _forget_leaking(
        self, equal: Mapping[str, list[Asked]], computed: Mapping[str, worker.Reply]
    ) -> None:
        """Takes the runs of methods whose answers depend on what they were asked before out of the
        store: none of them can be trusted, whichever of them showed it.
        """
        leaking = {
            _method(equal[key][0].task)
            for key, reply in computed.items()
            if reply.failure is not None and reply.failure.kind == "leak"
        }
        for key, same in equal.items():
            if _method(same[0].task) in leaking:
                self.store.forget("run", key)

    def _read(self, keys: Iterable[str]) -> dict[str, worker.Reply]:
        """The replies that the store has to the runs with these keys."""
        if not self.use_store:
            return {}
        stored = {}
        for key in keys:
            reply = self.store.read("run", key, checked_reply)
            if reply is not None:
                stored[key] = self._spooled(key, reply)
        return stored

    def _job(self, asked: Asked) -> Job:
        """The job that makes one run in a worker, or in a program of its own.

        An engine that ends its programs itself, by `time_limit`, does so before its worker would be
        killed.
        """
        engine = asked.task.engine
        request = asked.request
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
            asked.key,
            worker.run,
            timeout=limit,
            computes=stages is None,
            stages=stages,
            rows=rows,
            given_up=partial(self.hangs.given_up, asked),
            pack=lambda: (engine.address, request.packed(), deadline),
        )

    def _kept(self, key: str, result: bytes | Failure) -> worker.Reply:
        """The reply of a run that ended; it is stored unless it may end otherwise next time."""
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

    def _run(self, asked: Asked, reply: worker.Reply, *, from_store: bool) -> Run:
        """The run that one task asked for, from the reply; its trajectory is in the spool."""
        name = asked.task.engine.name
        return Run(
            key=asked.key,
            request=asked.request,
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


def of_tasks(runner: Runner, tasks: list[Task], ulps: int) -> Runs:
    """All runs of the tasks of a plan: those that their checks need at first, and then those that
    they ask for in view of what came out, until they ask for no more.

    `ulps` moves the start of every run; those that go on from the end of another have no start of
    their own.
    """
    fingerprints = fingerprints_of(tasks)
    runs = Runs(by_place={}, spool=runner.spool, made=0, read=0)
    wanted = {number: task.variants for number, task in enumerate(tasks)}
    stage = "runs"
    while any(wanted.values()):
        from_start = _asked(tasks, wanted, fingerprints, ulps)
        runs = runs.with_more(runner.runs(from_start, stage))
        going_on = _asked(tasks, wanted, fingerprints, 0, runs)
        runs = runs.with_more(runner.runs(going_on, f"{stage} that go on"))
        wanted = _further(tasks, runs, wanted)
        stage = "finer runs"
    return runs


def _further(
    tasks: list[Task], runs: Runs, wanted: Mapping[int, tuple[Variant, ...]]
) -> dict[int, tuple[Variant, ...]]:
    """The variants that tasks ask for in view of their runs, by the number of the task.

    Only those that wanted some before ask again: the others have seen all that they will see.
    """
    asked = {}
    for number, variants in wanted.items():
        if variants:
            read = Recent(runs).trajectory
            asked[number] = judging.further(tasks[number], runs.of_task(number), read)
    return asked


def _asked(
    tasks: list[Task],
    wanted: Mapping[int, tuple[Variant, ...]],
    fingerprints: Mapping[tuple[str, str], str],
    ulps: int,
    first: Runs | None = None,
) -> list[Asked]:
    """The wanted runs of tasks from the start, or those that go on from the end of a `first`
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
                base = first.trajectory(first.by_place[number, variant.base])
            # There is no end to go on from where the first run failed.
            if variant.goes_on and base is None:
                continue
            request = plan.request(task, variant, base, ulps=ulps)
            engine = task.engine.name
            key = request.key(engine, fingerprints[engine, task.method.name])
            needed.append(Asked(place=(number, variant), task=task, request=request, key=key))
    return needed


def fingerprints_of(tasks: Iterable[Task]) -> dict[tuple[str, str], str]:
    """The fingerprint of every engine and method that runs, asked for once: all runs of a campaign
    are of one state of the code.
    """
    methods = {(task.engine.name, task.method.name): task for task in tasks if task.variants}
    return {key: task.engine.fingerprint(task.method) for key, task in methods.items()}
