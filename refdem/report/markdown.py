"""validation.md, the committed report: no times, dates or hosts, and two significant digits.

figures.md beside it shows the figure of each case. A repository need not commit it or the figures.
"""

import math
from collections.abc import Sequence

from refdem.core.finding import CaseSheet, EngineSheet, Record
from refdem.core.moved import Moved
from refdem.core.outside import markdown_text
from refdem.report.contents import Contents, advice, page
from refdem.report.html import MARKS, span, step, target
from refdem.report.invariants import KEPT, Summary, law_sheets
from refdem.report.moved import HEAD, TITLE, markdown_rows, words_of
from refdem.report.numbers import ABSENT, two
from refdem.report.overview import MOST_DIGITS, WANTED, advice_text, advised
from refdem.report.reasons import Findings, Reason, reasons_by_outcome
from refdem.report.tolerance import TARGETS, Cell, Row, cell, worst_rows

Cells = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""A table as it is before it is escaped: title, header, rows."""
MOST_PLACES = 8
"""Places that are listed for one reason; the pages have them all."""


def validation(contents: Contents, rows: dict[str, list[Row]], pictures: set[str]) -> str:
    """The text of validation.md; `pictures` are the names of the figures that were drawn.

    It shows the figure of all cases only, and links to no other file.
    """
    parts = [
        _head(contents),
        _conserved(contents),
        _advice(contents),
        _tolerance(contents, rows),
        _matrix(contents, rows),
        _findings(contents),
    ]
    if "tolerance.svg" in pictures:
        parts.insert(2, "![Error against step, every case, every engine](figures/tolerance.svg)")
    if _drawn(contents, pictures):
        parts.append(
            "The error of each case below is drawn against the step in figures.md, which the same"
            " command writes beside this page."
        )
    for sheet in contents.cases:
        parts.append(_case(sheet.label, sheet.title, sheet.truth_method, sheet.reproduce))
        parts.append(_moved(contents.moved.get(sheet.label)))
    return "\n\n".join(part for part in parts if part) + "\n"


def figures(contents: Contents, pictures: set[str]) -> str:
    """The text of figures.md: the figure of each case, error against step."""
    parts = [f"# Figures: {markdown_text(contents.campaign.name)}"]
    for sheet in _drawn(contents, pictures):
        label = markdown_text(sheet.label)
        parts.append(f"## {label}\n\n{markdown_text(sheet.title)}.")
        parts.append(f"![Error against step: {label}](figures/{page(sheet.label)}.svg)")
    return "\n\n".join(parts) + "\n"


def _drawn(contents: Contents, pictures: set[str]) -> list[CaseSheet]:
    """The cases whose error was drawn against the step."""
    return [sheet for sheet in contents.cases if f"{page(sheet.label)}.svg" in pictures]


def _named(sheet: EngineSheet) -> str:
    """The name and version of an engine, and whether it is the reference."""
    if sheet.is_reference:
        role = " (the reference)"
    else:
        role = ""
    return f"{markdown_text(sheet.engine)} {markdown_text(sheet.version)}{role}"


def _head(contents: Contents) -> str:
    """The title, how many findings have each outcome, what to do about them, and the engines."""
    counts = contents.counts()
    listed = ", ".join(f"**{number} {outcome}**" for outcome, number in counts.items())
    engines = ", ".join(_named(sheet) for sheet in contents.engines)
    return (
        f"# Validation: {markdown_text(contents.campaign.name)}\n\n{listed or 'no findings'}."
        f" {advice(counts)}\n\nEngines: {engines}."
    )


def _conserved(contents: Contents) -> str:
    """How many settings of each law are kept to round-off, engine by engine."""
    laws = law_sheets(contents)
    if not laws:
        return ""
    names = [engine.engine for engine in contents.engines]
    lines = [
        [markdown_text(sheet.law.title), *(_conserved_in(sheet.summaries[name]) for name in names)]
        for sheet in laws
    ]
    head = ["law", *(_tagged(engine.engine, engine.is_reference) for engine in contents.engines)]
    note = (
        "In how many settings the best method of each engine keeps each law at its finest level."
        f" Kept means a change of at most {two(KEPT)} of its scale, which is round-off. Elsewhere"
        " the law holds to an error of the step, and the largest one is given, also at the step"
        " that the engine takes by default: that follows from the measured order."
    )
    return f"## What is conserved, and what comes back\n\n{note}\n\n{table(head, lines)}"


def _conserved_in(summary: Summary) -> str:
    """A cell of the table of what is conserved."""
    if not summary.settings:
        return ABSENT
    parts = [f"kept in {summary.kept} of {len(summary.settings)}"]
    worst = summary.largest_error
    if worst is not None:
        parts.append(f"{summary.counts['approximate']} change by at most {two(worst.change)}")
    if summary.at_default is not None:
        parts.append(f"about {two(summary.at_default)} at the default step")
    parts += [
        f"{summary.counts[name]} {name}" for name in ("undecided", "lost") if name in summary.counts
    ]
    return ", ".join(parts)


def _advice(contents: Contents) -> str:
    """Which method and step hold how many digits, for each engine and kind of motion; without
    costs.
    """
    lines = []
    for line in advised(contents):
        advice_cells = [markdown_text(advice_text(best, line.settings)) for best in line.best]
        lines.append([line.motion, markdown_text(line.engine), str(line.settings), *advice_cells])
    if not lines:
        return ""
    head = ["motion", "engine", "settings", *(f"{digits} digits" for digits in WANTED)]
    note = (
        "For each number of digits the method that reaches it in the most settings, of equals the"
        " one with the fewest steps, with its steps per shortest time tau of a motion. ~ marks what"
        " is extrapolated by the measured order. What a step costs depends on the machine: the"
        " command refdem advise measures it."
    )
    return f"## Which method, which step?\n\n{note}\n\n{table(head, lines)}"


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
    lines = []
    for sheet in contents.cases:
        lines += [_tolerance_line(row) for row in worst_rows(rows[sheet.label])]
    if not lines:
        return ""
    note = (
        "Errors are relative to the scale of each quantity, the largest over the"
        " run and over all quantities. A step with ≥ is the largest one that ran."
        " The reference is shown, not ranked."
    )
    return f"## Tolerance table\n\n{note}\n\n{table(head, lines)}"


def _tolerance_line(row: Row) -> list[str]:
    """The cells of one row, escaped; only a step has an order."""
    order: str = row.control
    if row.control == "step":
        order = f"{two(row.order_seen)} / {two(row.order_claimed)}"
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
    """The name of the engine, with "(reference)" after it unless the name already states so."""
    name = markdown_text(engine)
    if is_reference and engine != "reference":
        return f"{name} (reference)"
    return name


def _matrix(contents: Contents, rows: dict[str, list[Row]]) -> str:
    """Correct digits of the best method of each engine."""
    lines = []
    for sheet in contents.cases:
        texts = []
        for engine in contents.engines:
            best = cell(contents, rows[sheet.label], sheet.label, engine.engine)
            texts.append(_digits(best))
        lines.append([markdown_text(sheet.label), *texts])
    if not lines:
        return ""
    head = ["case", *(_tagged(engine.engine, engine.is_reference) for engine in contents.engines)]
    note = (
        "The decimal logarithm of 1 / error at the finest level: the worst quantity, the best"
        " method of each engine."
    )
    return f"## Correct digits\n\n{note}\n\n{table(head, lines)}"


def _digits(best: Cell) -> str:
    """A cell of the matrix: the mark of the worst outcome, then the number of correct digits, or
    the outcome where nothing was measured.
    """
    if best.worst in (None, "pass", "unsupported"):
        mark = ""
    else:
        mark = f"{MARKS[best.worst]} "
    if best.digits is None:
        return f"{mark}{best.worst or ABSENT}"
    if best.digits == math.inf:
        return f"{mark}exact"
    return f"{mark}{min(best.digits, MOST_DIGITS):.0f}"


def _findings(contents: Contents) -> str:
    """Every finding that is not a pass, by outcome, reason and sentence."""
    parts = []
    for outcome, reasons in reasons_by_outcome(contents).items():
        lines = [line for reason in reasons for line in _reason(reason)]
        parts.append(f"### {outcome}\n\n" + "\n".join(lines))
    return "## What is not a pass\n\n" + ("\n\n".join(parts) or "Nothing: every finding passed.")


def _reason(reason: Reason) -> list[str]:
    """Items of a list: a reason with the places where it holds; below it, if it has details, what
    each of them adds.
    """
    ((first, found), *others) = reason.details.items()
    if not others:
        return [_item(f"{reason.heading} {first}".rstrip(), found)]
    head = f"- {markdown_text(reason.heading)} {reason.count} findings:"
    below = [_item(detail, own).replace("\n", "\n  ") for detail, own in reason.details.items()]
    return [head, *(f"  {item}" for item in below)]


def _item(text: str, found: Findings) -> str:
    """A text, and below it where it holds."""
    places = [record.id(finding) for record, finding in found[:MOST_PLACES]]
    listed = ", ".join(map(markdown_text, places))
    hidden = len(found) - MOST_PLACES
    if hidden > 0:
        more = f" and {hidden} more"
    else:
        more = ""
    return f"- {markdown_text(text)}  \n  {listed}{more}"


def _case(label: str, title: str, method: str, reproduce: str) -> str:
    """The section of one instance: its title, how its truth is known, how to run it again."""
    if method:
        truth = f"Truth: {markdown_text(method)}. "
    else:
        truth = ""
    if reproduce:
        again = f"Again: {markdown_text(reproduce)}."
    else:
        again = ""
    return f"## {markdown_text(label)}\n\n{markdown_text(title)}. {truth}{again}"


def _moved(sheet: Moved | None) -> str:
    """The table of what each number of an instance moves; empty where it was not computed."""
    if sheet is None or not sheet.numbers:
        return ""
    words = f"{words_of(sheet, 'these parameters')} All: {markdown_text(sheet.command)}."
    return f"### {TITLE}\n\n{words}\n\n{table(list(HEAD), markdown_rows(sheet))}"


def table(head: list[str], lines: list[list[str]]) -> str:
    """A Markdown table of cells that are escaped already."""
    rule = ["---"] * len(head)
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, rule, *lines))


def titled_table(cells: Cells) -> str:
    """A title, and below it the table with every cell escaped."""
    title, header, rows = cells
    escaped = [list(map(markdown_text, row)) for row in rows]
    return f"{title}:\n\n{table(list(header), escaped)}"
