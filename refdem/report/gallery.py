"""The gallery: figures in a page that needs no network, and in Markdown with a picture each."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from markupsafe import Markup

from refdem.core.figure import Figure, file_name
from refdem.core.outside import markdown_text
from refdem.core.store import Store
from refdem.report import figures
from refdem.report.files import removed, written
from refdem.report.html import environment
from refdem.report.markdown import table
from refdem.report.numbers import significant
from refdem.report.panels import specification

INTRODUCTION = (
    "The computed figures of the source chapter, drawn from runs of the reference, and what was"
    " measured beside a benchmark or shown by other engines; `refdem gallery` makes them."
)
SECTION = re.compile(r'<section id="fig-[^"]*">\n<h2>Figure ([^:<]+):.*?</section>\n', re.DOTALL)
"""A figure in the page."""
CHAPTER = re.compile(r"^## Figure ([^:]+):.*?(?=^## Figure |\Z)", re.DOTALL | re.MULTILINE)
"""A figure in the Markdown."""


def write_figures(
    folder: Path,
    drawn: Sequence[Figure],
    *,
    version: str,
    store: Store | None,
    every: Sequence[str] = (),
) -> None:
    """Writes gallery.html, gallery.md, `fig-….svg` and what the page needs.

    Figures that the folder already holds are kept if their ids are in `every`, which gives the
    order of the page. Pictures of all other figures are removed.
    """
    specs = {
        figure.id: json.dumps(specification(figure), separators=(",", ":"), sort_keys=True)
        for figure in drawn
    }
    drawing = environment().get_template("figure.html")
    drawings = {
        figure.id: drawing.render(figure=figure, spec=specs[figure.id]).strip() + "\n"
        for figure in drawn
    }
    order = list(every or specs)
    shown = merged(order, earlier(folder / "gallery.html", SECTION), drawings)
    described = merged(
        order,
        earlier(folder / "gallery.md", CHAPTER),
        {figure.id: chapter(figure) for figure in drawn},
    )
    for path in sorted(folder.glob("fig-*.svg")):
        if path.stem not in map(file_name, order):
            removed(path)
    for figure in drawn:
        written(folder / f"{figure.name}.svg", figures.picture(specs[figure.id], store))
    figures.equip(folder, store)
    written(
        folder / "gallery.md", "\n".join(["# Gallery\n", INTRODUCTION + "\n", *described.values()])
    )
    named = {id: file_name(id) for id in shown}
    sections = map(Markup, shown.values())
    sheet = environment().get_template("gallery.html")
    text = sheet.render(root="", named=named, sections=sections, version=version)
    written(folder / "gallery.html", text)


def earlier(path: Path, part: re.Pattern[str]) -> dict[str, str]:
    """Figures by id that an earlier gallery file contains; none if there is no such file."""
    if path.is_file():
        text = path.read_text("utf-8", "replace")
    else:
        text = ""
    return {section[1]: section[0].rstrip("\n") + "\n" for section in part.finditer(text)}


def merged(
    order: Sequence[str], before: Mapping[str, str], new: Mapping[str, str]
) -> dict[str, str]:
    """The figures in order: new ones where they were made, else those of the earlier gallery."""
    return {id: new.get(id) or before[id] for id in order if id in new or id in before}


def chapter(figure: Figure) -> str:
    """The section of a figure in Markdown: picture, caption, numbers measured in it, commands."""
    title = markdown_text(figure.title)
    parts = [
        f"## Figure {figure.id}: {title}",
        f"![Figure {figure.id}: {title}]({figure.name}.svg)",
        markdown_text(figure.caption),
    ]
    if figure.numbers:
        lines = [
            [markdown_text(what), significant(value, figure.digits_of(what))]
            for what, value in figure.numbers.items()
        ]
        parts.append(table(["measured in it", "value"], lines))
    parts.append("```\n" + "\n".join(figure.commands) + "\n```")
    return "\n\n".join(parts) + "\n"
