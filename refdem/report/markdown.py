"""validation.md: what is committed, so no times, dates or hosts, and two significant digits."""

from refdem.core.finding import WORST_FIRST, EngineSheet, Record
from refdem.core.outside import markdown_text
from refdem.report.contents import Contents, advice, page
from refdem.report.html import MARKS, grouped, span, step, target
from refdem.report.numbers import ABSENT, two
from refdem.report.tolerance import TARGETS, Row, cell, worst_rows

MOST_PLACES = 8
"""Places that are listed for one reason; the pages have them all."""


def validation(contents: Contents, rows: dict[str, list[Row]], pictures: set[str]) -> str:
    """The whole text."""
    parts = [
        _head(contents),
        _tolerance(contents, rows),
        _matrix(contents, rows),
        _findings(contents),
    ]
    if "tolerance.svg" in pictures:
        parts.insert(1, "![Error against step, every case, every engine](figures/tolerance.svg)")
    parts += [
        _case(sheet.label, sheet.title, sheet.truth_method, sheet.reproduce, pictures)
        for sheet in contents.cases
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _named(sheet: EngineSheet) -> str:
    """Name and version."""
    if sheet.is_reference:
        role = " (the reference)"
    else:
        role = ""
    return f"{markdown_text(sheet.engine)} {markdown_text(sheet.version)}{role}"


def _head(contents: Contents) -> str:
    counts = contents.counts()
    listed = ", ".join(f"**{number} {outcome}**" for outcome, number in counts.items())
    engines = ", ".join(_named(sheet) for sheet in contents.engines)
    return (
        f"# Validation: {markdown_text(contents.campaign.name)}\n\n{listed or 'no findings'}."
        f" {advice(counts)}\n\nEngines: {engines}."
    )


def _tolerance(contents: Contents, rows: dict[str, list[Row]]) -> str:
    """The tolerance table, the worst of all quantities in each line; costs are in the pages
    only.
    """
    head = [
        "case",
        "engine",
        "method",
        "smallest bound held",
        *(f"step for {target(value)}" for value in TARGETS),
        "order seen / claimed",
        "C",
        "farthest engine",
    ]
    lines = [
        _tolerance_line(row) for sheet in contents.cases for row in worst_rows(rows[sheet.label])
    ]
    note = (
        "Errors are in units of each quantity's scale, the largest over the run and over all"
        " quantities. A step with ≥ is the coarsest one that ran. The reference is shown as the"
        " reference."
    )
    return f"## Tolerance table\n\n{note}\n\n{table(head, lines)}" if lines else ""


def _tolerance_line(row: Row) -> list[str]:
    if row.control == "step":
        order = f"{two(row.order_seen)} / {two(row.order_claimed)}"
    else:
        order = row.control
    if row.apart:
        apart = f"{markdown_text(row.apart[0])}: {span(row.apart)}"
    else:
        apart = ABSENT
    steps = [step(row, index) for index in range(len(TARGETS))]
    run = [markdown_text(row.record.label), _engine(row.record), markdown_text(row.record.method)]
    return [*run, two(row.bound_held), *steps, order, two(row.constant), apart]


def _engine(record: Record) -> str:
    return _tagged(record.engine, record.is_reference)


def _tagged(engine: str, is_reference: bool) -> str:
    """The engine, said to be the reference if its name does not say so."""
    return markdown_text(engine) + (
        " (reference)" if is_reference and engine != "reference" else ""
    )


def _matrix(contents: Contents, rows: dict[str, list[Row]]) -> str:
    """Correct digits of the best method of each engine."""
    lines = []
    for sheet in contents.cases:
        cells = [
            cell(contents, rows[sheet.label], sheet.label, engine.engine)
            for engine in contents.engines
        ]
        texts = [
            f"{'' if c.worst in (None, 'pass', 'unsupported') else MARKS[c.worst] + ' '}"
            + (
                ("exact" if c.digits == float("inf") else f"{c.digits:.0f}")
                if c.digits is not None
                else (c.worst or ABSENT)
            )
            for c in cells
        ]
        lines.append([markdown_text(sheet.label), *texts])
    head = ["case", *(_tagged(engine.engine, engine.is_reference) for engine in contents.engines)]
    note = (
        "The decimal logarithm of 1 / error at the finest level: the worst quantity, the best"
        " method of each engine."
    )
    return f"## Correct digits\n\n{note}\n\n{table(head, lines)}" if lines else ""


def _findings(contents: Contents) -> str:
    parts = []
    for outcome in WORST_FIRST:
        if outcome != "pass":
            groups = grouped(contents, outcome)
        else:
            groups = {}
        if groups:
            lines = [
                _group(sentence, [record.id(finding) for record, finding in found])
                for sentence, found in groups.items()
            ]
            parts.append(f"### {outcome}\n\n" + "\n".join(lines))
    return "## What is not a pass\n\n" + ("\n\n".join(parts) or "Nothing: every finding passed.")


def _group(sentence: str, places: list[str]) -> str:
    if len(places) > MOST_PLACES:
        more = f" and {len(places) - MOST_PLACES} more"
    else:
        more = ""
    return (
        f"- {markdown_text(sentence)}  \n "
        f" {', '.join(map(markdown_text, places[:MOST_PLACES]))}{more}"
    )


def _case(label: str, title: str, method: str, reproduce: str, pictures: set[str]) -> str:
    name = f"{page(label)}.svg"
    if name in pictures:
        picture = f"\n\n![Error against step: {markdown_text(label)}](figures/{name})"
    else:
        picture = ""
    if method:
        truth = f"Truth: {markdown_text(method)}. "
    else:
        truth = ""
    if reproduce:
        again = f"Again: {markdown_text(reproduce)}."
    else:
        again = ""
    return f"## {markdown_text(label)}\n\n{markdown_text(title)}. {truth}{again}{picture}"


def table(head: list[str], lines: list[list[str]]) -> str:
    """A Markdown table of cells that are escaped already."""
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *lines))
