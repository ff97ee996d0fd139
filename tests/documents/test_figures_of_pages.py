"""Committed figures are those that a committed page shows; `make validate` makes the others."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
FIGURES = {".svg", ".png", ".jpg", ".jpeg", ".gif", ".webp"}
SHOWN = re.compile(
    r"!\[(?:\\.|[^\\\]\n])*\]\((?!https?:)([^)\s]+)\)"  # Markdown: text in brackets, then the place
    r"|<img\s[^>]*src=\"(?!https?:)([^\"]+)\""
)
"""An image of Markdown or HTML in this repository: its place, relative to the page."""


def committed() -> list[Path]:
    """Every file of the repository."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return [ROOT / name for name in listed.stdout.split("\0") if name]


def shown_by(page: Path) -> set[Path]:
    """The figures that a page shows."""
    places = [markdown or html for markdown, html in SHOWN.findall(page.read_text())]
    return {(page.parent / place).resolve() for place in places}


def test_every_committed_figure_is_shown_by_a_committed_page_and_every_shown_one_is_committed():
    files = committed()
    figures = {path.resolve() for path in files if path.suffix in FIGURES}
    pages = [path for path in files if path.suffix == ".md"]
    shown = set().union(*map(shown_by, pages))
    assert sorted(figures - shown) == [], "no page shows them: leave them to .gitignore"
    assert sorted(shown - figures) == [], "pages show them, and they are not committed"
    # README and the first page of the site show one each.
    assert ROOT / "reports" / "figures" / "tolerance.svg" in shown
    assert ROOT / "reports" / "figures" / "pendulum.svg" in shown


def test_an_image_is_found_in_markdown_and_in_html(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "![a \\[b\\], c](figures/a.svg)\n"
        '<img alt="d" src="../d.png">\n'
        "![badge](https://example.org/badge.svg) and [a link](figures/e.svg)\n"
    )
    assert shown_by(page) == {
        (tmp_path / "figures" / "a.svg").resolve(),
        (tmp_path.parent / "d.png").resolve(),
    }
