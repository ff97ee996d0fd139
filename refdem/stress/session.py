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
from refdem.campaign import judging, plan, truths, worker
from refdem.campaign.plan import Task
from refdem.campaign.schedule import InProcess, Job, Schedule, counted
from refdem.campaign.specification import Specification
from refdem.core.case import Instance
from refdem.core.engine import Engine, Method
from refdem.core.problem import Request
from refdem.core.run import Failure, Run
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import RefdemError
from refdem.stress.ladder import Battery, Ladder
from refdem.stress.record import Ask, Climb, Rung, StressRecord
from refdem.stress.scenes import truth_here
from refdem.stress.verdict import climbed, rung_of

GRACE = 10.0
"""Seconds that a worker gets beyond a program's own time limit, to start it and to read its
output.
"""
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Attempt:
    """One rung of one method on one ladder: the instance to be run, and who runs it. `number`
    counts rungs from 0.
    """

    battery: Battery
    ladder: Ladder
    number: int
    engine: Engine
    method: Method
    instance: Instance

    @property
    def x(self) -> Fraction:
        """The rung as an exact number."""
        return self.ladder.values[self.number]

    @property
    def climb(self) -> tuple[str, str, str, str]:
        """Key of the climb that the rung belongs to: battery, ladder, engine, method."""
        return self.battery.id, self.ladder.name, self.engine.name, self.method.name


@dataclass
class Stress:
    """A stress test of ladders by engines.

    `timeout` [s] limits each run; rungs of costly ladders with a forecast above `longest` [s] are
    not run. With `require` every engine is held to what the reference promises. `rungs` collects
    the results by climb and rung.
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
    rungs: dict[tuple[str, str, str, str], dict[int, Rung]] = field(default_factory=dict)

    def record(self) -> StressRecord:
        """Climbs all ladders and returns the record.

        Rungs run in waves: wave n has rung n of all costly ladders, whose forecasts need the rung
        before; all other rungs are in wave 0.
        """
        specification = Specification(
            name="stress", case=[], engines=self.engines, method=self.method
        )
        engines, _ = plan.engines(specification)
        attempts: list[Attempt] = []
        for battery in self.batteries:
            for ladder in battery.ladders:
                attempts += self._attempts(battery, ladder, engines)
        workers: Schedule | InProcess = InProcess()
        if self.jobs:
            workers = Schedule(self.jobs, self.timeout)
        with workers as schedule:
            tasks = self._tasks(schedule, attempts)
            waves: dict[int, list[tuple[Attempt, Task | Failure]]] = {}
            for attempt, task in zip(attempts, tasks, strict=True):
                waves.setdefault(self._wave(attempt), []).append((attempt, task))
            for _, wave in sorted(waves.items()):
                self._run(schedule, wave)
        versions = {engine.name: engine.version() for engine in engines}
        return self._recorded(attempts, versions)

    def _attempts(
        self, battery: Battery, ladder: Ladder, engines: Sequence[Engine]
    ) -> list[Attempt]:
        """An attempt at every rung of the ladder for every method that answers its kind of
        problem.
        """
        case, parameters = ladder.canonical()
        instances = [ladder.measure.instance(case, parameters, x) for x in ladder.values]
        kind = instances[0].problem.kind
        attempts: list[Attempt] = []
        for engine in engines:
            for method in engine.chosen_methods(self.method):
                if method.answers != kind:
                    continue
                for number, instance in enumerate(instances):
                    attempts.append(Attempt(battery, ladder, number, engine, method, instance))
        return attempts

    def _wave(self, attempt: Attempt) -> int:
        """The number of the wave: the rung's for costly ladders, else 0."""
        if attempt.ladder.costly:
            return attempt.number
        return 0

    def _tasks(
        self, schedule: Schedule | InProcess, attempts: Sequence[Attempt]
    ) -> list[Task | Failure]:
        """The task of every attempt, with certified truth where its measure needs it."""
        instances = {
            attempt.instance.label: attempt.instance
            for attempt in attempts
            if attempt.ladder.measure.needs_truth
        }
        delays = _delays(attempts)
        local_truths = {label: truth_here(instance) for label, instance in instances.items()}
        missing = {
            label: (instance, delays.get(label, ()))
            for label, instance in instances.items()
            if local_truths[label] is None
        }
        proven = truths.sampled_truths(schedule, self.store, list(missing.values()), self.progress)
        truth_of = local_truths | dict(zip(missing, proven, strict=True))
        without_truth = worker.no_truth("this measure does not use truth")
        tasks = []
        for attempt in attempts:
            truth = truth_of.get(attempt.instance.label) or without_truth
            tasks.append(_task(attempt, truth))
        return tasks

    def _run(
        self, schedule: Schedule | InProcess, wave: Sequence[tuple[Attempt, Task | Failure]]
    ) -> None:
        """Runs and judges the rungs of one wave; equal requests run once."""
        variants_by_key: dict[str, list[tuple[int, Variant]]] = {}
        jobs: dict[str, Job] = {}
        requests: dict[tuple[int, Variant], Request] = {}
        for n, (attempt, task) in enumerate(wave):
            if (
                isinstance(task, Failure)
                or task.unsupported is not None
                or self._is_too_long(attempt)
            ):
                continue
            for variant in task.variants:
                request = attempt.ladder.measure.request(task, variant, attempt.x)
                requests[n, variant] = request
                address = attempt.engine.address
                body = request.packed()
                # Equal keys mean equal engines and requests.
                head = f"{address}\0{request.repeat}\0".encode()
                key = hashlib.sha256(head + body).hexdigest()
                variants_by_key.setdefault(key, []).append((n, variant))
                limit = self._limit(attempt.engine)
                job = Job(key, quiet_run, (address, body), limit, computes=limit is None)
                jobs.setdefault(key, job)
        runs: dict[int, dict[Variant, Run]] = {}
        results = schedule.results(list(jobs.values()))
        for job, result in counted(results, "runs", len(jobs), self.progress):
            for n, variant in variants_by_key[job.key]:
                attempt, _ = wave[n]
                run = _run_of(job.key, requests[n, variant], attempt.engine, result)
                runs.setdefault(n, {})[variant] = run
        for n, (attempt, task) in enumerate(wave):
            rung = self._rung(attempt, task, runs.get(n, {}))
            self.rungs.setdefault(attempt.climb, {})[attempt.number] = rung

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
        """Expected seconds of a rung of a costly ladder, from the rung before; None for other
        ladders and for the first rung.

        The time is assumed to grow at least in proportion to the rung's number.
        """
        if not attempt.ladder.costly:
            return None
        previous = self.rungs.get(attempt.climb, {}).get(attempt.number - 1)
        if previous is None:
            return None
        # Rungs may fall as well as rise: the ratio is taken so that it is at least 1.
        growth = float(attempt.x / attempt.ladder.values[attempt.number - 1])
        growth = max(growth, 1 / growth)
        if previous.forecast is not None:
            return previous.forecast * growth
        return previous.seconds * growth

    def _rung(self, attempt: Attempt, task: Task | Failure, runs: dict[Variant, Run]) -> Rung:
        """The verdict on one rung, from the runs that it needed."""
        name = attempt.ladder.rungs[attempt.number]
        if isinstance(task, Failure):
            return Rung(rung=name, verdict="error", quantity="run: scene", sentence=task.sentence)
        if task.unsupported is None and self._is_too_long(attempt):
            forecast = self._forecast(attempt)
            return Rung(
                rung=name,
                verdict="not run",
                forecast=forecast,
                sentence="The forecast run time exceeds the budget (--longest).",
            )
        try:
            return rung_of(name, judging.record(task, "", runs, []))
        except (ArithmeticError, IndexError, ValueError) as error:
            # A check failed on extreme values: that is an error of one rung, not of the session.
            sentence = (
                f"a check of refdem failed to judge it ({type(error).__name__}: {error});"
                " please report this"
            )
            return Rung(rung=name, verdict="error", quantity="run: judging", sentence=sentence)

    def _recorded(self, attempts: Sequence[Attempt], versions: dict[str, str]) -> StressRecord:
        """The record of all climbs but those that were refused from the first rung; reasons where
        an engine has no other.
        """
        first_attempts = {attempt.climb: attempt for attempt in reversed(attempts)}
        climbs: list[Climb] = []
        refused: dict[tuple[str, str, str], str] = {}
        for attempt in reversed(first_attempts.values()):
            rungs = [rung for _, rung in sorted(self.rungs[attempt.climb].items())]
            if rungs[0].verdict == "unsupported":
                climber = (attempt.battery.id, attempt.ladder.name, attempt.engine.name)
                refused.setdefault(climber, rungs[0].sentence)
                continue
            empty = Climb(
                battery=attempt.battery.id,
                ladder=attempt.ladder.name,
                label=attempt.instance.case.id,
                along=attempt.ladder.along,
                engine=attempt.engine.name,
                version=versions[attempt.engine.name],
                method=attempt.method.name,
                is_reference=attempt.engine.is_reference,
                rungs=[],
            )
            is_required = self.require or attempt.engine.is_reference
            climbs.append(climbed(empty, attempt.ladder, rungs, is_required=is_required))
        # An engine that climbs a ladder with one method supports it.
        for climb in climbs:
            refused.pop((climb.battery, climb.ladder, climb.engine), None)
        batteries = {attempt.battery.id: attempt.battery for attempt in attempts}
        return StressRecord(
            refdem=refdem.__version__,
            longest=self.longest,
            batteries=[
                Ask(id=b.id, title=b.title, question=b.question) for b in batteries.values()
            ],
            climbs=climbs,
            refused=[(engine, ladder, why) for (_, ladder, engine), why in refused.items()],
        )


