"""The verification manual: a page a case in Markdown (committed) and in HTML (offline, in the
report's style), and a table of them all.
"""

from collections.abc import Sequence
from pathlib import Path

from refdem.core.manual import ChapterLine, CheckLine, ManualPage, QuantityLine
from refdem.core.moved import Moved
from refdem.core.outside import markdown_text
from refdem.report.files import removed, written
from refdem.report.html import environment
from refdem.report.markdown import table
from refdem.report.mathml import equations
from refdem.report.moved import HEAD, TITLE, markdown_rows, words_of
from refdem.report.numbers import two

CSS = Path(__file__).with_name("assets") / "report.css"
FEW = 24
"""Quantities that a page lists one by one; more are listed by name."""
NOBODY = "**none**: no independent witness"
CHAPTER_TITLE = "The source chapter, item by item"
CHAPTER_WORDS = (
    "What has a number in the source chapter, and what else it states that can be run: the case"
    " that runs it, the engines that can, and the check that judges it. Of numbers without a motion"
    " an engine may answer some only. The tests plant what is killed, and the check has to see it."
    " Pictures are made by the command refdem gallery."
)


def write_pages(
    folder: Path,
    pages: Sequence[ManualPage],
    *,
    version: str,
    chapter: Sequence[ChapterLine] = (),
) -> None:
    """Writes manual/<case>.md and .html, manual/index and manual/chapter in both formats, and the
    style sheet; removes pages of cases that no longer exist.
    """
    home = Path(folder) / "manual"
    known = {"index.md", "index.html", "chapter.md", "chapter.html"}
    for page in pages:
        known |= {f"{page.case}.md", f"{page.case}.html"}
    for path in sorted(home.glob("*")):
        if path.name not in known and path.suffix in (".md", ".html"):
            removed(path)
    templates = environment()
    templates.filters["prose"] = scale_of
    written(Path(folder) / "assets" / CSS.name, CSS.read_bytes())
    neighbours = [None, *pages, None]
    for index, page in enumerate(pages):
        written(home / f"{page.case}.md", markdown(page))
        text = templates.get_template("manual.html").render(
            root="../",
            sheet=page,
            version=version,
            equations=equations(page.latex),
            few=FEW,
            before=neighbours[index],
            after=neighbours[index + 2],
        )
        written(home / f"{page.case}.html", text)
    written(home / "index.md", index_markdown(pages))
    contents = templates.get_template("manual_index.html")
    text = contents.render(root="../", pages=pages, version=version)
    written(home / "index.html", text)
    written(home / "chapter.md", chapter_markdown(chapter))
    items = templates.get_template("manual_chapter.html")
    text = items.render(
        root="../", lines=chapter, title=CHAPTER_TITLE, words=CHAPTER_WORDS, version=version
    )
    written(home / "chapter.html", text)


def markdown(page: ManualPage) -> str:
    """The page of one case as Markdown."""
    parts = _statement(page)
    parts += [
        "## Parameters",
        "Truth uses the exact values; engines run with values rounded to binary64.",
        table(*parameters(page)),
        "## Quantities",
        quantities(page.quantities),
    ]
    if page.scalars:
        parts += ["## Scalars at the defaults", scalars(page.scalars)]
    if page.moved:
        parts += [f"## {TITLE}", moved(page)]
    parts += [
        "## Truth",
        truth(page),
        "## Checks",
        "The checks that apply at the defaults in the methods of the reference.",
        checks(page.checks),
    ]
    if page.slips:
        parts += ["## Slips of the source", *slips(page)]
    commands = "\n".join(page.reproduce)
    parts += ["## Again", f"```\n{commands}\n```"]
    return "\n\n".join(parts) + "\n"


def _statement(page: ManualPage) -> list[str]:
    """Title, statement, equation, words, source and kind of the problem of a case, a paragraph
    each.
    """
    source = markdown_text(page.source)
    convention = markdown_text(page.convention)
    kind = markdown_text(page.kind)
    features = markdown_text(", ".join(page.features))
    words = []
    if page.words:
        words = [f"Found by: {markdown_text(', '.join(page.words))}."]
    return [
        f"# {markdown_text(page.title)} (`{page.case}`)",
        markdown_text(page.statement),
        f"$$\n{page.latex}\n$$",
        *words,
        f"Source: {source}. Convention: {convention}",
        f"Kind of problem: {kind}: {features}.",
    ]


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


def quantities(entries: Sequence[QuantityLine]) -> str:
    """A table of the quantities, or a list of their names where they are many."""
    if len(entries) > FEW:
        names = ", ".join(f"`{line.name}`" for line in entries)
        return f"{len(entries)} values: {names}."
    head = ["quantity", "unit", "scale: the size relative to which an error is measured"]
    lines = [[f"`{line.name}`", markdown_text(line.unit), two(line.scale)] for line in entries]
    return table(head, lines)


