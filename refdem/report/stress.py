"""A page of numerical stability, from tables and rungs that a stress test hands over."""

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from refdem.core.outside import markdown_text
from refdem.core.store import Store
from refdem.report.chart_data import ChartData
from refdem.report.figures import equip, picture, specification
from refdem.report.files import written
from refdem.report.html import environment
from refdem.report.markdown import Cells, titled_table
from refdem.report.numbers import rounded
from refdem.report.palette import ENGINES, REFERENCE, SHAPES

LOW = 1e-4
"""Least ratio of error to bound that is drawn; what is below stands at the edge."""
HIGH = 1e4
"""Values over their bounds are drawn between these; what is beyond lies on the edge."""
CAPTION = (
    "largest value over its bound, rung by rung; above 1 a rung fails, x: no run, ?: undecided"
)


@dataclass(frozen=True)
class Point:
    """One rung of one method: ladder, number and name of the rung, value over bound (None: no run),
    and its verdict.
    """

    ladder: str
    along: str
    index: int
    rung: str
    engine: str
    method: str
    is_reference: bool
    ratio: float | None
    verdict: str


@dataclass(frozen=True)
class Section:
    """The results of one battery: its question, its rungs, and tables for people."""

    id: str
    title: str
    question: str
    points: Sequence[Point]
    tables: Sequence[Cells]


def chart(section: Section) -> ChartData | None:
    """The points as the chart `ladders` takes them; None without any."""
    shown = [
        point for point in section.points if point.verdict in ("pass", "fail", "error", "undecided")
    ]
    if not shown:
        return None
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    ladders = tuple(dict.fromkeys(_name(point) for point in shown))
    writer.writerow(("ladder", "rung", "series", "ratio", "shown", "verdict"))
    for point in shown:
        height = HIGH
        label: float | str = ""
        if point.ratio is not None:
            label = rounded(point.ratio)
            if math.isfinite(point.ratio):
                height = min(max(point.ratio, LOW), HIGH)
        # A rung without a run is an error, unless it says itself that it is undecided.
        has_verdict = point.ratio is not None or point.verdict == "undecided"
        if has_verdict:
            mark = point.verdict
        else:
            mark = "error"
        ladder = ladders.index(_name(point))
        series = f"{point.engine} {point.method}"
        writer.writerow((ladder, point.rung, series, label, rounded(height), mark))
    return ChartData(
        "ladders",
        out.getvalue(),
        ladders,
        tuple(_styles(shown)),
        {"error": (LOW, HIGH)},
        labels=_rungs(shown),
    )


def _name(point: Point) -> str:
    return f"{point.ladder}\n{point.along}"


def _rungs(points: Sequence[Point]) -> tuple[str, ...]:
    """`ladder<tab>rung` of every rung, in order."""
    rungs = {(_name(point), point.index, point.rung) for point in points}
    in_order = sorted(rungs, key=lambda rung: (rung[0], rung[1]))
    return tuple(f"{ladder}\t{rung}" for ladder, _, rung in in_order)


def _styles(points: Sequence[Point]) -> list[tuple[str, str, str]]:
    """(series, colour, shape): a colour an engine, a shape a method."""
    methods: dict[str, list[str]] = {}
    colours: dict[str, str] = {}
    for point in points:
        others = sum(colour != REFERENCE for colour in colours.values())
        if point.is_reference:
            colour = REFERENCE
        else:
            colour = ENGINES[others % len(ENGINES)]
        colours.setdefault(point.engine, colour)
        mine = methods.setdefault(point.engine, [])
        if point.method not in mine:
            mine.append(point.method)
    styles = []
    for engine, mine in methods.items():
        for number, method in enumerate(mine):
            shape = SHAPES[number % len(SHAPES)]
            styles.append((f"{engine} {method}", colours[engine], shape))
    return styles


def markdown(
    title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section], pictures: str
) -> str:
    """The report as Markdown; `pictures` is the folder of its figures, none if empty."""
    parts = [f"# {title}", words, *map(titled_table, tables)]
    for section in sections:
        parts += [f"## {section.title}", markdown_text(section.question)]
        if pictures and section.points:
            parts.append(f"![{CAPTION}]({pictures}/stress-{section.id}.svg)")
        parts += map(titled_table, section.tables)
    return "\n\n".join(parts) + "\n"


def page(
    title: str,
    words: str,
    tables: Sequence[Cells],
    sections: Sequence[Section],
    drawn: Sequence[str | None],
) -> str:
    """The report as HTML with interactive charts, one specification a section, in the frame of
    every page.
    """
    sheet = environment().get_template("stress.html")
    return sheet.render(
        root="",
        title=title,
        words=words,
        tables=tables,
        sections=sections,
        specs=drawn,
        caption=CAPTION,
    )


def write(
    folder: Path,
    title: str,
    words: str,
    tables: Sequence[Cells],
    sections: Sequence[Section],
    store: Store | None = None,
) -> None:
    """Writes stress.md, stress.html, figures/stress-BATTERY.svg and what the page needs into a
    folder.
    """
    drawn: list[str | None] = []
    for section in sections:
        data = chart(section)
        if data is None:
            drawn.append(None)
        else:
            drawn.append(specification(data))
    for section, spec in zip(sections, drawn, strict=True):
        if spec is not None:
            written(folder / "figures" / f"stress-{section.id}.svg", picture(spec, store))
    written(folder / "stress.md", markdown(title, words, tables, sections, "figures"))
    written(folder / "stress.html", page(title, words, tables, sections, drawn))
    equip(folder, store)
