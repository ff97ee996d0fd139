"""A campaign from specification to sheets, in four stages: plan, truths, runs, records.

What a stage finds is handed to the next one and is not changed any more.
"""

import time
from dataclasses import dataclass

import refdem
from refdem.campaign import plan, required, runs, sheets, unchanged
from refdem.campaign.records import records
from refdem.campaign.runs import Hangs, Runner
from refdem.campaign.schedule import InProcess, Progress, Schedule
from refdem.campaign.specification import Specification
from refdem.campaign.truths import is_lasting, sampled_truths
from refdem.core.engine import Engine
from refdem.core.finding import CampaignSheet, CaseSheet, Sheet
from refdem.core.store import Store
from refdem.errors import UsageError


@dataclass(frozen=True)
class Campaign:
    """One campaign, in `jobs` worker processes, or in this one if that is 0.

    `use_store` False runs everything anew (truth is proved once all the same).
    """

    specification: Specification
    store: Store
    jobs: int = 2
    use_store: bool = True
    progress: Progress = lambda stage, done, total: None

    def sheets(self) -> list[Sheet]:
        """Everything that a report is made of; kept, unless something ended in a way that it may
        not end in next time.
        """
        start = time.perf_counter()
        engines, _ = plan.engines(self.specification)
        _refuse_namesakes(engines)
        key = None
        kept = None
        if self.use_store:
            key = unchanged.key_of(self.specification, engines)
        if key:
            kept = unchanged.kept(self.store, key)
        if kept is None:
            ended = self._ended(engines)
            if key and ended.is_lasting:
                unchanged.keep(self.store, key, [self._whole(start, ended), *ended.sheets])
        else:
            ended = _read(kept)
        whole = self._whole(start, ended)
        labels = [sheet.label for sheet in ended.sheets if isinstance(sheet, CaseSheet)]
        return [whole, *required.held(ended.sheets, self.specification, engines, labels)]

    def _ended(self, engines: list[Engine]) -> "Ended":
        """The four stages, one after another."""
        versions = {engine.name: engine.version() for engine in engines}
        deadlines = {
            engine.name: time.monotonic() + engine.budget
            for engine in engines
            if engine.budget is not None
        }
        rows = plan.rows(self.specification, engines)
        judged = {row.instance.label for row in rows if row.is_judged}
        with self._schedule() as schedule:
            truths = sampled_truths(
                schedule,
                self.store,
                [(row.instance, row.delays) for row in rows],
                self.progress,
                is_judged=lambda instance: instance.label in judged,
            )
            tasks = plan.tasks_of(self.specification, rows, truths)
            runner = Runner(
                schedule=schedule,
                store=self.store,
                use_store=self.use_store,
                timeout=self.specification.timeout,
                versions=versions,
                deadlines=deadlines,
                hangs=Hangs(),
                progress=self.progress,
            )
            came = runs.of_tasks(runner, tasks, self.specification.perturbed_ulps)
        found = records(tasks, came, versions)
        cases = {}
        for row, truth in zip(rows, truths, strict=True):
            cases[row.instance.label] = sheets.case_sheet(row.instance, truth)
        return Ended(
            sheets=[*map(sheets.engine_sheet, engines), *cases.values(), *found],
            made=came.made,
            read=came.read,
            is_lasting=came.is_lasting and all(map(is_lasting, truths)),
        )

    def _schedule(self) -> Schedule | InProcess:
        """Where proofs and runs are made."""
        if self.jobs:
            return Schedule(self.jobs, self.specification.timeout)
        return InProcess()

    def _whole(self, start: float, ended: "Ended") -> CampaignSheet:
        """The sheet of the campaign itself, which began at `start` [s] of the clock."""
        return CampaignSheet(
            name=self.specification.name,
            refdem=refdem.__version__,
            runs_made=ended.made,
            runs_read=ended.read,
            seconds=time.perf_counter() - start,
        )


@dataclass(frozen=True, kw_only=True)
class Ended:
    """What a campaign came to: the sheets of engines, cases and records, and how many runs were
    made and read for them.
    """

    sheets: list[Sheet]
    made: int
    read: int
    is_lasting: bool


def _read(kept: list[Sheet]) -> Ended:
    """A campaign of which nothing has changed: all of its runs are read."""
    whole, *found = kept
    assert isinstance(whole, CampaignSheet)
    return Ended(sheets=found, made=0, read=whole.runs_made + whole.runs_read, is_lasting=True)


def _refuse_namesakes(engines: list[Engine]) -> None:
    """Raises UsageError for two engines of one name: their findings could not be told apart."""
    names = [engine.name for engine in engines]
    for engine in engines:
        if names.count(engine.name) > 1:
            raise UsageError(
                f"two engines are named {engine.name!r}; give each a name of its own in its"
                " refdem.toml"
            )
