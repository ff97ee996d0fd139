"""The verification manual: a page a case in Markdown (committed) and in HTML (offline, in the
report's style), and a table of them all.
"""

from collections.abc import Sequence
from pathlib import Path

from refdem.core.manual import CheckLine, ManualPage, QuantityLine
from refdem.core.outside import markdown_text
from refdem.report.files import removed, written
from refdem.report.html import environment
from refdem.report.markdown import table
from refdem.report.mathml import equations
from refdem.report.numbers import two

CSS = Path(__file__).with_name("assets") / "report.css"
FEW = 24
"""Quantities that a page lists one by one; more are listed by name."""
NOBODY = "**nobody**: no witness"


def write_pages(folder: Path, pages: Sequence[ManualPage], *, version: str) -> None:
    """Writes manual/<case>.md and .html, manual/index of both kinds, and the style; pages of cases
    that are gone are removed.
    """
    home = Path(folder) / "manual"
    known = {
        f"{name}.{kind}"
        for name in ("index", *(page.case for page in pages))
        for kind in ("md", "html")
    }
    for path in sorted(home.glob("*")):
        if path.name not in known and path.suffix in (".md", ".html"):
            removed(path)
    templates = environment()
    templates.filters["prose"] = scale_of
    written(Path(folder) / "assets" / CSS.name, CSS.read_bytes())
    for index, page in enumerate(pages):
        written(home / f"{page.case}.md", markdown(page))
        beside = {
            "before": pages[index - 1] if index else None,
            "after": pages[index + 1] if index + 1 < len(pages) else None,
        }
        sheet = {
            "root": "../",
            "sheet": page,
            "version": version,
            "equations": equations(page.latex),
            "few": FEW,
        }
        text = templates.get_template("manual.html").render(sheet | beside)
        written(home / f"{page.case}.html", text)
    written(home / "index.md", index_markdown(pages))
    written(
        home / "index.html",
        templates.get_template("manual_index.html").render(
            root="../", pages=pages, version=version
        ),
    )


def markdown(page: ManualPage) -> str:
    """The page of one case as Markdown."""
    parts = [
        f"# {markdown_text(page.title)} (`{page.case}`)",
        markdown_text(page.statement),
        f"$$\n{page.latex}\n$$",
        f"Source: {markdown_text(page.source)}. Convention: {markdown_text(page.convention)}",
        f"It asks for {markdown_text(page.kind)}: {markdown_text(', '.join(page.features))}.",
        "## Parameters\n\nExact in truth; engines run them rounded to binary64.\n\n"
        + table(*parameters(page)),
        "## Quantities\n\n" + quantities(page.quantities),
        *(["## Scalars at the defaults\n\n" + scalars(page.scalars)] if page.scalars else []),
        "## Truth\n\n" + truth(page),
        "## Checks\n\nIn the methods of the reference; engines have more.\n\n"
        + checks(page.checks),
        *(["## Slips of the source\n\n" + "\n\n".join(slips(page))] if page.slips else []),
        "## Again\n\n```\n" + "\n".join(page.reproduce) + "\n```",
    ]
    return "\n\n".join(parts) + "\n"


def parameters(page: ManualPage) -> tuple[list[str], list[list[str]]]:
    """Head and lines of the table of parameters."""
    lines = [
        [
            f"`{p.name}`",
            markdown_text(p.default) or "(the case decides)",
            markdown_text(p.unit),
            markdown_text(p.bounds),
            markdown_text(p.doc),
        ]
        for p in page.parameters
    ]
    return ["parameter", "default", "unit", "bounds", "what"], lines


def quantities(found: Sequence[QuantityLine]) -> str:
    """A table, or a list of names where they are many."""
    if len(found) > FEW:
        return f"{len(found)} values: {', '.join(f'`{q.name}`' for q in found)}."
    return table(
        ["quantity", "unit", "size against which an error counts"],
        [[f"`{q.name}`", markdown_text(q.unit), two(q.scale)] for q in found],
    )


def scalars(found: Sequence[QuantityLine]) -> str:
    """A table, or the first of many."""
    if len(found) > FEW:
        more = f"\n\nand {len(found) - FEW} more"
    else:
        more = ""
    return (
        table(
            ["scalar", "value", "radius"], [[f"`{q.name}`", q.mid, q.radius] for q in found[:FEW]]
        )
        + more
    )


def truth(page: ManualPage) -> str:
    """How it is proved, who witnesses it, and what of it is certified."""
    t = page.truth
    if t.witnessed:
        said = (
            f" {t.witnessed} of the certified values were confirmed, to at least {t.agreed} digits."
        )
    else:
        said = ""
    if t.sets and t.digits is None:
        digits = "exactly"
    else:
        digits = f"to {t.digits} decimal places"
    if t.sets:
        kept = f"{t.values} values of {t.sets} parameter sets, all proved {digits}"
    else:
        kept = "none yet"
    lines = [
        f"- Method: {markdown_text(t.method)}.",
        (
            "- Witness when it is proved:"
            f" {markdown_text(t.witness) if t.witness != 'none' else 'none'}.{said}"
        ),
        (
            "- Witness in the tests:"
            f" {markdown_text(t.own_witness) if t.own_witness not in ('', 'none') else 'none'}."
        ),
        f"- In the certified store: {kept}.",
        *([f"- {NOBODY}."] if t.has_no_witness else []),
        *(
            f"- Not certified: {markdown_text(label)} at {t_}: {markdown_text(reason)}"
            for label, t_, reason in t.not_certified
        ),
    ]
    return "\n".join(lines)


def checks(found: Sequence[CheckLine]) -> str:
    """Those that apply with what they kill, then those that do not with the reason."""
    lines = [
        [markdown_text(c.name), markdown_text(c.title), markdown_text(c.kills)]
        for c in found
        if not c.left_out
    ]
    others = "\n".join(
        f"- {markdown_text(c.name)}: {markdown_text(c.left_out)}" for c in found if c.left_out
    )
    return table(["check", "what it judges", "what it kills"], lines) + (
        f"\n\nNot for this case at its defaults:\n\n{others}" if others else ""
    )


def slips(page: ManualPage) -> list[str]:
    """What the source says, what holds, and the numbers."""
    return [
        f"**{markdown_text(slip.where)}** Said: {markdown_text(slip.says)}. Holds:"
        f" {markdown_text(slip.holds)}.\n\n"
        + table(
            ["measured", "value"],
            [[markdown_text(what), markdown_text(value)] for what, value in slip.measured],
        )
        for slip in page.slips
    ]


def index_markdown(pages: Sequence[ManualPage]) -> str:
    """Who proves what and who witnesses it."""
    lines = [
        [
            f"[{page.case}]({page.case}.md)",
            str(page.truth.sets),
            str(page.truth.values),
            markdown_text(page.truth.method),
            markdown_text(page.truth.witness)
            + (f" ({page.truth.witnessed} values)" if page.truth.witnessed else ""),
            NOBODY if page.truth.has_no_witness else markdown_text(page.truth.own_witness),
        ]
        for page in pages
    ]
    values = sum(page.truth.values for page in pages)
    witnessed = sum(page.truth.witnessed for page in pages)
    head = ["case", "sets", "values", "proved by", "witness when proved", "witness in the tests"]
    told = (
        f"{len(pages)} cases, {values} certified values, {witnessed} of them confirmed when proved"
        " by a witness that shares no code."
    )
    return f"# Verification manual\n\n{told}\n\n{table(head, lines)}\n"


def scale_of(value: float | None) -> str:
    """A size with two digits."""
    return two(value)
