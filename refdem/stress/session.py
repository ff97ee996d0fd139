"""A stress test, from batteries and engines to a record.

No stored run is read, so that every result is computed by the code under test. Truth, which does
not depend on engines, may come from the store.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import msgspec
import numpy as np

import refdem
from refdem.core.case import Instance
from refdem.core.engine import Engine, Method
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import RefdemError
from refdem.execution import worker
from refdem.execution.schedule import InProcess, Job, Schedule, counted
from refdem.planning import judging, plan, truths
from refdem.planning.plan import Task
from refdem.planning.specification import Specification
from refdem.stress.record import Ask, MethodSweep, Point, StressRecord
from refdem.stress.scenes import truth_here
from refdem.stress.sweep import Battery, Sweep
from refdem.stress.verdict import point_of, summarised

GRACE = 10.0
"""Seconds that a worker gets beyond a program's own time limit, to start it and to read its
output.
"""
Progress = Callable[[str, int, int], None]
"""Called with a stage, the number of its finished jobs and their total."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """One point of one method on one sweep: the instance to be run, and the engine that runs it.

    `number` counts points from 0.
    """

    battery: Battery
    sweep: Sweep
    number: int
    engine: Engine
    method: Method
    instance: Instance

    @property
    def x(self) -> Fraction:
        """The point as an exact number."""
        return self.sweep.values[self.number]

    @property
    def result(self) -> tuple[str, str, str, str]:
        """Key of the method sweep that the point belongs to: battery, sweep, engine, method."""
        return self.battery.id, self.sweep.name, self.engine.name, self.method.name


Wave = list[tuple[Attempt, Task | Failure]]
"""Points that run together, each with its task, or the failure to make one."""


@dataclass(frozen=True, eq=False)
class Need:
    """A run that a point needs: the point's place in its wave, the variant and the request."""

    place: int
    variant: Variant
    request: Request


