"""What charts show, as plain rows with two significant digits, taken from findings."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from refdem.core.finding import WORST_FIRST, Finding, Record
from refdem.report.contents import Contents
from refdem.report.numbers import rounded
from refdem.report.palette import engine_colours, styles
from refdem.report.tolerance import WORST, Row, worst_rows

MOST_POINTS = 64
"""Points that a curve keeps in a chart; the largest value of each stretch is the one that is kept.
"""


@dataclass(frozen=True)
class ChartData:
    """Input of one chart: its kind, rows as CSV, choices of its selector, styles, and what else its
    definition reads.
    """

    kind: str
    csv: str
    choices: tuple[str, ...] = ()
    styles: tuple[tuple[str, str, str], ...] = ()
    extents: dict[str, tuple[float, float]] = field(default_factory=dict)
    labels: tuple[str, ...] = ()


def errors(contents: Contents, rows: Sequence[Row]) -> ChartData | None:
    """Error against step (or tolerance) of one instance, with bounds."""
    found: list[dict[str, Any]] = [
        {
            "series": row.series,
            "quantity": row.quantity,
            "control": row.control,
            "level": rounded(level.level, 4),
            "error": rounded(level.error),
            "bound": rounded(level.bound),
        }
        for row in rows
        for level in row.levels
    ]
    chart = _chart(
        "errors",
        contents,
        (row.record for row in rows),
        found,
        ("error", "bound"),
        _quantities(rows),
    )
    for control in ("step", "tolerance", "exact"):
        chosen = [float(item["level"]) for item in found if item["control"] == control]
        if chart and chosen:
            chart.extents[control] = _ends(chosen)
    return chart


def _ends(values: list[float]) -> tuple[float, float]:
    """The smallest and the largest value, apart where there is only one, as an axis needs two
    ends.
    """
    if min(values) == max(values):
        alone = 2.0
    else:
        alone = 1.0
    return min(values) / alone, max(values) * alone


def costs(contents: Contents, rows: Sequence[Row]) -> ChartData | None:
    """Error against seconds of one instance; only for pages that are not committed."""
    found: list[dict[str, Any]] = [
        {
            "series": row.series,
            "quantity": row.quantity,
            "seconds": rounded(level.seconds),
            "error": rounded(level.error),
        }
        for row in rows
        for level in row.levels
        if level.seconds > 0
    ]
    chart = _chart(
        "costs", contents, (row.record for row in rows), found, ("error",), _quantities(rows)
    )
    if chart:
        chart.extents["seconds"] = _ends([float(item["seconds"]) for item in found])
    return chart


def _quantities(rows: Sequence[Row]) -> list[str]:
    return [WORST, *sorted({row.quantity for row in rows} - {WORST})]


def overview(contents: Contents, rows: Sequence[Row]) -> ChartData | None:
    """Error against step in units of the first step, every instance a small picture, every engine a
    colour.
    """
    found: list[dict[str, Any]] = [
        {
            "case": row.record.label,
            "engine": row.record.engine,
            "series": row.series,
            "halvings": rounded(math.log2(row.levels[0].level / level.level), 3),
            "error": rounded(level.error),
        }
        for row in worst_rows(rows)
        for level in row.levels
        if row.control == "step" and level.error > 0
    ]
    if not found:
        return None
    colours = engine_colours(contents)
    engines = sorted({item["engine"] for item in found}, key=list(colours).index)
    cases = tuple(sorted({item["case"] for item in found}))
    marks = tuple((name, colours[name], "circle") for name in engines)
    return ChartData(
        "overview",
        _csv(found),
        styles=marks,
        extents={"error": _decades(found, ("error",))},
        labels=cases,
    )


def drifts(contents: Contents, label: str) -> ChartData | None:
    """Curves over time of every finding that has one, chosen by check and quantity."""
    curves = [
        (record, f)
        for record in contents.of(label)
        for f in record.findings
        if f.series is not None and f.series.t
    ]
    found = [point for record, finding in curves for point in _points(record, finding)]
    order = sorted(
        (WORST_FIRST.index(f.outcome), f.check != "energy", _choice(f)) for _, f in curves
    )
    choices = list(dict.fromkeys(choice for *_, choice in order))
    return _chart(
        "drifts", contents, [record for record, _ in curves], found, ("value", "bound"), choices
    )


def _points(record: Record, finding: Finding) -> Iterable[dict[str, Any]]:
    series = finding.series
    assert series is not None
    size = -(-len(series.t) // MOST_POINTS)
    for start in range(0, len(series.t), size):
        point = max(range(start, min(start + size, len(series.t))), key=series.value.__getitem__)
        yield {
            "what": _choice(finding),
            "series": f"{record.engine} {record.method}",
            "t": rounded(series.t[point], 4),
            "value": rounded(series.value[point]),
            "bound": rounded(series.bound[point]),
        }


def _choice(finding: Finding) -> str:
    return f"{finding.check}: {finding.quantity}"


def _chart(
    kind: str,
    contents: Contents,
    shown: Iterable[Record],
    found: list[dict[str, Any]],
    names: tuple[str, ...],
    choices: Sequence[str],
) -> ChartData | None:
    """The chart of these rows, None if there are none.

    Zeros go to the floor, as a log axis has no place for them.
    """
    if not found:
        return None
    ends = _decades(found, names)
    for item in found:
        item |= {f"shown_{name}": max(item[name], ends[0]) for name in names}
    marks = styles(((record.engine, record.method) for record in shown), engine_colours(contents))
    return ChartData(kind, _csv(found), tuple(choices), tuple(marks), {"error": ends})


def _decades(found: list[dict[str, Any]], names: tuple[str, ...]) -> tuple[float, float]:
    """Powers of ten below and above all positive values; zeros are drawn at the lower one."""
    values = [item[name] for item in found for name in names if item[name] > 0] or [1e-16]
    return 10.0 ** (math.floor(math.log10(min(values))) - 1), 10.0 ** math.ceil(
        math.log10(max(values))
    )


def _csv(found: list[dict[str, Any]]) -> str:
    """Rows as CSV with a header."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(found[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(found)
    return out.getvalue()
