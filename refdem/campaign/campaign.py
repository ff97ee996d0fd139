"""A campaign from specification to sheets: truths, then runs, then what goes on from them, then
judging.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import msgspec

import refdem
from refdem.campaign import judging, plan, required, sheets, unchanged, worker
from refdem.campaign.deviations import of_engine
from refdem.campaign.plan import Task
from refdem.campaign.schedule import InProcess, Job, Schedule
from refdem.campaign.specification import Specification
from refdem.campaign.truths import FAILED, sampled_truths
from refdem.core.answer_csv import most_rows
from refdem.core.case import Instance
from refdem.core.engine import Engine, ProgramEngine
from refdem.core.finding import CampaignSheet, CaseSheet, Sheet
from refdem.core.problem import Request
from refdem.core.refinement import order_levels
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import UsageError

GRACE = 30.0
"""Seconds beyond an engine's own time limit before its worker is killed: to start, to read the
trajectory, to keep what failed.
"""
ENOUGH = 2
"""Steps at which a method did not end in its time, after which it is not tried at others."""
Answer = tuple[worker.Reply, Trajectory | None]
"""What a run came to: its reply, and the trajectory unless it failed."""
Progress = Callable[[str, int, int], None]
"""Told the stage, how many of its jobs are done, and how many there are."""


@dataclass
class Campaign:
    """One campaign under way, in `jobs` worker processes, or in this one if that is 0.

    `use_store` False runs everything anew (truth is proved once all the same).
    """

    specification: Specification
    store: Store
    jobs: int = 2
    use_store: bool = True
    progress: Progress = lambda stage, done, total: None
    made: int = 0
    read: int = 0
    runs: dict[tuple[int, Variant], Run] = field(default_factory=dict)
    known: dict[tuple[str, ...], str] = field(default_factory=dict)
    deadlines: dict[str, float] = field(default_factory=dict)
    hung: dict[tuple[str, str, str], set[float]] = field(default_factory=dict)
    lasting: bool = True

    def sheets(self) -> list[Sheet]:
        """Everything that a report is made of; kept, unless something ended in a way that it may
        not end in next time.
        """
        start = time.perf_counter()
        engines, _ = plan.engines(self.specification)
        _refuse_namesakes(engines)
        if self.use_store:
            key = unchanged.key_of(self.specification, engines)
        else:
            key = None
        if key:
            found = unchanged.kept(self.store, key)
        else:
            found = None
        if found is None:
            found = self._made(engines)
            if key and self.lasting:
                unchanged.keep(self.store, key, [self._whole(start), *found])
        else:
            whole, *found = found
            assert isinstance(whole, CampaignSheet)
            self.read = whole.runs_made + whole.runs_read
        labels = [sheet.label for sheet in found if isinstance(sheet, CaseSheet)]
        return [self._whole(start), *required.held(found, self.specification, engines, labels)]

    def _whole(self, start: float) -> CampaignSheet:
        return CampaignSheet(
            name=self.specification.name,
            refdem=refdem.__version__,
            runs_made=self.made,
            runs_read=self.read,
            seconds=time.perf_counter() - start,
        )

    def _made(self, engines: list[Engine]) -> list[Sheet]:
        """The sheets of engines, cases and records."""
        instances = plan.instances(self.specification)
        self.deadlines = {
            engine.name: time.monotonic() + engine.budget
            for engine in engines
            if engine.budget is not None
        }
        with (
            Schedule(self.jobs, self.specification.timeout) if self.jobs else InProcess()
        ) as schedule:
            asked = [(instance, self._delays(instance, engines)) for instance, _ in instances]
            truths = self._truths(schedule, asked, engines)
            tasks: list[Task] = []
            for (instance, only), truth in zip(instances, truths, strict=True):
                for engine in engines:
                    planned = plan.tasks(
                        self.specification, instance, only, engine, truth, truth.reason
                    )
                    tasks += plan.judged(planned)
            first = []
            later = []
            for n, task in enumerate(tasks):
                first += [(n, variant) for variant in task.variants if not variant.goes_on]
                later += [(n, variant) for variant in task.variants if variant.goes_on]
            self._run(schedule, tasks, first, "runs")
            self._run(schedule, tasks, later, "runs that go on")
        records = self._records(tasks)
        cases = {}
        for (instance, _), truth in zip(instances, truths, strict=True):
            cases[instance.label] = sheets.case_sheet(instance, truth)
        return [*map(sheets.engine_sheet, engines), *cases.values(), *records]

    def _delays(self, instance: Instance, engines: list[Engine]) -> tuple[float, ...]:
        """The times [s] by which velocities of some method lag at one of its levels."""
        delays: set[float] = set()
        for engine in engines:
            if all(method.velocity_time == "synchronous" for method in engine.methods):
                continue
            for subject, _ in plan.subjects(self.specification, instance, engine):
                levels = order_levels(instance, subject.levels)
                delays |= {subject.method.delay(level) for level in levels}
        # Samples that are late by nothing are those of every run.
        delays.discard(0.0)
        return tuple(sorted(delays))

    def _truths(
        self,
        schedule: Schedule | InProcess,
        instances: list[tuple[Instance, tuple[float, ...]]],
        engines: list[Engine],
    ) -> list[SampledTruth]:
        """The sampled truth of every instance that some engine can say."""

        def is_judged(instance: Instance) -> bool:
            refusals = [
                unsupported
                for engine in engines
                for _, unsupported in plan.subjects(self.specification, instance, engine)
            ]
            return None in refusals

        found = sampled_truths(schedule, self.store, instances, self.progress, is_judged)
        self.lasting &= not any(truth.reason.startswith(FAILED) for truth in found)
        return found

    def _run(
        self,
        schedule: Schedule | InProcess,
        tasks: list[Task],
        wanted: list[tuple[int, Variant]],
        stage: str,
    ) -> None:
        """Runs what is wanted: equal runs once, unchanged ones read from the store."""
        requests: dict[tuple[int, Variant], Request] = {}
        keys: dict[str, list[tuple[int, Variant]]] = {}
        for n, variant in wanted:
            request = self._request(tasks[n], n, variant)
            if request is not None:
                requests[n, variant] = request
                key = request.key(tasks[n].engine.name, self._fingerprint(tasks[n]))
                keys.setdefault(key, []).append((n, variant))
        jobs = []
        for key, places in keys.items():
            if self.use_store:
                known = self.store.read("run", key, answer_of)
            else:
                known = None
            if known is not None:
                self.read += 1
                self._hand_on(tasks, requests, key, places, known, from_store=True)
            else:
                jobs.append(self._job(key, tasks[places[0][0]], requests[places[0]]))
        for done, (job, result) in enumerate(schedule.results(jobs), 1):
            self.made += 1
            answer = self._kept(job.key, result)
            place = keys[job.key][0]
            self._note_hang(tasks[place[0]], requests[place], answer[0])
            self._hand_on(tasks, requests, job.key, keys[job.key], answer, from_store=False)
            self.progress(stage, done, len(jobs))

    def _note_hang(self, task: Task, request: Request, reply: worker.Reply) -> None:
        """Remembers the steps with which a method did not end on a case."""
        if reply.failure is not None and reply.failure.kind == "hang":
            self.hung.setdefault(_method_on_case(task), set()).add(abs(request.step or 0.0))

    def _given_up(self, task: Task, request: Request) -> Failure | None:
        """Why a run is not begun any more, or None: smaller steps take longer, and what hangs at
        two steps hangs at all.
        """
        steps = self.hung.get(_method_on_case(task), set())
        takes_longer = any(abs(request.step or 0.0) <= step for step in steps)
        if not takes_longer and len(steps) < ENOUGH:
            return None
        return Failure(
            kind="hang",
            sentence=(
                "it was not started: another run of this method on this case exceeded its"
                " time limit"
            ),
            is_begun=False,
        )

    def _job(self, key: str, task: Task, request: Request) -> Job:
        """A run in a worker; a time limit that an engine keeps itself comes before the worker's."""
        engine = task.engine
        if engine.time_limit is None:
            limit = None
        else:
            limit = max(self.specification.timeout, engine.time_limit + GRACE)
        deadline = self.deadlines.get(engine.name, math.inf)
        asked = (engine.address, request.packed(), deadline)
        if not isinstance(engine, ProgramEngine):
            return Job(
                key, worker.run, asked, limit, given_up=partial(self._given_up, task, request)
            )
        rows = most_rows(request.problem)
        return Job(
            key,
            worker.run,
            asked,
            limit,
            stages=worker.stages,
            rows=rows,
            given_up=partial(self._given_up, task, request),
        )

    def _version(self, engine: Engine) -> str:
        """The engine's version, asked for once."""
        if (engine.name,) not in self.known:
            self.known[engine.name,] = engine.version()
        return self.known[engine.name,]

    def _fingerprint(self, task: Task) -> str:
        """The fingerprint of engine and method, asked for once: all runs of a campaign are of one
        state of the code.
        """
        key = (task.engine.name, task.method.name)
        if key not in self.known:
            self.known[key] = task.engine.fingerprint(task.method)
        return self.known[key]

    def _request(self, task: Task, n: int, variant: Variant) -> Request | None:
        """The request of a variant; None if what it goes on from failed."""
        if not variant.goes_on:
            return plan.request(task, variant, ulps=self.specification.perturbed_ulps)
        base = self.runs[n, variant.base].trajectory
        if base is None:
            return None
        return plan.request(task, variant, base)

    def _kept(self, key: str, result: bytes | Failure) -> Answer:
        """How a run ended; it goes to the store unless it crashed or hung, which is tried again
        next time.
        """
        if isinstance(result, Failure):
            self.lasting = False
            return worker.Reply(failure=result), None
        reply, trajectory = answer_of(result)
        lasting = reply.failure is None or reply.failure.kind == "unsupported"
        self.lasting &= lasting
        if lasting:
            self.store.put("run", key, result)
        return reply, trajectory

    def _hand_on(
        self,
        tasks: list[Task],
        requests: Mapping[tuple[int, Variant], Request],
        key: str,
        places: Iterable[tuple[int, Variant]],
        answer: Answer,
        *,
        from_store: bool,
    ) -> None:
        """Hands a run to all who need it."""
        reply, trajectory = answer
        for n, variant in places:
            self.runs[n, variant] = Run(
                key=key,
                request=requests[n, variant],
                engine=tasks[n].engine.name,
                version=self._version(tasks[n].engine),
                trajectory=trajectory,
                failure=reply.failure,
                cost=reply.cost,
                from_store=from_store,
            )

    def _records(self, tasks: list[Task]) -> list[Sheet]:
        """The records of all tasks, in order of the plan."""
        deviations = {
            task.engine.name: [*of_engine(task.engine), *task.engine.expected] for task in tasks
        }
        found: list[Sheet] = []
        for n, task in enumerate(tasks):
            runs = {
                variant: self.runs[n, variant]
                for variant in task.variants
                if (n, variant) in self.runs
            }
            version = self._version(task.engine)
            found.append(judging.record(task, version, runs, deviations[task.engine.name]))
        return found


def _method_on_case(task: Task) -> tuple[str, str, str]:
    """Engine, method and case with its parameters."""
    return task.engine.name, task.method.name, task.subject.instance.label


def answer_of(data: bytes) -> Answer:
    """The reply of a worker and its trajectory; raises ValueError for bytes that are neither."""
    reply = msgspec.msgpack.decode(data, type=worker.Reply)
    if reply.failure is not None:
        return reply, None
    return reply, Trajectory.from_bytes(reply.trajectory)


def _refuse_namesakes(engines: list[Engine]) -> None:
    """Raises UsageError for two engines of one name: their findings could not be told apart."""
    names = [engine.name for engine in engines]
    for engine in engines:
        if names.count(engine.name) > 1:
            raise UsageError(
                f"two engines are named {engine.name!r}; give each a name of its own in its"
                " refdem.toml"
            )
