"""A stress test from batteries and engines to a record.

It reads no stored run; truth, which no engine touches, may be kept.
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
"""Seconds that a worker has beyond the time limit of a program, to start and to read what came."""
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Place:
    """One rung of one method: what is asked and who answers."""

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
        """What a climb is found by: all rungs of one method on one ladder."""
        return self.battery.id, self.ladder.name, self.engine.name, self.method.name


@dataclass
class Stress:
    """Which ladders, engines and limits: `timeout` [s] a run; no costly rung whose forecast is
    above `longest` [s].

    `require` holds every engine to what the reference promises.
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
        """Climbs all ladders: the record of everything found."""
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
        """Every rung for every method that answers motions."""
        case, given = ladder.canonical()
        instances = [ladder.measure.instance(case, given, x) for x in ladder.values]
        kind = instances[0].problem.kind
        found: list[Place] = []
        for engine in engines:
            for method in engine.methods:
                if method.answers != kind or self.method not in ("", method.name):
                    continue
                for number, instance in enumerate(instances):
                    found.append(Place(battery, ladder, number, engine, method, instance))
        return found

    def _wave(self, place: Place) -> int:
        """Costly ladders are climbed rung by rung, the others at once."""
        if place.ladder.costly:
            return place.number
        return 0

    def _tasks(
        self, schedule: Schedule | InProcess, places: Sequence[Place]
    ) -> list[Task | Failure]:
        """The task of every place, with truth where its measure wants it."""
        instances = {
            place.instance.label: place.instance
            for place in places
            if place.ladder.measure.needs_truth
        }
        delays = _delays(places)
        known = {label: truth_here(instance) for label, instance in instances.items()}
        asked = {
            label: (one, delays.get(label, ()))
            for label, one in instances.items()
            if known[label] is None
        }
        proved = truths.sampled_truths(schedule, self.store, list(asked.values()), self.progress)
        found = known | dict(zip(asked, proved, strict=True))
        none = worker.no_truth("this measure does not use truth")
        return [_task(place, found.get(place.instance.label) or none) for place in places]

    def _run(
        self, schedule: Schedule | InProcess, wanted: Sequence[tuple[Place, Task | Failure]]
    ) -> None:
        """Runs and judges rungs; equal requests run once."""
        asked: dict[str, list[tuple[int, Variant]]] = {}
        jobs: dict[str, Job] = {}
        requests: dict[tuple[int, Variant], Request] = {}
        for n, (place, task) in enumerate(wanted):
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
                head = f"{address}\0{request.repeat}\0".encode()
                key = hashlib.sha256(head + body).hexdigest()
                asked.setdefault(key, []).append((n, variant))
                job = Job(key, quiet_run, (address, body), self._limit(place.engine))
                jobs.setdefault(key, job)
        runs: dict[int, dict[Variant, Run]] = {}
        results = schedule.results(list(jobs.values()))
        for job, result in counted(results, "runs", len(jobs), self.progress):
            for n, variant in asked[job.key]:
                place, _ = wanted[n]
                run = _run_of(job.key, requests[n, variant], place.engine, result)
                runs.setdefault(n, {})[variant] = run
        for n, (place, task) in enumerate(wanted):
            rung = self._rung(place, task, runs.get(n, {}))
            self.rungs.setdefault(place.climb, {})[place.number] = rung

    def _limit(self, engine: Engine) -> float | None:
        """A time limit that a program keeps itself comes before the worker's."""
        if engine.time_limit is None:
            return None
        return max(self.timeout, engine.time_limit + GRACE)

    def _is_too_long(self, place: Place) -> bool:
        forecast = self._forecast(place)
        return forecast is not None and forecast > self.longest

    def _forecast(self, place: Place) -> float | None:
        """Seconds that a rung of a costly ladder will take, by the one before it; infinite once one
        was left out.
        """
        if not place.ladder.costly:
            return None
        below = self.rungs.get(place.climb, {}).get(place.number - 1)
        if below is None:
            return None
        # At least as many times as long as the rung is harder.
        growth = float(place.x / place.ladder.values[place.number - 1])
        growth = max(growth, 1 / growth)
        if below.forecast is not None:
            return below.forecast * growth
        return below.seconds * growth

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
            # A check met what no run has shown it: one rung, and no verdict.
            told = (
                f"a check of refdem failed to judge it ({type(error).__name__}: {error});"
                " please report this"
            )
            return Rung(rung=name, verdict="error", quantity="run: judging", sentence=told)

    def _recorded(self, places: Sequence[Place], versions: dict[str, str]) -> StressRecord:
        """All climbs but those of methods that can climb nothing; where no method of an engine can,
        the reason.
        """
        first = {place.climb: place for place in reversed(places)}
        climbs: list[Climb] = []
        refused: dict[tuple[str, str, str], str] = {}
        for place in reversed(first.values()):
            rungs = [rung for _, rung in sorted(self.rungs[place.climb].items())]
            if rungs[0].verdict == "unsupported":
                climber = (place.battery.id, place.ladder.name, place.engine.name)
                refused.setdefault(climber, rungs[0].sentence)
                continue
            bare = Climb(
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
            climbs.append(climbed(bare, place.ladder, rungs, is_required=is_required))
        # An engine that climbs a ladder with one method supports it.
        for climb in climbs:
            refused.pop((climb.battery, climb.ladder, climb.engine), None)
        used = {place.battery.id: place.battery for place in places}
        return StressRecord(
            refdem=refdem.__version__,
            longest=self.longest,
            batteries=[Ask(id=b.id, title=b.title, question=b.question) for b in used.values()],
            climbs=climbs,
            refused=[(engine, ladder, why) for (_, ladder, engine), why in refused.items()],
        )


def quiet_run(engine: str, request: bytes) -> bytes:
    """A run in a worker; beyond what a code can do, numbers overflow and vanish, and that is no
    news.
    """
    with np.errstate(all="ignore"):
        return worker.run(engine, request)


def _task(place: Place, truth: SampledTruth) -> Task | Failure:
    """The task of a place; the Failure of an engine that raises where it should refuse or accept a
    scene.
    """
    try:
        with np.errstate(all="ignore"):
            return place.ladder.measure.task(
                place.engine, place.method, place.instance, place.x, truth
            )
    except (RefdemError, ArithmeticError, ValueError) as error:
        told = f"{type(error).__name__}: {error}"
        return Failure(
            kind="refusal",
            sentence=f"{place.engine.name} could not say whether it supports the scene ({told})",
        )


def _delays(places: Sequence[Place]) -> dict[str, tuple[float, ...]]:
    """The times [s] by which velocities lag, by the label of the instance, where those of some
    method do.
    """
    found: dict[str, set[float]] = {}
    for place in places:
        if place.method.velocity_time != "synchronous":
            levels = place.ladder.measure.levels(place.instance, place.method, place.x)
            delays = {place.method.delay(level) for level in levels}
            found.setdefault(place.instance.label, set()).update(delays)
    return {label: tuple(sorted(delays)) for label, delays in found.items()}


def _run_of(key: str, request: Request, engine: Engine, result: bytes | Failure) -> Run:
    """The run that a job's result tells of: its trajectory, or why there is none."""
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