def quiet_run(engine: str, request: bytes) -> bytes:
    """A run in a worker, without warnings: extreme rungs overflow and underflow by design."""
    with np.errstate(all="ignore"):
        return worker.run(engine, request)


def _task(attempt: Attempt, truth: SampledTruth) -> Task | Failure:
    """The task of an attempt; a Failure if the engine raises instead of refusing or accepting the
    scene.
    """
    try:
        with np.errstate(all="ignore"):
            return attempt.ladder.measure.task(
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
            levels = attempt.ladder.measure.levels(attempt.instance, attempt.method, attempt.x)
            lags = {attempt.method.delay(level) for level in levels}
            delays_of.setdefault(attempt.instance.label, set()).update(lags)
    return {label: tuple(sorted(lags)) for label, lags in delays_of.items()}


def _run_of(key: str, request: Request, engine: Engine, result: bytes | Failure) -> Run:
    """The run from a job's result: its trajectory, or the failure."""
    if isinstance(result, Failure):
        reply = worker.Reply(failure=result)
    else:
        reply = msgspec.msgpack.decode(result, type=worker.Reply)
    if reply.failure is None:
        trajectory = Trajectory.from_bytes(reply.trajectory)
    else:
        trajectory = None
    return Run(
        key=key,
        request=request,
        engine=engine.name,
        version="",
        trajectory=trajectory,
        failure=reply.failure,
        cost=reply.cost,
    )
