"""A page of numerical stability, from tables and points that a stress test hands over."""

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
    "largest value over its bound, point by point; above 1 a point fails, x: no run, ?: undecided"
)


@dataclass(frozen=True)
class Mark:
    """One point of one method: sweep, number and name of the point, value over bound (None: no
    run), and its verdict.
    """

    sweep: str
    along: str
    index: int
    point: str
    engine: str
    method: str
    is_reference: bool
    ratio: float | None
    verdict: str


@dataclass(frozen=True)
class Section:
    """The results of one battery: its question, its points, and tables for people."""

    id: str
    title: str
    question: str
    marks: Sequence[Mark]
    tables: Sequence[Cells]


def chart(section: Section) -> ChartData | None:
    """The marks as the chart `sweeps` takes them; None without any."""
    shown = [
        mark for mark in section.marks if mark.verdict in ("pass", "fail", "error", "undecided")
    ]
    if not shown:
        return None
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    sweeps = tuple(dict.fromkeys(_name(mark) for mark in shown))
    writer.writerow(("sweep", "point", "series", "ratio", "shown", "verdict"))
    for mark in shown:
        height = HIGH
        label: float | str = ""
        if mark.ratio is not None:
            label = rounded(mark.ratio)
            if math.isfinite(mark.ratio):
                height = min(max(mark.ratio, LOW), HIGH)
        # A point without a run is an error, unless it says itself that it is undecided.
        has_verdict = mark.ratio is not None or mark.verdict == "undecided"
        if has_verdict:
            verdict = mark.verdict
        else:
            verdict = "error"
        sweep = sweeps.index(_name(mark))
        series = f"{mark.engine} {mark.method}"
        writer.writerow((sweep, mark.point, series, label, rounded(height), verdict))
    return ChartData(
        "sweeps",
        out.getvalue(),
        sweeps,
        tuple(_styles(shown)),
        {"error": (LOW, HIGH)},
        labels=_points(shown),
    )


def _name(mark: Mark) -> str:
    return f"{mark.sweep}\n{mark.along}"


def _points(marks: Sequence[Mark]) -> tuple[str, ...]:
    """`sweep<tab>point` of every point, in order."""
    points = {(_name(mark), mark.index, mark.point) for mark in marks}
    in_order = sorted(points, key=lambda point: (point[0], point[1]))
    return tuple(f"{sweep}\t{point}" for sweep, _, point in in_order)


def _styles(marks: Sequence[Mark]) -> list[tuple[str, str, str]]:
    """(series, colour, shape): a colour an engine, a shape a method."""
    methods: dict[str, list[str]] = {}
    colours: dict[str, str] = {}
    for mark in marks:
        others = sum(colour != REFERENCE for colour in colours.values())
        if mark.is_reference:
            colour = REFERENCE
        else:
            colour = ENGINES[others % len(ENGINES)]
        colours.setdefault(mark.engine, colour)
        mine = methods.setdefault(mark.engine, [])
        if mark.method not in mine:
            mine.append(mark.method)
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
        if pictures and section.marks:
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
