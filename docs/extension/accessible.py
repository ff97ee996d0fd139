"""What every page of the site needs beyond its theme: parts that a keyboard reaches, landmarks and
headings with names, and the texts from which the search shows an excerpt beside each hit.
"""

import json
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

REPLACED = (
    # The captions of the navigation are headings, whose level a reader aloud has to know.
    ('<p class="caption" role="heading">', '<p class="caption" role="heading" aria-level="2">'),
    # Code and tables that are wider than the page scroll, also by the keys of arrows.
    ("<pre>", '<pre tabindex="0">'),
    (
        '<div class="table-wrapper',
        '<div tabindex="0" role="group" aria-label="Table" class="table-wrapper',
    ),
    (
        '<div class="math-wrapper',
        '<div tabindex="0" role="group" aria-label="Equation" class="math-wrapper',
    ),
    ('<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="Pages">'),
    ('<aside class="toc-drawer', '<aside aria-label="On this page" class="toc-drawer'),
)
"""What the theme writes, and what stands in its place; nothing is replaced twice."""

TEXTS = "texts.js"
"""The file with the texts: a script, as a browser fetches nothing for a page from disk."""


def mended(page: str) -> str:
    """A page with all replacements."""
    for written, instead in REPLACED:
        page = page.replace(written, instead)
    return page


def with_names(app: Sphinx, failure: Exception | None) -> None:
    """Mends every page that was written."""
    if failure is not None or app.builder.format != "html":
        return
    for path in sorted(Path(app.outdir).rglob("*.html")):
        page = path.read_text("utf-8")
        better = mended(page)
        if better != page:
            path.write_text(better, "utf-8")


def with_texts(app: Sphinx, failure: Exception | None) -> None:
    """Writes the text of each page, by its name, for the page of the search."""
    if failure is not None or app.builder.format != "html":
        return
    texts = {
        name: " ".join(app.env.get_doctree(name).astext().split())
        for name in sorted(app.env.found_docs)
    }
    said = json.dumps(texts, ensure_ascii=False, separators=(",", ":"))
    path = Path(app.outdir) / "_static" / TEXTS
    path.write_text(f"window.refdemTexts = {said};\n", "utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Connects both to the end of a build."""
    app.connect("build-finished", with_names)
    app.connect("build-finished", with_texts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
