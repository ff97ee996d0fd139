"""What a report is about, in its order: campaign, cases, engines, records."""

import hashlib
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

from refdem.core.finding import (
    BROKEN,
    DECIDED,
    WORST_FIRST,
    CampaignSheet,
    CaseSheet,
    EngineSheet,
    Finding,
    Outcome,
    Record,
    Sheet,
)
from refdem.core.moved import Moved
from refdem.core.outside import in_file_name
from refdem.core.replay import Replay
from refdem.core.resolution import Resolution
from refdem.report.jsonl import finite


@dataclass(frozen=True, eq=False)
class Contents:
    """The sheets by kind: cases by label, the reference before other engines, records likewise."""

    campaign: CampaignSheet
    cases: tuple[CaseSheet, ...]
    engines: tuple[EngineSheet, ...]
    records: tuple[Record, ...]
    replays: dict[str, Replay] = field(default_factory=dict)
    resolutions: tuple[Resolution, ...] = ()
    moved: dict[str, Moved] = field(default_factory=dict)

    def of(self, label: str) -> list[Record]:
        """The records of one instance, in the order of the report."""
        return list(self._by_label.get(label, ()))

    @cached_property
    def _by_label(self) -> dict[str, list[Record]]:
        """The records of each instance that has some."""
        found: dict[str, list[Record]] = {}
        for record in self.records:
            found.setdefault(record.label, []).append(record)
        return found

    def resolution_sentences(self, records: Iterable[Record]) -> dict[str, str]:
        """The resolution of the verdicts on some records: one sentence for each method.

        Methods whose resolution was not measured are left out.
        """
        places = [(record.label, record.engine, record.method) for record in records]
        return {
            place[-1]: self._resolution_sentences[place]
            for place in places
            if place in self._resolution_sentences
        }

    @cached_property
    def _resolution_sentences(self) -> dict[tuple[str, str, str], str]:
        """The sentence of each resolution, by label, engine and method."""
        return {(one.label, one.engine, one.method): one.sentence for one in self.resolutions}

    def counts(self, records: Iterable[Record] | None = None) -> dict[Outcome, int]:
        """How many findings have each outcome, worst first, without zeros."""
        if records is None:
            records = self.records
        counts: Counter[Outcome] = Counter()
        for record in records:
            counts.update(finding.outcome for finding in record.findings)
        return {outcome: counts[outcome] for outcome in WORST_FIRST if counts[outcome]}

    def refusal(self, label: str, engine: str) -> str:
        """The first reason why an engine does not run an instance; empty if it gave none."""
        for record in self.of(label):
            for finding in record.findings:
                if record.engine == engine and finding.outcome == "unsupported":
                    return finding.sentence
        return ""

    def findings(self) -> Iterator[tuple[Record, Finding]]:
        """Every finding with its record."""
        for record in self.records:
            for finding in record.findings:
                yield record, finding


def contents_of(sheets: Iterable[Sheet]) -> Contents:
    """The contents of a report; a case or an engine without a sheet of its own gets an empty
    one.
    """
    campaign = CampaignSheet(name="records", refdem="", runs_made=0, runs_read=0, seconds=0.0)
    cases: dict[str, CaseSheet] = {}
    engines: dict[str, EngineSheet] = {}
    records = []
    replays: dict[str, Replay] = {}
    resolutions = []
    moved: dict[str, Moved] = {}
    for sheet in map(finite, sheets):
        match sheet:
            case CaseSheet():
                cases[sheet.label] = sheet
            case EngineSheet():
                engines[sheet.engine] = sheet
            case CampaignSheet():
                campaign = sheet
            case Record():
                records.append(sheet)
            case Replay():
                replays[sheet.label] = sheet
            case Resolution():
                resolutions.append(sheet)
            case Moved():
                moved[sheet.label] = sheet
    for record in records:
        cases.setdefault(record.label, _bare_case(record))
        engines.setdefault(record.engine, _bare_engine(record))
    return Contents(
        campaign=campaign,
        cases=tuple(cases[label] for label in sorted(cases)),
        engines=tuple(sorted(engines.values(), key=_engine_order)),
        records=tuple(sorted(records, key=_record_order)),
        replays=replays,
        resolutions=tuple(resolutions),
        moved=moved,
    )


def _engine_order(sheet: EngineSheet) -> tuple[bool, str]:
    """Sorts the reference before other engines, these by name."""
    return not sheet.is_reference, sheet.engine


def _record_order(record: Record) -> tuple[str, bool, str, str]:
    """Sorts by instance, then the reference before other engines, then by engine and method."""
    return record.label, not record.is_reference, record.engine, record.method


def _bare_case(record: Record) -> CaseSheet:
    """The sheet of a case of which there is only a record."""
    return CaseSheet(
        case=record.case,
        label=record.label,
        title=record.case,
        statement="",
        latex="",
        source="",
        parameters=record.parameters,
        units={},
        scene="",
        scales={},
        quantities={},
        truth_method="",
        truth_witness="",
        truth_scalars={},
    )


def _bare_engine(record: Record) -> EngineSheet:
    """The sheet of an engine of which there is only a record."""
    return EngineSheet(
        engine=record.engine,
        title=record.engine,
        version=record.version,
        licence="",
        is_reference=record.is_reference,
        methods={},
        audit=(),
    )


def page(label: str) -> str:
    """A file name for an instance, safe on any file system and different for different labels."""
    plain = in_file_name(label)
    if plain and plain == label:
        return plain
    return f"{plain}-{_digest(label)}".lstrip("-")


def anchor(identity: str) -> str:
    """The id of a finding in its page."""
    return f"f-{_digest(identity)}"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:10]


ADVICE: dict[Outcome, str] = {
    "fail": (
        "A measured value is above its bound. Read each failed finding: its"
        " sentence names the quantity and the basis of the bound."
    ),
    "worse": (
        "An error constant grew beyond what the baseline accepts. Find the change"
        " that caused it, or bless the new one with a reason."
    ),
    "lost": (
        "Findings that the baseline or the list of the campaign contains could"
        " not be decided in this run. Each finding says why."
    ),
    "absent": (
        "Findings that the baseline or the list of the campaign contains are"
        " missing in this run. Restore them, or bless their absence."
    ),
    "error": (
        "An engine crashed, hung or broke the contract. Its runs are not judged:"
        " repair the engine or its adapter, then run again."
    ),
    "stale": (
        "An expected deviation is no longer needed: the ordinary bound holds."
        " Delete it from the list of expected deviations."
    ),
    "undecided": (
        "Nothing failed, but some findings could not be decided; each says why. They are not"
        " passes."
    ),
    "expected": (
        "All bounds hold, except where a known deviation is expected, with its reason. Nothing"
        " to do."
    ),
    "unsupported": (
        "Everything that the engines support holds. The rest is listed with the"
        " missing feature. Nothing to do."
    ),
    "pass": "Everything holds. Choose a step from the tolerance table below.",
}


def advice(counts: dict[Outcome, int]) -> str:
    """What a reader new to the project should do, by the worst outcome."""
    if not counts:
        return "There are no findings: nothing was judged."
    if not any(outcome in counts for outcome in (*DECIDED, *BROKEN)):
        return (
            "Nothing was judged: no engine supports the request, or no check could"
            " decide it. Each finding says why."
        )
    return next(ADVICE[outcome] for outcome in WORST_FIRST if outcome in counts)
