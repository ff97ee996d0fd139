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
class Place:
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
        places: list[Place] = []
        for battery in self.batteries:
            for ladder in battery.ladders:
                places += self._places(battery, ladder, engines)
        workers: Schedule | InProcess = InProcess()
        if self.jobs:
            workers = Schedule(self.jobs, self.timeout)
        with workers as schedule:
            tasks = self._tasks(schedule, places)
            waves: dict[int, list[tuple[Place, Task | Failure]]] = {}
            for place, task in zip(places, tasks, strict=True):
                waves.setdefault(self._wave(place), []).append((place, task))
            for _, wave in sorted(waves.items()):
                self._run(schedule, wave)
        versions = {engine.name: engine.version() for engine in engines}
        return self._recorded(places, versions)

    def _places(self, battery: Battery, ladder: Ladder, engines: Sequence[Engine]) -> list[Place]:
        """Every rung of the ladder for every method that answers its kind of problem."""
        case, parameters = ladder.canonical()
        instances = [ladder.measure.instance(case, parameters, x) for x in ladder.values]
        kind = instances[0].problem.kind
        places: list[Place] = []
        for engine in engines:
            for method in engine.methods:
                if method.answers != kind or self.method not in ("", method.name):
                    continue
                for number, instance in enumerate(instances):
                    places.append(Place(battery, ladder, number, engine, method, instance))
        return places

    def _wave(self, place: Place) -> int:
        """The number of the wave: the rung's for costly ladders, else 0."""
        if place.ladder.costly:
            return place.number
        return 0

    def _tasks(
        self, schedule: Schedule | InProcess, places: Sequence[Place]
    ) -> list[Task | Failure]:
        """The task of every place, with certified truth where its measure needs it."""
        instances = {
            place.instance.label: place.instance
            for place in places
            if place.ladder.measure.needs_truth
        }
        delays = _delays(places)
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
        for place in places:
            truth = truth_of.get(place.instance.label) or without_truth
            tasks.append(_task(place, truth))
        return tasks

    def _run(
        self, schedule: Schedule | InProcess, wave: Sequence[tuple[Place, Task | Failure]]
    ) -> None:
        """Runs and judges the rungs of one wave; equal requests run once."""
        variants_by_key: dict[str, list[tuple[int, Variant]]] = {}
        jobs: dict[str, Job] = {}
        requests: dict[tuple[int, Variant], Request] = {}
        for n, (place, task) in enumerate(wave):
            if (
                isinstance(task, Failure)
                or task.unsupported is not None
                or self._is_too_long(place)
            ):
                continue
            for variant in task.variants:
                request = place.ladder.measure.request(task, variant, place.x)
                requests[n, variant] = request
                address = place.engine.address
                body = request.packed()
                # Equal keys mean equal engines and requests.
                head = f"{address}\0{request.repeat}\0".encode()
                key = hashlib.sha256(head + body).hexdigest()
                variants_by_key.setdefault(key, []).append((n, variant))
                job = Job(key, quiet_run, (address, body), self._limit(place.engine))
                jobs.setdefault(key, job)
        runs: dict[int, dict[Variant, Run]] = {}
        results = schedule.results(list(jobs.values()))
        for job, result in counted(results, "runs", len(jobs), self.progress):
            for n, variant in variants_by_key[job.key]:
                place, _ = wave[n]
                run = _run_of(job.key, requests[n, variant], place.engine, result)
                runs.setdefault(n, {})[variant] = run
        for n, (place, task) in enumerate(wave):
            rung = self._rung(place, task, runs.get(n, {}))
            self.rungs.setdefault(place.climb, {})[place.number] = rung

    def _limit(self, engine: Engine) -> float | None:
        """The worker's time limit [s] for an engine, above the one that a program keeps itself;
        None without such a limit.
        """
        if engine.time_limit is None:
            return None
        return max(self.timeout, engine.time_limit + GRACE)

    def _is_too_long(self, place: Place) -> bool:
        """True if the forecast exceeds the budget."""
        forecast = self._forecast(place)
        return forecast is not None and forecast > self.longest

    def _forecast(self, place: Place) -> float | None:
        """Expected seconds of a rung of a costly ladder, from the rung before; None for other
        ladders and for the first rung.

        The time is assumed to grow at least in proportion to the rung's number.
        """
        if not place.ladder.costly:
            return None
        previous = self.rungs.get(place.climb, {}).get(place.number - 1)
        if previous is None:
            return None
        # Rungs may fall as well as rise: the ratio is taken so that it is at least 1.
        growth = float(place.x / place.ladder.values[place.number - 1])
        growth = max(growth, 1 / growth)
        if previous.forecast is not None:
            return previous.forecast * growth
        return previous.seconds * growth

    def _rung(self, place: Place, task: Task | Failure, runs: dict[Variant, Run]) -> Rung:
        """The verdict on one rung, from the runs that it needed."""
        name = place.ladder.rungs[place.number]
        if isinstance(task, Failure):
            return Rung(rung=name, verdict="error", quantity="run: scene", sentence=task.sentence)
        if task.unsupported is None and self._is_too_long(place):
            forecast = self._forecast(place)
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

    def _recorded(self, places: Sequence[Place], versions: dict[str, str]) -> StressRecord:
        """The record of all climbs but those that were refused from the first rung; reasons where
        an engine has no other.
        """
        first_places = {place.climb: place for place in reversed(places)}
        climbs: list[Climb] = []
        refused: dict[tuple[str, str, str], str] = {}
        for place in reversed(first_places.values()):
            rungs = [rung for _, rung in sorted(self.rungs[place.climb].items())]
            if rungs[0].verdict == "unsupported":
                climber = (place.battery.id, place.ladder.name, place.engine.name)
                refused.setdefault(climber, rungs[0].sentence)
                continue
            empty = Climb(
                battery=place.battery.id,
                ladder=place.ladder.name,
                label=place.instance.case.id,
                along=place.ladder.along,
                engine=place.engine.name,
                version=versions[place.engine.name],
                method=place.method.name,
                is_reference=place.engine.is_reference,
                rungs=[],
            )
            is_required = self.require or place.engine.is_reference
            climbs.append(climbed(empty, place.ladder, rungs, is_required=is_required))
        # An engine that climbs a ladder with one method supports it.
        for climb in climbs:
            refused.pop((climb.battery, climb.ladder, climb.engine), None)
        batteries = {place.battery.id: place.battery for place in places}
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


def _task(place: Place, truth: SampledTruth) -> Task | Failure:
    """The task of a place; a Failure if the engine raises instead of refusing or accepting the
    scene.
    """
    try:
        with np.errstate(all="ignore"):
            return place.ladder.measure.task(
                place.engine, place.method, place.instance, place.x, truth
            )
    except (RefdemError, ArithmeticError, ValueError) as error:
        reason = f"{type(error).__name__}: {error}"
        return Failure(
            kind="refusal",
            sentence=f"{place.engine.name} could not say whether it supports the scene ({reason})",
        )


def _delays(places: Sequence[Place]) -> dict[str, tuple[float, ...]]:
    """Times [s] by which velocities lag behind positions, by label of the instance, for methods
    that have such a lag.
    """
    delays_of: dict[str, set[float]] = {}
    for place in places:
        if place.method.velocity_time != "synchronous":
            levels = place.ladder.measure.levels(place.instance, place.method, place.x)
            lags = {place.method.delay(level) for level in levels}
            delays_of.setdefault(place.instance.label, set()).update(lags)
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
