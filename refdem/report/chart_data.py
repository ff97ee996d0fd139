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
    points: list[dict[str, Any]] = []
    for row in rows:
        for level in row.levels:
            point = {
                "series": row.series,
                "quantity": row.quantity,
                "control": row.control,
                "level": rounded(level.level, 4),
                "error": rounded(level.error),
                "bound": rounded(level.bound),
            }
            points.append(point)
    records = [row.record for row in rows]
    chart = _chart("errors", contents, records, points, ("error", "bound"), _quantities(rows))
    for control in ("step", "tolerance", "exact"):
        chosen = [float(item["level"]) for item in points if item["control"] == control]
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
    points: list[dict[str, Any]] = []
    for row in rows:
        for level in row.levels:
            if level.seconds <= 0:
                continue
            point = {
                "series": row.series,
                "quantity": row.quantity,
                "seconds": rounded(level.seconds),
                "error": rounded(level.error),
            }
            points.append(point)
    records = [row.record for row in rows]
    chart = _chart("costs", contents, records, points, ("error",), _quantities(rows))
    if chart:
        chart.extents["seconds"] = _ends([float(item["seconds"]) for item in points])
    return chart


def _quantities(rows: Sequence[Row]) -> list[str]:
    return [WORST, *sorted({row.quantity for row in rows} - {WORST})]


def overview(contents: Contents, rows: Sequence[Row]) -> ChartData | None:
    """Error against step in units of the first step, every instance a small picture, every engine a
    colour.
    """
    points: list[dict[str, Any]] = []
    for row in worst_rows(rows):
        if row.control != "step":
            continue
        first_step = row.levels[0].level
        for level in row.levels:
            if level.error <= 0:
                continue
            halvings = math.log2(first_step / level.level)
            point = {
                "case": row.record.label,
                "engine": row.record.engine,
                "series": row.series,
                "halvings": rounded(halvings, 3),
                "error": rounded(level.error),
            }
            points.append(point)
    if not points:
        return None
    colours = engine_colours(contents)
    engines = sorted({item["engine"] for item in points}, key=list(colours).index)
    cases = tuple(sorted({item["case"] for item in points}))
    marks = tuple((name, colours[name], "circle") for name in engines)
    return ChartData(
        "overview",
        _csv(points),
        styles=marks,
        extents={"error": _decades(points, ("error",))},
        labels=cases,
    )


def drifts(contents: Contents, label: str) -> ChartData | None:
    """Curves over time of every finding that has one, chosen by check and quantity."""
    records: list[Record] = []
    order: list[tuple[int, bool, str]] = []
    rows: list[dict[str, Any]] = []
    for record in contents.of(label):
        for finding in record.findings:
            if finding.series is None or not finding.series.t:
                continue
            records.append(record)
            rows.extend(_points(record, finding))
            # The worst outcome first; the check of energy before others of the same outcome.
            rank = WORST_FIRST.index(finding.outcome)
            order.append((rank, finding.check != "energy", _choice(finding)))
    choices = list(dict.fromkeys(choice for *_, choice in sorted(order)))
    return _chart("drifts", contents, records, rows, ("value", "bound"), choices)


def _points(record: Record, finding: Finding) -> Iterable[dict[str, Any]]:
    """Rows of the curve of a finding: of each stretch of time the sample of the largest value."""
    series = finding.series
    assert series is not None
    # The number of samples of a stretch, rounded up.
    size = -(-len(series.t) // MOST_POINTS)
    for start in range(0, len(series.t), size):
        end = min(start + size, len(series.t))
        point = max(range(start, end), key=series.value.__getitem__)
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
    rows: list[dict[str, Any]],
    names: tuple[str, ...],
    choices: Sequence[str],
) -> ChartData | None:
    """The chart of these rows, None if there are none.

    Zeros go to the floor, as a log axis has no place for them.
    """
    if not rows:
        return None
    ends = _decades(rows, names)
    for item in rows:
        item |= {f"shown_{name}": max(item[name], ends[0]) for name in names}
    marks = styles(((record.engine, record.method) for record in shown), engine_colours(contents))
    return ChartData(kind, _csv(rows), tuple(choices), tuple(marks), {"error": ends})


def _decades(rows: list[dict[str, Any]], names: tuple[str, ...]) -> tuple[float, float]:
    """Powers of ten below and above all positive values; zeros are drawn at the lower one."""
    values: list[float] = []
    for item in rows:
        values += [item[name] for name in names if item[name] > 0]
    if not values:
        values = [1e-16]
    lowest = math.floor(math.log10(min(values))) - 1
    highest = math.ceil(math.log10(max(values)))
    return 10.0**lowest, 10.0**highest


def _csv(rows: list[dict[str, Any]]) -> str:
    """The rows as CSV with a header; all have the columns of the first, in the same order."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows(item.values() for item in rows)
    return out.getvalue()