@dataclass
class Stress:
    """A stress test of sweeps by engines.

    `timeout` [s] limits each run; points of costly sweeps with a forecast above `longest` [s] are
    not run. With `require` every engine is held to what the reference promises. `points` collects
    the results by method sweep and point.
    """

    batteries: Sequence[Battery]
    store: Store
    engines: list[str] = field(default_factory=list)
    method: str = ""
    jobs: int = 2
    timeout: float = 20.0
    longest: float = 5.0
    require: bool = False
    progress: Progress = lambda stage, done, total: None
    points: dict[tuple[str, str, str, str], dict[int, Point]] = field(default_factory=dict)

    def record(self) -> StressRecord:
        """Runs all sweeps and returns the record.

        Points run in waves: wave n has point n of all costly sweeps, whose forecasts need the point
        before; all other points are in wave 0.
        """
        specification = Specification(
            name="stress", case=[], engines=self.engines, method=self.method
        )
        engines, _ = plan.engines(specification)
        # Before any run, which may change the files of its program.
        versions = {engine.name: engine.version() for engine in engines}
        attempts: list[Attempt] = []
        for battery in self.batteries:
            for sweep in battery.sweeps:
                attempts += self._attempts(battery, sweep, engines)
        workers: Schedule | InProcess = InProcess()
        if self.jobs:
            workers = Schedule(self.jobs, self.timeout)
        with workers as schedule:
            tasks = self._tasks(schedule, attempts)
            waves: dict[int, Wave] = {}
            for attempt, task in zip(attempts, tasks, strict=True):
                waves.setdefault(self._wave(attempt), []).append((attempt, task))
            for _, wave in sorted(waves.items()):
                self._run(schedule, wave)
        return self._recorded(attempts, versions)

    def _attempts(self, battery: Battery, sweep: Sweep, engines: Sequence[Engine]) -> list[Attempt]:
        """An attempt at every point of the sweep for every method that answers its kind of
        problem.
        """
        case, parameters = sweep.canonical()
        instances = [sweep.measure.instance(case, parameters, x) for x in sweep.values]
        kind = instances[0].problem.kind
        attempts: list[Attempt] = []
        for engine in engines:
            for method in engine.chosen_methods(self.method):
                if method.answers != kind:
                    continue
                for number, instance in enumerate(instances):
                    attempts.append(Attempt(battery, sweep, number, engine, method, instance))
        return attempts

    def _wave(self, attempt: Attempt) -> int:
        """The number of the wave: the point's for costly sweeps, else 0."""
        if attempt.sweep.costly:
            return attempt.number
        return 0

    def _tasks(
        self, schedule: Schedule | InProcess, attempts: Sequence[Attempt]
    ) -> list[Task | Failure]:
        """The task of every attempt, with certified truth where its measure needs it."""
        truth_of = self._truths(schedule, attempts)
        without_truth = worker.no_truth("this measure does not use truth")
        tasks = []
        for attempt in attempts:
            truth = truth_of.get(attempt.instance.label) or without_truth
            tasks.append(_task(attempt, truth))
        return tasks

    def _truths(
        self, schedule: Schedule | InProcess, attempts: Sequence[Attempt]
    ) -> dict[str, SampledTruth | None]:
        """Certified truth by label of the instances whose measure needs it: made here where that is
        cheap, else by the workers.
        """
        instances = {
            attempt.instance.label: attempt.instance
            for attempt in attempts
            if attempt.sweep.measure.needs_truth
        }
        delays = _delays(attempts)
        truth_of = {label: truth_here(instance) for label, instance in instances.items()}
        missing = {
            label: (instance, delays.get(label, ()))
            for label, instance in instances.items()
            if truth_of[label] is None
        }
        proven = truths.sampled_truths(schedule, self.store, list(missing.values()), self.progress)
        return truth_of | dict(zip(missing, proven, strict=True))

    def _run(self, schedule: Schedule | InProcess, wave: Wave) -> None:
        """Runs and judges the points of one wave; equal requests run once."""
        jobs: dict[str, Job] = {}
        needs: dict[str, list[Need]] = {}
        for place, (attempt, task) in enumerate(wave):
            if isinstance(task, Failure) or task.unsupported is not None:
                continue
            if self._is_too_long(attempt):
                continue
            for variant in task.variants:
                request = attempt.sweep.measure.request(task, variant, attempt.x)
                job = self._job(attempt.engine, request)
                jobs.setdefault(job.key, job)
                needs.setdefault(job.key, []).append(Need(place, variant, request))
        runs: list[dict[Variant, Run]] = [{} for _ in wave]
        results = schedule.results(list(jobs.values()))
        for job, result in counted(results, "runs", len(jobs), self.progress):
            for need in needs[job.key]:
                attempt, _ = wave[need.place]
                run = _run_of(job.key, need.request, attempt.engine, result)
                runs[need.place][need.variant] = run
        for (attempt, task), runs_by_variant in zip(wave, runs, strict=True):
            point = self._point(attempt, task, runs_by_variant)
            self.points.setdefault(attempt.result, {})[attempt.number] = point

    def _job(self, engine: Engine, request: Request) -> Job:
        """The job of a request to an engine; equal keys mean equal engines and requests."""
        body = request.packed()
        head = f"{engine.address}\0{request.repeat}\0".encode()
        key = hashlib.sha256(head + body).hexdigest()
        limit = self._limit(engine)
        return Job(key, quiet_run, (engine.address, body), limit, computes=limit is None)

    def _limit(self, engine: Engine) -> float | None:
        """The worker's time limit [s] for an engine, above the one that a program keeps itself;
        None without such a limit.
        """
        if engine.time_limit is None:
            return None
        return max(self.timeout, engine.time_limit + GRACE)

    def _is_too_long(self, attempt: Attempt) -> bool:
        """True if the forecast exceeds the budget."""
        forecast = self._forecast(attempt)
        return forecast is not None and forecast > self.longest

    def _forecast(self, attempt: Attempt) -> float | None:
        """Expected seconds of a point of a costly sweep, from the point before; None for other
        sweeps and for the first point.

        The time is assumed to grow at least in proportion to the point's number.
        """
        if not attempt.sweep.costly:
            return None
        previous = self.points.get(attempt.result, {}).get(attempt.number - 1)
        if previous is None:
            return None
        # Points may fall as well as rise: the ratio is taken so that it is at least 1.
        growth = float(attempt.x / attempt.sweep.values[attempt.number - 1])
        growth = max(growth, 1 / growth)
        if previous.forecast is not None:
            return previous.forecast * growth
        return previous.seconds * growth

    def _point(self, attempt: Attempt, task: Task | Failure, runs: dict[Variant, Run]) -> Point:
        """The verdict on one point, from the runs that it needed."""
        name = attempt.sweep.points[attempt.number]
        if isinstance(task, Failure):
            return Point(point=name, verdict="error", quantity="run: scene", sentence=task.sentence)
        if task.unsupported is None and self._is_too_long(attempt):
            forecast = self._forecast(attempt)
            return Point(
                point=name,
                verdict="not run",
                forecast=forecast,
                sentence="The forecast run time exceeds the budget (--longest).",
            )
        try:
            return point_of(name, judging.record(task, "", runs, []))
        except (ArithmeticError, IndexError, ValueError) as error:
            # A check failed on extreme values: that is an error of one point, not of the session.
            sentence = (
                f"a check of refdem failed to judge it ({type(error).__name__}: {error});"
                " please report this"
            )
            return Point(point=name, verdict="error", quantity="run: judging", sentence=sentence)

    def _recorded(self, attempts: Sequence[Attempt], versions: dict[str, str]) -> StressRecord:
        """The record of all method sweeps but those that were refused from the first point;
        reasons where an engine has no other.
        """
        first_attempts: dict[tuple[str, str, str, str], Attempt] = {}
        for attempt in attempts:
            first_attempts.setdefault(attempt.result, attempt)
        results: list[MethodSweep] = []
        refusals: dict[tuple[str, str, str], str] = {}
        for attempt in first_attempts.values():
            points = [point for _, point in sorted(self.points[attempt.result].items())]
            if points[0].verdict == "unsupported":
                engine_sweep = (attempt.battery.id, attempt.sweep.name, attempt.engine.name)
                refusals.setdefault(engine_sweep, points[0].sentence)
            else:
                results.append(self._summary(attempt, versions[attempt.engine.name], points))
        # An engine that runs a sweep with one method supports it.
        for result in results:
            refusals.pop((result.battery, result.sweep, result.engine), None)
        batteries = {attempt.battery.id: attempt.battery for attempt in attempts}
        asks = [Ask(id=b.id, title=b.title, question=b.question) for b in batteries.values()]
        return StressRecord(
            refdem=refdem.__version__,
            longest=self.longest,
            batteries=asks,
            results=results,
            refused=[(engine, sweep, why) for (_, sweep, engine), why in refusals.items()],
        )

    def _summary(self, first: Attempt, version: str, points: list[Point]) -> MethodSweep:
        """The method sweep of the method of a first attempt, with the verdicts on its points."""
        empty = MethodSweep(
            battery=first.battery.id,
            sweep=first.sweep.name,
            label=first.instance.case.id,
            along=first.sweep.along,
            engine=first.engine.name,
            version=version,
            method=first.method.name,
            is_reference=first.engine.is_reference,
            points=[],
        )
        is_required = self.require or first.engine.is_reference
        return summarised(empty, first.sweep, points, is_required=is_required)


