"""What charts show, as plain rows with two significant digits, taken from findings."""

import csv
import io
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from refdem.core.finding import WORST_FIRST, Finding, Level, Record
from refdem.report.contents import Contents
from refdem.report.numbers import rounded
from refdem.report.palette import engine_colours, styles
from refdem.report.tolerance import WORST, Row, worst_rows

MOST_POINTS = 64
"""Largest number of points of a curve in a chart. A longer curve is divided into as many intervals,
and the largest value of each is kept.
"""

FLOOR = 1e-17
"""The smallest relative error that a chart distinguishes from zero, below binary64 round-off."""
DECADES = 17
"""Decades that an axis of values with a unit has at most, for the same reason."""
SAME_LINE = 0.01
"""Two curves coincide if at every common point they differ by at most this fraction of the axis,
which is three pixels.
"""
ROOM_FOR_DEFAULT = 10.0
"""A default step is marked if it is within this factor of the range of the steps that ran."""


@dataclass(frozen=True)
class ChartData:
    """Input of one chart: its kind, rows as CSV, choices of its selector, styles, and what else its
    definition reads.

    `defaults` are engines, each with its colour and its default step [s]. `axes` are the two
    parameters of heat maps, each with its values.
    """

    kind: str
    csv: str
    choices: tuple[str, ...] = ()
    styles: tuple[tuple[str, str, str], ...] = ()
    extents: dict[str, tuple[float, float]] = field(default_factory=dict)
    labels: tuple[str, ...] = ()
    defaults: tuple[tuple[str, str, float], ...] = ()
    axes: tuple[tuple[str, tuple[str, ...]], ...] = ()


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
    chart = _chart(
        "errors",
        contents,
        records,
        points,
        ("error", "bound"),
        _quantities(rows),
        curve=("quantity", "control"),
        x="level",
    )
    if chart is None:
        return None
    for control in ("step", "tolerance", "exact"):
        chosen = [float(item["level"]) for item in points if item["control"] == control]
        if chosen:
            chart.extents[control] = _ends(chosen)
    if "step" not in chart.extents:
        return chart
    defaults = _defaults(contents, rows, chart.extents["step"])
    steps = [step for _, _, step in defaults]
    chart.extents["step"] = _ends([*chart.extents["step"], *steps])
    return replace(chart, defaults=defaults)


def _defaults(
    contents: Contents, rows: Sequence[Row], ends: tuple[float, float]
) -> tuple[tuple[str, str, float], ...]:
    """(engine, colour, step [s]) of the engines among the rows that have a default step which is
    not far out of the steps that ran.
    """
    shown = {row.record.engine for row in rows if row.control == "step"}
    colours = engine_colours(contents)
    least = ends[0] / ROOM_FOR_DEFAULT
    most = ends[1] * ROOM_FOR_DEFAULT
    found = []
    for sheet in contents.engines:
        step = sheet.default_step
        if sheet.engine in shown and step is not None and least <= step <= most:
            found.append((sheet.engine, colours[sheet.engine], step))
    return tuple(found)


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
    """Error against seconds of one instance; only for pages that are not committed.

    A campaign measures each level once. A coarser level needs less work than a finer one of the
    same method. If it took longer all the same, other load on the machine disturbed the measurement
    and it is left out.
    """
    points: list[dict[str, Any]] = []
    for row in rows:
        for level in undisturbed(row.levels):
            point = {
                "series": row.series,
                "quantity": row.quantity,
                "seconds": rounded(level.seconds),
                "error": rounded(level.error),
            }
            points.append(point)
    records = [row.record for row in rows]
    chart = _chart(
        "costs",
        contents,
        records,
        points,
        ("error",),
        _quantities(rows),
        curve=("quantity",),
        x="seconds",
    )
    if chart:
        chart.extents["seconds"] = _ends([float(item["seconds"]) for item in points])
    return chart


