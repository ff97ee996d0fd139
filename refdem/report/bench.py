"""A page of run time against error, from rows and tables that a bench hands over."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from refdem.report.chart_data import FLOOR, ChartData
from refdem.report.figures import equip, picture, specification
from refdem.report.files import written
from refdem.report.html import environment
from refdem.report.markdown import Cells, titled_table
from refdem.report.numbers import rounded
from refdem.report.palette import ENGINES, REFERENCE, SHAPES


@dataclass(frozen=True)
class Section:
    """One instance: points (engine, method, is it the reference, seconds, error) and tables."""

    label: str
    points: Sequence[tuple[str, str, bool, float, float]]
    tables: Sequence[Cells]


def chart(section: Section) -> ChartData | None:
    """The points as the chart `costs` takes them; None without points."""
    if not section.points:
        return None
    positive = [error for *_, error in section.points if error > 0] or [1e-16]
    # The power of ten below the smallest positive error: errors of 0 are drawn there.
    digits = len(str(int(1 / min(positive))))
    floor = max(10.0 ** (digits * -1), FLOOR)
    seconds = [point[3] for point in section.points]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("series", "quantity", "seconds", "error", "shown_error"))
    for engine, method, _, time, error in section.points:
        series = f"{engine} {method}"
        drawn_error = max(error, floor)
        writer.writerow((series, "largest", rounded(time), rounded(error), rounded(drawn_error)))
    largest = max(1e-1, max(positive))
    ends = {
        "error": (floor, 10.0 * largest),
        "seconds": (min(seconds) / 1.5, max(seconds) * 1.5),
    }
    return ChartData("costs", out.getvalue(), ("largest",), tuple(_styles(section)), ends)


def _styles(section: Section) -> list[tuple[str, str, str]]:
    """(series, colour, shape): a colour an engine, a shape a method."""
    methods: dict[str, list[str]] = {}
    colours: dict[str, str] = {}
    for engine, method, is_reference, *_ in section.points:
        others = sum(colour != REFERENCE for colour in colours.values())
        if is_reference:
            colour = REFERENCE
        else:
            colour = ENGINES[others % len(ENGINES)]
        colours.setdefault(engine, colour)
        if method not in methods.setdefault(engine, []):
            methods[engine].append(method)
    styles = []
    for engine, mine in methods.items():
        for number, method in enumerate(mine):
            shape = SHAPES[number % len(SHAPES)]
            styles.append((f"{engine} {method}", colours[engine], shape))
    return styles


def markdown(
    title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section], pictures: str = ""
) -> str:
    """The report as Markdown; `pictures` is the folder of its SVG figures, none if empty."""
    parts = [f"# {title}", words, *map(titled_table, tables)]
    for number, section in enumerate(sections, 1):
        parts.append(f"## {section.label}")
        if pictures and section.points:
            parts.append(f"![error against seconds]({pictures}/bench-{number}.svg)")
        parts += map(titled_table, section.tables)
    return "\n\n".join(parts) + "\n"


def page(title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section]) -> str:
    """The report as HTML with interactive charts, in the frame of every page."""
    drawn: list[str | None] = []
    for section in sections:
        data = chart(section)
        if data is None:
            drawn.append(None)
        else:
            drawn.append(specification(data))
    sheet = environment().get_template("bench.html")
    return sheet.render(
        root="",
        name="bench",
        title=title,
        words=words,
        tables=tables,
        sections=sections,
        specs=drawn,
    )


def write(
    folder: Path, title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section]
) -> None:
    """Writes bench.md, bench.html, bench-N.svg and what the page needs into a folder."""
    written(folder / "bench.md", markdown(title, words, tables, sections, "."))
    written(folder / "bench.html", page(title, words, tables, sections))
    equip(folder, None)
    for number, section in enumerate(sections, 1):
        data = chart(section)
        if data is not None:
            drawing = picture(specification(data), None)
            written(folder / f"bench-{number}.svg", drawing)
