"""The gallery: figures in a page that needs no network, and in Markdown with a picture each."""

import json
from collections.abc import Sequence
from pathlib import Path

from refdem.core.figure import Figure
from refdem.core.store import Store
from refdem.report import figures
from refdem.report.files import removed, written
from refdem.report.html import environment
from refdem.report.markdown import plain, table
from refdem.report.numbers import two
from refdem.report.panels import specification


def write_figures(folder: Path, drawn: Sequence[Figure], *, version: str, store: Store | None) -> None:
    """Writes gallery.html, gallery.md, `fig-….svg` and what the page needs; pictures of figures that are gone are removed."""
    specs = {figure.id: json.dumps(specification(figure), separators=(",", ":"), sort_keys=True) for figure in drawn}
    names = {f"{figure.name}.svg" for figure in drawn}
    for path in sorted(folder.glob("fig-*.svg")):
        if path.name not in names:
            removed(path)
    for figure in drawn:
        written(folder / f"{figure.name}.svg", figures.picture(specs[figure.id], store))
    figures.equip(folder, store)
    written(folder / "gallery.md", markdown(drawn))
    page = environment().get_template("gallery.html")
    written(folder / "gallery.html", page.render(root="", figures=drawn, specs=specs, version=version))


def markdown(drawn: Sequence[Figure]) -> str:
    """The gallery as Markdown."""
    parts = ["# Gallery", "The computed figures of the source chapter, drawn from runs of the reference; `refdem gallery` makes them."]
    for figure in drawn:
        parts += [
            f"## Figure {figure.id}: {plain(figure.title)}",
            f"![Figure {figure.id}: {plain(figure.title)}]({figure.name}.svg)",
            plain(figure.caption),
            *([table(["measured in it", "value"], [[plain(k), two(v)] for k, v in figure.numbers.items()])] if figure.numbers else []),
            "```\n" + "\n".join(figure.commands) + "\n```",
        ]
    return "\n\n".join(parts) + "\n"