def undisturbed(levels: Sequence[Level]) -> list[Level]:
    """The levels, from coarse to fine, that took some time and no longer than any finer one."""
    kept: list[Level] = []
    shortest = math.inf
    for level in reversed(levels):
        if 0 < level.seconds <= shortest:
            shortest = level.seconds
            kept.append(level)
    return kept[::-1]


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
    ends = _decades(points, ("error",))
    for item in points:
        item["shown_error"] = max(item["error"], ends[0])
    _count_curves_above(points, ("case",), "halvings", "shown_error", ends)
    colours = engine_colours(contents)
    engines = sorted({item["engine"] for item in points}, key=list(colours).index)
    cases = tuple(sorted({item["case"] for item in points}))
    marks = tuple((name, colours[name], "circle") for name in engines)
    return ChartData(
        "overview",
        _csv(points),
        styles=marks,
        extents={"error": ends},
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
    return _chart(
        "drifts",
        contents,
        records,
        rows,
        ("value", "bound"),
        choices,
        curve=("what",),
        x="t",
    )


def _points(record: Record, finding: Finding) -> Iterable[dict[str, Any]]:
    """Rows of the curve of a finding: the sample of largest value in each interval of time."""
    series = finding.series
    assert series is not None
    # The number of samples of an interval, rounded up.
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
    *,
    curve: tuple[str, ...],
    x: str,
) -> ChartData | None:
    """The chart of these rows, None if there are none.

    Zeros are drawn at the floor of the logarithmic axis. `names` are the columns on the vertical
    axis, the first of them as curves against `x`. A curve is identified by its series and the
    columns `curve`.
    """
    if not rows:
        return None
    if kind == "drifts":
        ends = _decades(rows, names, has_unit=True)
    else:
        ends = _decades(rows, names)
    for item in rows:
        item |= {f"shown_{name}": max(item[name], ends[0]) for name in names}
    _count_curves_above(rows, curve, x, f"shown_{names[0]}", ends)
    marks = styles(((record.engine, record.method) for record in shown), engine_colours(contents))
    return ChartData(kind, _csv(rows), tuple(choices), tuple(marks), {"error": ends})


def _count_curves_above(
    rows: list[dict[str, Any]],
    curve: tuple[str, ...],
    x: str,
    y: str,
    ends: tuple[float, float],
) -> None:
    """Adds to each row, as `under`, the number of later curves that coincide with its own.

    Charts draw a curve wider the more curves are drawn on top of it, so that all remain visible.
    """
    apart = SAME_LINE * math.log(ends[1] / ends[0])
    pictures: dict[tuple[Any, ...], dict[str, dict[float, float]]] = {}
    for item in rows:
        picture = pictures.setdefault(tuple(item[name] for name in curve), {})
        picture.setdefault(item["series"], {})[item[x]] = math.log(item[y])
    under: dict[tuple[tuple[Any, ...], str], int] = {}
    for key, curves in pictures.items():
        for one, other in itertools.combinations(curves, 2):
            if _lies_on(curves[one], curves[other], apart):
                under[(key, one)] = under.get((key, one), 0) + 1
    for item in rows:
        key = tuple(item[name] for name in curve)
        item["under"] = under.get((key, item["series"]), 0)


def _lies_on(one: dict[float, float], other: dict[float, float], apart: float) -> bool:
    """True if two curves, given as {x: y}, share some x and differ there by at most `apart`."""
    common = one.keys() & other.keys()
    return bool(common) and all(abs(one[x] - other[x]) <= apart for x in common)


def _decades(
    rows: list[dict[str, Any]], names: tuple[str, ...], *, has_unit: bool = False
) -> tuple[float, float]:
    """Powers of ten below and above all positive values; zeros are drawn at the lower one.

    It is at least the floor of relative errors, or for values with a unit as many decades below
    the upper one, as what lies deeper is round-off.
    """
    values: list[float] = []
    for item in rows:
        values += [item[name] for name in names if item[name] > 0]
    if not values:
        values = [1e-16]
    lowest = math.floor(math.log10(min(values))) - 1
    highest = math.ceil(math.log10(max(values)))
    if has_unit:
        deepest = highest - DECADES
    else:
        deepest = round(math.log10(FLOOR))
    lowest = max(lowest, deepest)
    return 10.0**lowest, 10.0 ** max(highest, lowest + 1)


def _csv(rows: list[dict[str, Any]]) -> str:
    """The rows as CSV with a header; all have the columns of the first, in the same order."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows(item.values() for item in rows)
    return out.getvalue()
