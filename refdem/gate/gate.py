"""One gate: the program of a refdem.toml runs anew, is judged, and is compared with its
baseline.
"""

from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from refdem.campaign.campaign import Campaign
from refdem.campaign.schedule import Progress
from refdem.campaign.specification import Entry, Specification, named
from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.finding import DECIDED, Finding, Record, Sheet, findings_of
from refdem.core.parameters import labelled
from refdem.core.selection import Selection
from refdem.core.store import Store, default_path
from refdem.engines.external import load
from refdem.errors import EngineMissingError, UsageError
from refdem.gate import baseline, compare

ULPS = (2, -2, 6)
"""Starts moved by so many units in the last place show how much of a value is noise."""
GRACE = 30.0
"""Seconds beyond the program's own time limit before its worker is killed: the program's limit
comes first.
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
        """Everything found now, without the baseline; raises UsageError if that is nothing, and
        nothing was accepted.
        """
        sheets = Campaign(
            self.specification(), self.store, self.jobs, use_store=False, progress=self.progress
        ).sheets()
        findings = [finding for _, finding in findings_of(sheets)]
        if not self.baseline.is_file() and not any(
            f.outcome in (*DECIDED, "error") for f in findings
        ):
            reasons = "; ".join(dict.fromkeys(f.sentence for f in findings)) or "no case"
            raise UsageError(f"the gate of {self.engine.name} decided nothing: {reasons}")
        return sheets

    def against_baseline(self, sheets: list[Sheet]) -> list[Sheet]:
        """The sheets with every record compared with the baseline; raises UsageError if there is
        none.
        """
        _, accepted = baseline.read(self.baseline)
        records = [sheet for sheet in sheets if isinstance(sheet, Record)]
        rest = [sheet for sheet in sheets if not isinstance(sheet, Record)]
        return [*rest, *compare.compared(records, accepted, self.noise)]

    def noise(self, record: Record, finding: Finding) -> float:
        """How far the size of a finding moves in reruns whose start is moved by some units in the
        last place.
        """
        key = (record.label, record.method)
        if key not in self._noise:
            entry = Entry(*labelled(record.label))
            base = msgspec.structs.replace(self.specification(), case=[entry], method=record.method)
            moved = [msgspec.structs.replace(base, perturbed_ulps=ulps) for ulps in ULPS]
            records: list[Record] = []
            for specification in moved:
                campaign = Campaign(specification, self.store, self.jobs, use_store=False)
                records += [sheet for sheet in campaign.sheets() if isinstance(sheet, Record)]
            self._noise[key] = records
        name = record.id(finding)
        now = compare.size(finding)
        again = [
            compare.size(moved_finding)
            for other, moved_finding in findings_of(self._noise[key])
            if other.id(moved_finding) == name
        ]
        return max(
            (abs(value - now) for value in again if value is not None and now is not None),
            default=0.0,
        )


def of_program(toml: Path, baseline_file: Path | None, jobs: int, progress: Progress) -> Gate:
    """The gate that a refdem.toml describes; raises UsageError, or EngineMissingError if the
    program is not there.
    """

    program = load(toml)
    if (reason := program.missing()) is not None:
        raise EngineMissingError(f"{toml}: {reason}")
    table = program.description
    cases = [Entry(*labelled(label)) for label in table.gate.cases] or supported(program)
    if not cases:
        raise UsageError(
            f"{toml}: engine.supports allows no case; expected features such as spring, rotation or"
            " contact:linear"
        )
    place = baseline_file or program.path.parent / table.gate.baseline
    store = Store(default_path())
    return Gate(
        program, cases, table.gate.levels, place, table.engine.timeout, store, jobs, progress
    )


def supported(engine: Engine) -> list[Entry]:
    """Every case that some method of the engine does not refuse, at its defaults and at the
    settings of the campaign `gate`, which tell more.
    """
    telling = named("gate").case
    found = []
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if isinstance(case, Selection):
            continue
        of_case = [entry for entry in telling if entry.id == name]
        for entry in (Entry(name), *of_case):
            problem = case.at(**entry.set).problem
            if any(engine.unsupported(problem, method) is None for method in engine.methods):
                found.append(entry)
    return found
