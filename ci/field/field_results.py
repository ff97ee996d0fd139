"""What the gate of a code found, as reports/field/NAME.jsonl keeps it: how its last run ended, and
a line for each method on each case.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import msgspec

from refdem.core.finding import Outcome, Record
from refdem.report.contents import contents_of
from refdem.report.invariants import Verdict, law_sheets
from refdem.report.numbers import rounded
from refdem.report.tolerance import TARGETS, Row, rows_of, worst_rows

ACCURACY = TARGETS[0]
"""The error, in units of a quantity's scale, at which times are reported: sufficient for a picture.
"""


Derivatives = Literal["right", "wrong", "undecided", "none"]
"""What check `gradient` found of the derivatives that a method computed; none if it computes none.
"""


class Run(msgspec.Struct, frozen=True, kw_only=True):
    """The last run of the gate of a code: how it ended, its version, the methods with what they
    are, and the day (UTC).
    """

    code: str
    version: str
    state: str
    date: str
    methods: dict[str, str]


class Law(msgspec.Struct, frozen=True, array_like=True):
    """How a law is kept, and the largest change in units of the scale; None where unknown."""

    verdict: Verdict
    change: float | None


class Result(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One method on one case.

    `error` is that of the worst quantity at the finest step, in units of its scale; `seconds` are
    those of the largest step from which on every error is at most ACCURACY. `laws` are by check,
    `deviations` are findings that deviate as expected (check/quantity), `refused` is the reason of
    a method that did not run. Numbers have two digits.
    """

    label: str
    method: str
    counts: dict[Outcome, int]
    quantity: str = ""
    error: float | None = None
    seconds: float | None = None
    laws: dict[str, Law] = {}
    derivatives: Derivatives = "none"
    deviations: tuple[str, ...] = ()
    refused: str = ""


class Kept(msgspec.Struct, frozen=True):
    """The file of a code: its run, and the results by case and method."""

    run: Run
    results: tuple[Result, ...]


def result(record: Record) -> Result:
    """What a record says, in short."""
    contents = contents_of([record])
    rows = rows_of(contents, record.label)
    worst = next(iter(worst_rows(rows)), None)
    quantity = ""
    error = None
    if worst is not None:
        # A single quantity has no row of its own beside the worst of all.
        found = [
            finding for finding in record.findings if finding.check == "error" and finding.levels
        ]
        quantity = max(found, key=lambda finding: finding.levels[-1].error).quantity
        error = rounded(worst.error)
    expected = [finding for finding in record.findings if finding.outcome == "expected"]
    return Result(
        label=record.label,
        method=record.method,
        counts=contents.counts(),
        quantity=quantity,
        error=error,
        seconds=seconds(worst),
        laws=laws(record),
        derivatives=derivatives(record),
        deviations=tuple(f"{finding.check}/{finding.quantity}" for finding in expected),
        refused=refusal(record),
    )


def seconds(worst: Row | None) -> float | None:
    """The seconds to ACCURACY in the worst quantity; None where no step holds it."""
    if worst is None or worst.steps[0] is None:
        return None
    largest_step, _ = worst.steps[0]
    return next(rounded(level.seconds) for level in worst.levels if level.level == largest_step)


def laws(record: Record) -> dict[str, Law]:
    """How each law that was judged is kept, by its check."""
    found = {}
    for sheet in law_sheets(contents_of([record])):
        (conserved,) = sheet.summaries[record.engine].settings
        change = conserved.change
        if change is not None:
            change = rounded(change)
        found[sheet.law.check] = Law(conserved.verdict, change)
    return found


def derivatives(record: Record) -> Derivatives:
    """What the findings of check `gradient` say together."""
    outcomes = {finding.outcome for finding in record.findings if finding.check == "gradient"}
    if outcomes & {"expected", "fail", "error"}:
        return "wrong"
    if "pass" in outcomes:
        return "right"
    if "undecided" in outcomes:
        return "undecided"
    return "none"


def refusal(record: Record) -> str:
    """Why a method ran nothing of a case, in the words of its driver; empty if it ran."""
    sentences = [
        finding.sentence for finding in record.findings if finding.outcome == "unsupported"
    ]
    if len(sentences) < len(record.findings):
        return ""
    # The sentence of a run that ended begins with the run.
    return sentences[0].rpartition("): ")[2].removesuffix(".")


def results(records: Iterable[Record]) -> tuple[Result, ...]:
    """The results of all records, by case and method."""
    found = map(result, records)
    return tuple(sorted(found, key=lambda one: (one.label, one.method)))


def write(path: Path, kept: Kept) -> None:
    """Writes the file of a code, the same bytes for the same results."""
    lines = [msgspec.json.encode(line, order="deterministic") for line in (kept.run, *kept.results)]
    path.write_bytes(b"".join(line + b"\n" for line in lines))


def read(path: Path) -> Kept:
    """The file of a code."""
    first, *others = path.read_bytes().splitlines()
    run = msgspec.json.decode(first, type=Run)
    return Kept(run, tuple(msgspec.json.decode(line, type=Result) for line in others))
