"""Findings, the tolerance table and refinement levels as plain rows, CSV and DataFrames."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from refdem.core.finding import Finding, Record, Sheet
from refdem.core.outside import cell
from refdem.report.contents import Contents, contents_of
from refdem.report.tolerance import TARGETS, Row, digits, rows_of

if TYPE_CHECKING:
    import pandas as pd

FINDING = (
    "id",
    "case",
    "label",
    "engine",
    "version",
    "method",
    "is_reference",
    "check",
    "quantity",
    "outcome",
    "value",
    "bound",
    "margin",
    "unit",
    "basis",
    "order_seen",
    "order_claimed",
    "constant_seen",
    "sentence",
)
TOLERANCE = (
    "case",
    "label",
    "engine",
    "version",
    "method",
    "is_reference",
    "quantity",
    "control",
    "outcome",
    "error",
    "bound_held",
    *(f"step_for_{digits(target):.0f}_digits" for target in TARGETS),
    "order_seen",
    "order_claimed",
    "constant",
    "seconds_for_6_digits",
    "farthest_engine",
    "apart_at_least",
    "apart_at_most",
)
LEVEL = (
    "case",
    "label",
    "engine",
    "method",
    "quantity",
    "control",
    "level",
    "error",
    "bound",
    "seconds",
    "counts",
)


class Tables(NamedTuple):
    """A report as DataFrames: a row a finding; a row of the tolerance table; a row a refinement
    level.
    """

    findings: "pd.DataFrame"
    tolerance: "pd.DataFrame"
    levels: "pd.DataFrame"


def tables(sheets: Sequence[Sheet]) -> Tables:
    """The sheets as DataFrames; absent numbers are NaN."""
    import pandas as pd

    contents = contents_of(sheets)
    rows: list[Row] = []
    for sheet in contents.cases:
        rows += rows_of(contents, sheet.label)
    return Tables(
        findings=pd.DataFrame(finding_rows(contents), columns=list(FINDING)),
        tolerance=pd.DataFrame(tolerance_rows(rows), columns=list(TOLERANCE)),
        levels=pd.DataFrame(level_rows(rows), columns=list(LEVEL)),
    )


def finding_rows(contents: Contents) -> list[tuple[Any, ...]]:
    """A row a finding, in the columns FINDING."""
    return [_finding_row(record, finding) for record, finding in contents.findings()]


def _finding_row(record: Record, finding: Finding) -> tuple[Any, ...]:
    """The cells of one finding: its id, then what its record and the finding itself say."""
    of_record = ("case", "label", "engine", "version", "method", "is_reference")
    of_finding = FINDING[1 + len(of_record) :]
    run = [getattr(record, name) for name in of_record]
    cells = [getattr(finding, name) for name in of_finding]
    return (record.id(finding), *run, *cells)


def tolerance_rows(rows: Iterable[Row]) -> list[tuple[Any, ...]]:
    """A row a line of the tolerance table, in the columns TOLERANCE."""
    return [_tolerance_row(row) for row in rows]


def _tolerance_row(row: Row) -> tuple[Any, ...]:
    """The cells of one line of the tolerance table; None where nothing was measured."""
    record = row.record
    largest_steps: list[float | None] = []
    for step in row.steps:
        size = None
        if step is not None:
            size, _ = step
        largest_steps.append(size)
    # The engine that is farthest away, and its least and largest distance.
    farthest_engine = row.apart or (None, None, None)
    return (
        record.case,
        record.label,
        record.engine,
        record.version,
        record.method,
        record.is_reference,
        row.quantity,
        row.control,
        row.outcome,
        row.error,
        row.bound_held,
        *largest_steps,
        row.order_seen,
        row.order_claimed,
        row.constant,
        row.seconds,
        *farthest_engine,
    )


def level_rows(rows: Iterable[Row]) -> list[tuple[Any, ...]]:
    """One row for each refinement level, with the columns LEVEL."""
    lines: list[tuple[Any, ...]] = []
    for row in rows:
        record = row.record
        run = (record.case, record.label, record.engine, record.method, row.quantity, row.control)
        for level in row.levels:
            lines.append((*run, level.level, level.error, level.bound, level.seconds, level.counts))
    return lines


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Rows as CSV with a header; absent values are empty."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([cell(value) for value in row])
    return out.getvalue()
