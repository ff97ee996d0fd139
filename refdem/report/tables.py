"""Findings, the tolerance table and refinement levels as plain rows, CSV and DataFrames."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from refdem.core.finding import Sheet
from refdem.core.outside import cell
from refdem.report.contents import Contents, contents_of
from refdem.report.tolerance import TARGETS, Row, rows_of

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
    *(f"step_{target:.0e}" for target in TARGETS),
    "order_seen",
    "order_claimed",
    "constant",
    "seconds_1e-06",
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
    rows = [row for sheet in contents.cases for row in rows_of(contents, sheet.label)]
    return Tables(
        pd.DataFrame(finding_rows(contents), columns=list(FINDING)),
        pd.DataFrame(tolerance_rows(rows), columns=list(TOLERANCE)),
        pd.DataFrame(level_rows(rows), columns=list(LEVEL)),
    )


def finding_rows(contents: Contents) -> list[tuple[Any, ...]]:
    """A row a finding, in the columns FINDING."""
    return [
        (
            record.id(f),
            record.case,
            record.label,
            record.engine,
            record.version,
            record.method,
            record.is_reference,
            f.check,
            f.quantity,
            f.outcome,
            f.value,
            f.bound,
            f.margin,
            f.unit,
            f.basis,
            f.order_seen,
            f.order_claimed,
            f.constant_seen,
            f.sentence,
        )
        for record, f in contents.findings()
    ]


def tolerance_rows(rows: Iterable[Row]) -> list[tuple[Any, ...]]:
    """A row a line of the tolerance table, in the columns TOLERANCE."""
    return [
        (
            row.record.case,
            row.record.label,
            row.record.engine,
            row.record.version,
            row.record.method,
            row.record.is_reference,
            row.quantity,
            row.control,
            row.outcome,
            row.error,
            row.bound_held,
            *(step[0] if step else None for step in row.steps),
            row.order_seen,
            row.order_claimed,
            row.constant,
            row.seconds,
            *(row.apart or (None, None, None)),
        )
        for row in rows
    ]


def level_rows(rows: Iterable[Row]) -> list[tuple[Any, ...]]:
    """A row a refinement level, in the columns LEVEL."""
    return [
        (
            row.record.case,
            row.record.label,
            row.record.engine,
            row.record.method,
            row.quantity,
            row.control,
            level.level,
            level.error,
            level.bound,
            level.seconds,
            level.counts,
        )
        for row in rows
        for level in row.levels
    ]


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Rows as CSV with a header; absent values are empty."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([cell(value) for value in row] for row in rows)
    return out.getvalue()
