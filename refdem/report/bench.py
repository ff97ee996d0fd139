"""A page of run time against error, from rows and tables that a bench hands over."""

import csv
import html
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from refdem.report.chart_data import ChartData
from refdem.report.figures import picture, script, specification
from refdem.report.html import script_json
from refdem.report.numbers import rounded
from refdem.report.palette import ENGINES, REFERENCE, SHAPES

Cells = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""A title, a header, and rows."""

STYLE = (
    "body{font-family:system-ui,sans-serif;margin:2rem auto;max-width:75rem;padding:0 1rem;color-scheme:light dark}"
    "table{border-collapse:collapse;font-size:.85rem}td,th{border:1px solid #8888;padding:.25rem .5rem;text-align:left}div{overflow-x:auto}"
)
LOADER = "for (const e of document.querySelectorAll('script[data-chart]')) vegaEmbed('#' + e.dataset.chart, JSON.parse(e.textContent));"


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
    floor = 10.0 ** (len(str(int(1 / min(positive)))) * -1)
    seconds = [point[3] for point in section.points]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("series", "quantity", "seconds", "error", "shown_error"))
    for engine, method, _, time, error in section.points:
        writer.writerow((f"{engine} {method}", "largest", rounded(time), rounded(error), rounded(max(error, floor))))
    ends = {"error": (floor, 10.0 * max(1e-1, max(positive))), "seconds": (min(seconds) / 1.5, max(seconds) * 1.5)}
    return ChartData("costs", out.getvalue(), ("largest",), tuple(_styles(section)), ends)


def _styles(section: Section) -> list[tuple[str, str, str]]:
    """(series, colour, shape): a colour an engine, a shape a method."""
    methods: dict[str, list[str]] = {}
    colours: dict[str, str] = {}
    for engine, method, reference, *_ in section.points:
        others = sum(colour != REFERENCE for colour in colours.values())
        colours.setdefault(engine, REFERENCE if reference else ENGINES[others % len(ENGINES)])
        if method not in methods.setdefault(engine, []):
            methods[engine].append(method)
    return [(f"{e} {m}", colours[e], SHAPES[k % len(SHAPES)]) for e, mine in methods.items() for k, m in enumerate(mine)]


def markdown(title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section], pictures: str = "") -> str:
    """The report as Markdown; `pictures` is the folder of its SVG figures, none if empty."""
    parts = [f"# {title}", words, *map(_markdown, tables)]
    for number, section in enumerate(sections, 1):
        parts.append(f"## {section.label}")
        if pictures and section.points:
            parts.append(f"![error against seconds]({pictures}/bench-{number}.svg)")
        parts += map(_markdown, section.tables)
    return "\n\n".join(parts) + "\n"


def _markdown(table: Cells) -> str:
    title, header, rows = table
    lines = [list(header), ["---"] * len(header), *rows]
    return f"{title}:\n\n" + "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in lines)


def page(title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section], *, source: str) -> str:
    """The report as HTML with interactive charts; `source` is the address of the script that draws them."""
    parts = [f"<h1>{html.escape(title)}</h1><p>{html.escape(words)}</p>", *map(_html, tables)]
    for number, section in enumerate(sections, 1):
        parts.append(f"<h2>{html.escape(section.label)}</h2>")
        if (data := chart(section)) is not None:
            spec = script_json(specification(data, None))
            parts.append(f'<div id="chart-{number}"></div><script type="application/json" data-chart="chart-{number}">{spec}</script>')
        parts += map(_html, section.tables)
    head = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title><style>{STYLE}</style>'
    return f'{head}\n{"".join(parts)}\n<script src="{html.escape(source)}"></script><script>{LOADER}</script></html>\n'


def _html(table: Cells) -> str:
    title, header, rows = table
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<h3>{html.escape(title)}</h3><div><table><tr>{head}</tr>{body}</table></div>"


def write(folder: Path, title: str, words: str, tables: Sequence[Cells], sections: Sequence[Section]) -> None:
    """Writes bench.md, bench.html, bench-N.svg and the script of the charts into a folder."""
    (folder / "bench.md").write_text(markdown(title, words, tables, sections, "."))
    (folder / "bench.html").write_text(page(title, words, tables, sections, source="vega.js"))
    (folder / "vega.js").write_bytes(script(None))
    for number, section in enumerate(sections, 1):
        if (data := chart(section)) is not None:
            (folder / f"bench-{number}.svg").write_bytes(picture(specification(data, None), None))
