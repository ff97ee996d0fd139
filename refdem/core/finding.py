"""Findings with their reasons, collected in records, and the other sheets of a report.

A finding compares one measured value with a bound; its margin is log10(bound/value) decades.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from refdem.core.moved import Moved
from refdem.core.replay import Replay
from refdem.core.resolution import Resolution

Outcome = Literal[
    "pass",
    "fail",
    "error",
    "unsupported",
    "undecided",
    "expected",
    "stale",
    "worse",
    "lost",
    "absent",
]
"""The last three are results of a comparison with a baseline, or with the list of a campaign:
"worse" than the baseline; "lost", which is decided or required there and not decided now; "absent",
which is there and was not made now.
"""
WORST_FIRST: tuple[Outcome, ...] = (
    "error",
    "fail",
    "worse",
    "lost",
    "absent",
    "stale",
    "undecided",
    "expected",
    "unsupported",
    "pass",
)
"""Order of severity. An error is first, since it explains why other findings are missing."""
FAILING: tuple[Outcome, ...] = ("fail", "worse", "lost", "absent", "stale")
"""Outcomes with which a command exits with status 1; with `error` alone it exits with 3."""
BROKEN: tuple[Outcome, ...] = (*FAILING, "error")
DECIDED: tuple[Outcome, ...] = ("pass", "fail", "expected", "stale", "worse")


class Level(msgspec.Struct, frozen=True, kw_only=True):
    """One refinement level of a finding.

    `level` is the step [s] or tolerance, `error` the largest error over the run in units of the
    quantity's scale, `bound` its bound, `seconds` the time in the engine's loop, `counts` whether
    the level is used for the order, and `steps` the number of steps of the run (0 if not counted,
    as in records of older versions).
    """

    level: float
    error: float
    bound: float
    seconds: float
    counts: bool
    steps: int = 0


class Series(msgspec.Struct, frozen=True, kw_only=True):
    """A curve over time for a plot: t [s], value and bound, of equal lengths."""

    t: list[float]
    value: list[float]
    bound: list[float]


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """One judgement: a measured value, a bound with its basis, and a sentence with the reason.

    `sharpness` is the smallest ratio of bound to signal over the samples, where the signal is the
    largest change of the quantity so far in this run. It is None if the law requires the quantity
    to be constant, and in records of older versions.
    """

    check: str
    quantity: str
    outcome: Outcome
    sentence: str
    value: float | None = None
    bound: float | None = None
    unit: str = "1"
    basis: str = ""
    levels: tuple[Level, ...] = ()
    series: Series | None = None
    order_seen: float | None = None
    order_claimed: float | None = None
    constant_seen: float | None = None
    sharpness: float | None = None

    @property
    def margin(self) -> float | None:
        """log10(bound/value) [decades], positive for a value within its bound.

        It is None without a value or bound, infinite for a value of 0, and minus infinity for a
        value that is not finite or a bound of 0.
        """
        if self.value is None or self.bound is None:
            return None
        if not math.isfinite(self.value):
            return -math.inf
        if self.value <= 0:
            return math.inf
        if self.bound > 0:
            return math.log10(self.bound) - math.log10(self.value)
        return -math.inf


class Record(msgspec.Struct, frozen=True, kw_only=True, tag="record", tag_field="type"):
    """The findings on one case, at its parameters, with one method of one engine."""

    case: str
    label: str
    parameters: dict[str, str]
    engine: str
    version: str
    method: str
    is_reference: bool
    runs: tuple[str, ...]
    findings: tuple[Finding, ...]
    seconds: float = 0.0

    def id(self, finding: Finding) -> str:
        """The id of a finding, `case[params]/engine/method/check/quantity`."""
        return f"{self.label}/{self.engine}/{self.method}/{finding.check}/{finding.quantity}"


class CaseSheet(msgspec.Struct, frozen=True, kw_only=True, tag="case", tag_field="type"):
    """An instance as a report shows it: statement, scene, parameters, and how its truth was
    proved.
    """

    case: str
    label: str
    title: str
    statement: str
    latex: str
    source: str
    parameters: dict[str, str]
    units: dict[str, str]
    scene: str
    scales: dict[str, float]
    quantities: dict[str, str]
    truth_method: str
    truth_witness: str
    truth_scalars: dict[str, tuple[str, str]]
    truth_reason: str = ""
    reproduce: str = ""
    motion: str = "other"
    words: tuple[str, ...] = ()


class EngineSheet(msgspec.Struct, frozen=True, kw_only=True, tag="engine", tag_field="type"):
    """An engine as a report shows it: version, methods with claims, audit of defaults, and the step
    [s] that it takes where its user names none.
    """

    engine: str
    title: str
    version: str
    licence: str
    is_reference: bool
    methods: dict[str, str]
    audit: tuple[tuple[str, str, str, str], ...]
    default_step: float | None = None


class CampaignSheet(msgspec.Struct, frozen=True, kw_only=True, tag="campaign", tag_field="type"):
    """A campaign as a report shows it: name, numbers of runs made and read from the store, and the
    seconds that it took.
    """

    name: str
    refdem: str
    runs_made: int
    runs_read: int
    seconds: float


Sheet = Record | CaseSheet | EngineSheet | CampaignSheet | Replay | Resolution | Moved


def findings_of(sheets: Iterable[Sheet]) -> Iterator[tuple[Record, Finding]]:
    """Every finding of the records among the sheets, with its record, in their order."""
    for sheet in sheets:
        if isinstance(sheet, Record):
            for finding in sheet.findings:
                yield sheet, finding


def worst_first(sheets: Iterable[Sheet]) -> list[tuple[Record, Finding]]:
    """Every finding with its record: by outcome, then by margin."""

    def rank(pair: tuple[Record, Finding]) -> tuple[int, float]:
        _, finding = pair
        return WORST_FIRST.index(finding.outcome), finding.margin or 0.0

    return sorted(findings_of(sheets), key=rank)
