"""A campaign from specification to sheets, in four stages: plan, truths, runs, records.

The result of each stage is frozen and handed to the next one. A *sheet* is what a report is made
of: one for the campaign, each engine, each instance, and a record for each method on each instance.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import refdem
from refdem.core.engine import Engine
from refdem.core.finding import CampaignSheet, CaseSheet, Sheet
from refdem.core.store import Store
from refdem.engines.external import folders
from refdem.errors import UsageError
from refdem.execution.schedule import InProcess, Progress, Schedule, Scheduler
from refdem.execution.spool import Spool, spool
from refdem.planning import plan, required, sheets, unchanged
from refdem.planning.records import records
from refdem.planning.replays import replays
from refdem.planning.runs import Hangs, RequestedRun, Runner
from refdem.planning.specification import Specification
from refdem.planning.truths import is_lasting, sampled_truths


@dataclass(frozen=True)
class Campaign:
    """One campaign, in `jobs` worker processes, or in this one if that is 0.

    If `use_store` is false, everything is run anew, except that a truth is still proved only once.
    `scheduler`, if any, is the address of a Dask scheduler, whose workers make the runs; truths are
    proved on this machine.
    """

    specification: Specification
    store: Store
    jobs: int = 2
    use_store: bool = True
    progress: Progress = lambda stage, done, total: None
    scheduler: str = ""
    on_request: Callable[[RequestedRun], None] = lambda requested: None
    """Called with each run that is needed, before it is made or read."""

    def sheets(self) -> list[Sheet]:
        """All sheets of the campaign.

        They are read from the store if nothing has changed since an equal campaign. They are stored
        unless a run or a proof ended in a way that may not be reproducible.
        """
        start = time.perf_counter()
        # Folders of killed processes are deleted even if nothing is run now.
        folders.sweep()
        engines, _ = plan.engines(self.specification)
        _refuse_namesakes(engines)
        key = None
        stored = None
        if self.use_store:
            key = unchanged.key_of(self.specification, engines)
        if key:
            stored = unchanged.kept(self.store, key)
        if stored is None:
            ended = self._ended(engines)
            if key and ended.is_lasting:
                unchanged.keep(self.store, key, [self._campaign_sheet(start, ended), *ended.sheets])
        else:
            ended = _read(stored)
        # The findings that the campaign must make may have changed, so they are added last.
        own_sheet = self._campaign_sheet(start, ended)
        labels = [sheet.label for sheet in ended.sheets if isinstance(sheet, CaseSheet)]
        return [own_sheet, *required.held(ended.sheets, self.specification, engines, labels)]

    def _ended(self, engines: list[Engine]) -> "Ended":
        """The outcome of the four stages, one after another."""
        with spool() as trajectories:
            return self._judged(engines, trajectories)

    def _judged(self, engines: list[Engine], trajectories: Spool) -> "Ended":
        """The outcome of the four stages; its trajectories are in a spool until they are judged."""
        versions = {engine.name: engine.version() for engine in engines}
        deadlines = {
            engine.name: time.monotonic() + engine.budget
            for engine in engines
            if engine.budget is not None
        }
        rows = plan.rows(self.specification, engines)
        judged = {row.instance.label for row in rows if row.is_judged}
        with self._schedule(engines) as schedule:
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
                spool=trajectories,
                use_store=self.use_store,
                timeout=self.specification.timeout,
                versions=versions,
                deadlines=deadlines,
                hangs=Hangs(),
                progress=self.progress,
                on_request=self.on_request,
            )
            judged_records, runs = records(
                runner, tasks, versions, self.specification.perturbed_ulps
            )
        # An instance may be in several rows, with other checks: by label it has one sheet.
        cases = {}
        for row, truth in zip(rows, truths, strict=True):
            cases[row.instance.label] = sheets.case_sheet(row.instance, truth)
        return Ended(
            sheets=[
                *map(sheets.engine_sheet, engines),
                *cases.values(),
                *judged_records,
                *replays(tasks, runs, judged_records),
            ],
            made=runs.different(read=False),
            read=runs.different(read=True),
            is_lasting=runs.is_lasting and all(map(is_lasting, truths)),
        )

    def _schedule(self, engines: list[Engine]) -> Scheduler:
        """The schedule of proofs and runs: a cluster, worker processes, or this process."""
        if not self.jobs:
            return InProcess()
        timeout = self.specification.timeout
        here = Schedule(self.jobs, timeout)
        if self.scheduler:
            # Imports asyncio, which only a cluster needs.
            from refdem.execution import remote
            from refdem.execution.cluster import Cluster

            return Cluster(self.scheduler, remote.code_state(engines), timeout, here)
        return here

    def _campaign_sheet(self, start: float, ended: "Ended") -> CampaignSheet:
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
    """The outcome of a campaign: the sheets of engines, cases and records, the numbers of runs made
    and read from the store, and whether the outcome is reproducible.
    """

    sheets: list[Sheet]
    made: int
    read: int
    is_lasting: bool


def _read(stored: list[Sheet]) -> Ended:
    """The outcome of an unchanged campaign from its stored sheets: all of its runs count as
    read.
    """
    own_sheet, *others = stored
    assert isinstance(own_sheet, CampaignSheet)
    runs_read = own_sheet.runs_made + own_sheet.runs_read
    return Ended(sheets=others, made=0, read=runs_read, is_lasting=True)


def _refuse_namesakes(engines: list[Engine]) -> None:
    """Raises UsageError for two engines of one name: their findings could not be distinguished."""
    names = [engine.name for engine in engines]
    for engine in engines:
        if names.count(engine.name) > 1:
            raise UsageError(
                f"two engines are named {engine.name!r}; give each a name of its own in its"
                " refdem.toml"
            )
