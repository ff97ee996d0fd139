"""The pages: Jinja2 with autoescape, as every name in a record may come from a stranger."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from refdem.core.finding import Finding, Record
from refdem.report.contents import WORST_FIRST, Contents, advice, anchor, page
from refdem.report.mathml import equations
from refdem.report.numbers import decades, two
from refdem.report.tolerance import TARGETS, WORST, Row, best_errors, cell, worst_rows

MARKS = {"fail": "✗", "error": "!", "stale": "↻", "undecided": "?", "expected": "≈", "unsupported": "—", "pass": "✓"}
MEANINGS = {
    "fail": "a value lies beyond its bound", "error": "no usable run", "stale": "an expected deviation that is not needed any more",
    "undecided": "could not be decided", "expected": "a known deviation, inside its limits", "unsupported": "the engine cannot say the scene",
    "pass": "within the bound",
}  # fmt: skip


def pages(contents: Contents, rows: dict[str, list[Row]], specs: dict[str, dict[str, str]]) -> Iterator[tuple[str, str]]:
    """(file name, text) of every page: cases, engines, and at last the index."""
    templates = _templates()
    everywhere = {"contents": contents, "counts": contents.counts(), "marks": MARKS, "meanings": MEANINGS, "worst": WORST, "targets": TARGETS}
    labels = [sheet.label for sheet in contents.cases]
    for index, sheet in enumerate(contents.cases):
        yield f"cases/{page(sheet.label)}.html", templates.get_template("case.html").render(
            everywhere, root="../", sheet=sheet, records=contents.of(sheet.label), rows=rows[sheet.label], specs=specs[sheet.label],
            equations=equations(sheet.latex), counts=contents.counts(contents.of(sheet.label)), distances=distances(rows[sheet.label]),
            before=labels[index - 1] if index else None, after=labels[index + 1] if index + 1 < len(labels) else None,
        )  # fmt: skip
    yield "engines.html", templates.get_template("engines.html").render(everywhere, root="")
    cells = {(label, sheet.engine): cell(contents, rows[label], label, sheet.engine) for label in labels for sheet in contents.engines}
    groups = {outcome: grouped(contents, outcome) for outcome in WORST_FIRST if outcome != "pass" and outcome in contents.counts()}
    yield "index.html", templates.get_template("index.html").render(
        everywhere, root="", rows=rows, cells=cells, advice=advice(contents.counts()), groups=groups, specs=specs[""]
    )


def grouped(contents: Contents, outcome: str) -> dict[str, list[tuple[Record, Finding]]]:
    """Findings of one outcome by sentence, so that a reason is read once."""
    groups: dict[str, list[tuple[Record, Finding]]] = {}
    for record, finding in contents.findings():
        if finding.outcome == outcome:
            groups.setdefault(finding.sentence, []).append((record, finding))
    return groups


def distances(rows: list[Row]) -> list[tuple[str, str, float, float]]:
    """(engine, engine, at least, at most) for each pair, from the errors of their best methods at the finest level."""
    best = best_errors(rows, WORST)
    names = list(best)
    pairs = [(a, b) for index, a in enumerate(names) for b in names[index + 1 :]]
    return [(a, b, abs(best[a] - best[b]), best[a] + best[b]) for a, b in pairs]


def _templates() -> Environment:
    """The environment: undefined names are errors, everything is escaped."""
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).with_name("templates")),
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    templates.filters |= {"two": two, "decades": decades, "page": page, "anchor": anchor, "script_json": script_json, "shade": shade, "step": step}
    templates.tests |= {"worst_row": lambda row: row.quantity == WORST}
    templates.globals |= {"worst_rows": worst_rows}
    return templates


def script_json(text: str) -> Markup:
    """JSON that can stand inside a script element: no character of it can end the element."""
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    json.loads(text)
    return Markup(text)


def shade(digits: float | None) -> int:
    """The class of a cell of the matrix: 0 for none correct to 5 for 12 and more."""
    return 0 if digits is None else sum(digits >= limit for limit in (1, 3, 6, 9, 12))


def step(row: Row, index: int) -> str:
    """The largest step that holds a target, as text: `≥` if the coarsest one that ran does, a dash if none does."""
    held: Any = row.steps[index]
    if held is None:
        return "–"
    return "any" if row.control == "exact" else f"{'≥ ' if held[1] else ''}{two(held[0])}"