def scalars(entries: Sequence[QuantityLine]) -> str:
    """A table of the scalars, or of the first ones where they are many."""
    lines = [[f"`{line.name}`", line.mid, line.radius] for line in entries[:FEW]]
    first = table(["scalar", "value", "radius"], lines)
    if len(entries) <= FEW:
        return first
    return f"{first}\n\nand {len(entries) - FEW} more"


def moved(page: ManualPage) -> str:
    """A table of the numbers of the case, each with the quantity that is most sensitive to it, by
    certified derivatives.
    """
    command = f"refdem truth {page.case} --sensitivities --at {page.moved_at}"
    lines = Moved(label=page.case, at=page.moved_at, command=command, numbers=page.moved)
    words = f"{words_of(lines, 'the defaults')} `{command}` prints all of them."
    return f"{words}\n\n{table(list(HEAD), markdown_rows(lines))}"


def truth(page: ManualPage) -> str:
    """How the truth is proved, its independent witnesses, and the certified values."""
    t = page.truth
    confirmed = ""
    if t.witnessed:
        confirmed = (
            f" {t.witnessed} of the certified values were confirmed, to at least {t.agreed} digits."
        )
    kept = "none yet"
    if t.sets:
        if t.digits is None:
            digits = "exactly"
        else:
            digits = f"to {t.digits} decimal places"
        kept = f"{t.values} values of {t.sets} parameter sets, all proved {digits}"
    lines = [
        f"- Method: {markdown_text(t.method)}.",
        f"- Witness when it is proved: {markdown_text(t.witness)}.{confirmed}",
        f"- Witness in the tests: {markdown_text(t.own_witness or 'none')}.",
        f"- In the certified store: {kept}.",
    ]
    if t.has_no_witness:
        lines.append(f"- {NOBODY}.")
    for label, time, reason in t.not_certified:
        lines.append(f"- Not certified: {markdown_text(label)} at {time}: {markdown_text(reason)}")
    return "\n".join(lines)


def checks(entries: Sequence[CheckLine]) -> str:
    """A table of the checks that apply, with what each judges and kills."""
    lines = []
    for line in entries:
        cells = (line.name, line.title, line.kills)
        lines.append([markdown_text(text) for text in cells])
    return table(["check", "what it judges", "what it kills"], lines)


def slips(page: ManualPage) -> list[str]:
    """The slips of the source: its statement, the correct one, and the numbers of each."""
    paragraphs = []
    for slip in page.slips:
        where = markdown_text(slip.where)
        says = markdown_text(slip.says)
        holds = markdown_text(slip.holds)
        lines = [[markdown_text(what), markdown_text(value)] for what, value in slip.measured]
        numbers = table(["measured", "value"], lines)
        paragraphs.append(f"**{where}** Said: {says}. Holds: {holds}.\n\n{numbers}")
    return paragraphs


def index_markdown(pages: Sequence[ManualPage]) -> str:
    """The index in Markdown: how each case is proved, and its independent witnesses."""
    lines = [_index_line(page) for page in pages]
    values = sum(page.truth.values for page in pages)
    witnessed = sum(page.truth.witnessed for page in pages)
    head = ["case", "sets", "values", "proved by", "witness when proved", "witness in the tests"]
    totals = (
        f"{len(pages)} cases, {values} certified values, {witnessed} of them confirmed when proved"
        " by a witness that shares no code."
    )
    chapter = f"[{CHAPTER_TITLE}](chapter.md)."
    return f"# Verification manual\n\n{totals}\n\n{chapter}\n\n{table(head, lines)}\n"


def chapter_markdown(items: Sequence[ChapterLine]) -> str:
    """The table of the source chapter, a line an item."""
    lines = [_chapter_line(item) for item in items]
    head = ["where", "states", "case", "engines", "check", "kills", "picture"]
    return f"# {CHAPTER_TITLE}\n\n{CHAPTER_WORDS}\n\n{table(head, lines)}\n"


def _chapter_line(item: ChapterLine) -> list[str]:
    """The cells of one item of the chapter."""
    case = f"[{item.case}]({item.case}.md)"
    if item.parameters:
        case += f" {markdown_text(item.parameters)}"
    return [
        markdown_text(item.where),
        markdown_text(item.states),
        case,
        markdown_text(", ".join(item.engines)),
        markdown_text(item.check),
        markdown_text(item.kills),
        markdown_text(", ".join(item.pictures)),
    ]


def _index_line(page: ManualPage) -> list[str]:
    """The cells of one case in the table of them all."""
    proof = page.truth
    witness = markdown_text(proof.witness)
    if proof.witnessed:
        witness += f" ({proof.witnessed} values)"
    if proof.has_no_witness:
        own_witness = NOBODY
    else:
        own_witness = markdown_text(proof.own_witness)
    return [
        f"[{page.case}]({page.case}.md)",
        str(proof.sets),
        str(proof.values),
        markdown_text(proof.method),
        witness,
        own_witness,
    ]


def scale_of(value: float | None) -> str:
    """A size with two significant digits, as the pages show it."""
    return two(value)
