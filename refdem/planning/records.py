"""The last two stages of a campaign: the runs of all tasks, and the records that are judged from
them.

A task is judged as soon as its runs have ended, while those of other tasks are being made.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from refdem.core.finding import Record
from refdem.core.run import Run
from refdem.core.variant import Variant
from refdem.planning import judging, runs
from refdem.planning.deviations import of_engine
from refdem.planning.plan import Task
from refdem.planning.runs import Place, Recent, RequestedRun, Runner, Runs


def records(
    runner: Runner, tasks: list[Task], versions: Mapping[str, str], ulps: int
) -> tuple[list[Record], Runs]:
    """The records in order of the plan, with the deviations that are expected of the engines, and
    the runs from which they were judged.

    The runs that the checks need at first are made, and then those that they need in view of the
    results, until no check needs more. The start of every run is moved by `ulps` units in the last
    place, except for runs that continue from the end of another run.
    """
    judge = _Judge(tasks, versions, Runs(spool=runner.spool))
    fingerprints = runs.fingerprints_of(tasks)
    wanted = {number: task.variants for number, task in enumerate(tasks) if task.variants}
    for number in range(len(tasks)):
        if number not in wanted:
            judge.judge(number)
    stage = "runs"
    while wanted:
        from_start = runs.requested_runs(tasks, wanted, fingerprints, ulps)
        # Runs that continue from the end of another run are requested when that one has ended.
        waiting = {
            number for number, requested in wanted.items() if any(v.goes_on for v in requested)
        }
        more = {}
        for number in judge.completed(runner.runs(from_start, stage), from_start):
            if number not in waiting:
                more[number] = judge.judge(number)
        going_on = runs.requested_runs(tasks, wanted, fingerprints, 0, judge.runs)
        for number in judge.completed(runner.runs(going_on, f"{stage} that go on"), going_on):
            more[number] = judge.judge(number)
        # Nothing continues from the end of a run that failed.
        for number in waiting - more.keys():
            more[number] = judge.judge(number)
        wanted = {number: more[number] for number in sorted(more) if more[number]}
        stage = "finer runs"
    return [judge.records[number] for number in range(len(tasks))], judge.runs


@dataclass
class _Judge:
    """Judges tasks one by one: their runs so far, and the records of those that have all runs."""

    tasks: list[Task]
    versions: Mapping[str, str]
    runs: Runs
    records: dict[int, Record] = field(default_factory=dict)

    def __post_init__(self) -> None:
        engines = {task.engine.name: task.engine for task in self.tasks}
        self._expected = {name: of_engine(engine) for name, engine in engines.items()}

    def completed(
        self, ended: Iterable[tuple[RequestedRun, Run]], requested: Iterable[RequestedRun]
    ) -> Iterator[int]:
        """The numbers of the tasks all of whose requested runs have ended.

        These tasks now have their runs, in the order in which they were requested.
        """
        places: dict[int, list[Place]] = {}
        for one in requested:
            places.setdefault(one.place[0], []).append(one.place)
        found: dict[int, dict[Place, Run]] = {number: {} for number in places}
        for one, run in ended:
            number, _ = one.place
            found[number][one.place] = run
            if len(found[number]) == len(places[number]):
                for place in places[number]:
                    self.runs.add(place, found[number][place])
                yield number

    def judge(self, number: int) -> tuple[Variant, ...]:
        """The variants that a task wants further; if it wants none, it has a record now."""
        task = self.tasks[number]
        of_task = self.runs.of_task(number)
        # The trajectories are read once, both to find further runs and to judge.
        read = Recent(self.runs).trajectory
        needed = judging.needs(task, of_task, read)
        more = judging.missing(needed, of_task)
        if not more:
            name = task.engine.name
            self.records[number] = judging.record(
                task, self.versions[name], of_task, self._expected[name], read, needed
            )
        return more
