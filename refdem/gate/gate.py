"""One gate: the program of a refdem.toml runs anew, is judged, and is compared with its
baseline.
"""

from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.finding import DECIDED, Finding, Record, Sheet, findings_of
from refdem.core.parameters import labelled
from refdem.core.resolution import Resolution
from refdem.core.selection import Selection
from refdem.core.store import Store, default_path
from refdem.engines.external import load
from refdem.errors import EngineMissingError, UsageError
from refdem.execution.schedule import Progress
from refdem.gate import baseline, compare
from refdem.gate.baseline import Accepted
from refdem.gate.probing import LABEL, probe_records
from refdem.planning.campaign import Campaign
from refdem.planning.resolution import measured
from refdem.planning.specification import Entry, Specification, named

ULPS = (2, -2, 6)
"""Units in the last place by which the starts of reruns are moved, to measure the noise of a value.
"""
GRACE = 30.0
"""Seconds in addition to the program's own time limit before its worker is killed, so that the
program's limit takes effect first.
"""


@dataclass
class Gate:
    """The gate of one engine: its cases, levels and baseline."""

    engine: Engine
    cases: list[Entry]
    levels: int
    baseline: Path
    timeout: float
    store: Store
    jobs: int = 2
    progress: Progress = lambda stage, done, total: None
    has_probes: bool = False
    """True if the probes of `refdem smoke` are run as well."""
    _noise: dict[tuple[str, str], list[Record]] = field(default_factory=dict)

    def specification(self) -> Specification:
        """The specification of the campaign that the gate runs."""
        return Specification(
            name=f"gate of {self.engine.name}",
            case=self.cases,
            engines=[self.engine.address],
            levels=self.levels,
            timeout=self.timeout + GRACE,
        )

    def sheets(self) -> list[Sheet]:
        """The sheets of a new campaign, not yet compared with the baseline.

        Raises UsageError if nothing was decided and there is no baseline to compare with.
        """
        campaign = Campaign(
            self.specification(), self.store, self.jobs, use_store=False, progress=self.progress
        )
        sheets = campaign.sheets()
        findings = [finding for _, finding in findings_of(sheets)]
        has_outcome = any(finding.outcome in (*DECIDED, "error") for finding in findings)
        if not self.baseline.is_file() and not has_outcome:
            sentences = dict.fromkeys(finding.sentence for finding in findings)
            reasons = "; ".join(sentences) or "no case"
            raise UsageError(f"the gate of {self.engine.name} decided nothing: {reasons}")
        if self.has_probes:
            return [*sheets, *probe_records(self.engine)]
        return sheets

    def resolution(self) -> list[Resolution]:
        """The resolution for each number of the program's scenes, by about twenty more runs for
        each.
        """
        return measured(self.specification(), self.store, self.jobs, self.progress, use_store=False)

    def accepted(self) -> dict[str, Accepted]:
        """The accepted findings by id; raises UsageError if the baseline cannot be read, or is
        another program's.
        """
        _, accepted = baseline.read(self.baseline, self.engine.name)
        return accepted

    def against_baseline(self, sheets: list[Sheet]) -> list[Sheet]:
        """The sheets with every record compared with the baseline; raises UsageError if there is
        none.
        """
        accepted = self.accepted()
        records = [sheet for sheet in sheets if isinstance(sheet, Record)]
        others = [sheet for sheet in sheets if not isinstance(sheet, Record)]
        return [*others, *compare.compared(records, accepted, self.noise)]

    def noise(self, record: Record, finding: Finding) -> float:
        """The largest change of a finding's size in reruns whose starts are moved by ULPS; 0 for a
        probe, which is not rerun.
        """
        size = compare.size(finding)
        if size is None or record.label == LABEL:
            return 0.0
        name = record.id(finding)
        changes = []
        for rerun, rerun_finding in findings_of(self._reruns(record)):
            rerun_size = compare.size(rerun_finding)
            if rerun.id(rerun_finding) == name and rerun_size is not None:
                changes.append(abs(rerun_size - size))
        return max(changes, default=0.0)

    def _reruns(self, record: Record) -> list[Record]:
        """The records of the same method and instance from each of the moved starts, run once."""
        key = (record.label, record.method)
        if key not in self._noise:
            entry = Entry(*labelled(record.label))
            base = msgspec.structs.replace(self.specification(), case=[entry], method=record.method)
            records: list[Record] = []
            for ulps in ULPS:
                specification = msgspec.structs.replace(base, perturbed_ulps=ulps)
                campaign = Campaign(specification, self.store, self.jobs, use_store=False)
                records += [sheet for sheet in campaign.sheets() if isinstance(sheet, Record)]
            self._noise[key] = records
        return self._noise[key]


def of_program(toml: Path, baseline_file: Path | None, jobs: int, progress: Progress) -> Gate:
    """The gate that a refdem.toml describes; raises UsageError, or EngineMissingError if the
    program is not there.
    """

    program = load(toml)
    if (reason := program.missing()) is not None:
        raise EngineMissingError(f"{toml}: {reason}")
    table = program.description
    named_cases = [Entry(*labelled(label)) for label in table.gate.cases]
    cases = named_cases or supported(program)
    if not cases:
        raise UsageError(
            f"{toml}: engine.supports allows no case; expected features such as spring, rotation or"
            " contact:linear"
        )
    place = baseline_file or program.path.parent / table.gate.baseline
    store = Store(default_path())
    return Gate(
        engine=program,
        cases=cases,
        levels=table.gate.levels,
        baseline=place,
        timeout=table.engine.timeout,
        store=store,
        jobs=jobs,
        progress=progress,
        has_probes=not named_cases,
    )


def supported(engine: Engine) -> list[Entry]:
    """Every case that some method of the engine supports, at its defaults and at the parameters
    that the campaign `gate` has for it.
    """
    entries_of_gate = named("gate").case
    entries = []
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if isinstance(case, Selection):
            continue
        of_case = [entry for entry in entries_of_gate if entry.id == name]
        for entry in (Entry(name), *of_case):
            problem = case.at(**entry.set).problem
            if any(engine.unsupported(problem, method) is None for method in engine.methods):
                entries.append(entry)
    return entries