def quiet_run(engine: str, request: bytes) -> bytes:
    """A run in a worker, without warnings: extreme points overflow and underflow by design."""
    with np.errstate(all="ignore"):
        return worker.run(engine, request)


def _task(attempt: Attempt, truth: SampledTruth) -> Task | Failure:
    """The task of an attempt; a Failure if the engine raises instead of refusing or accepting the
    scene.
    """
    try:
        with np.errstate(all="ignore"):
            return attempt.sweep.measure.task(
                attempt.engine, attempt.method, attempt.instance, attempt.x, truth
            )
    except (RefdemError, ArithmeticError, ValueError) as error:
        reason = f"{type(error).__name__}: {error}"
        return Failure(
            kind="refusal",
            sentence=(
                f"{attempt.engine.name} could not say whether it supports the scene ({reason})"
            ),
        )


def _delays(attempts: Sequence[Attempt]) -> dict[str, tuple[float, ...]]:
    """Times [s] by which velocities lag behind positions, by label of the instance, for methods
    that have such a lag.
    """
    delays_of: dict[str, set[float]] = {}
    for attempt in attempts:
        if attempt.method.velocity_time != "synchronous":
            levels = attempt.sweep.measure.levels(attempt.instance, attempt.method, attempt.x)
            lags = {attempt.method.delay(level) for level in levels}
            delays_of.setdefault(attempt.instance.label, set()).update(lags)
    return {label: tuple(sorted(lags)) for label, lags in delays_of.items()}


def _run_of(key: str, request: Request, engine: Engine, result: bytes | Failure) -> Run:
    """The run from a job's result: its trajectory, or the failure."""
    if isinstance(result, Failure):
        reply = worker.Reply(failure=result)
    else:
        reply = msgspec.msgpack.decode(result, type=worker.Reply)
    trajectory = None
    if reply.failure is None:
        trajectory = Trajectory.from_bytes(reply.trajectory)
    return Run(
        key=key,
        request=request,
        engine=engine.name,
        version="",
        trajectory=trajectory,
        failure=reply.failure,
        cost=reply.cost,
    )
