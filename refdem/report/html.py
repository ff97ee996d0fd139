"""The HTML pages, from Jinja2 templates. Names in records are not trusted, so autoescape is on."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from refdem.core.finding import WORST_FIRST, EngineSheet, Finding, Record
from refdem.core.outside import printable
from refdem.report import index
from refdem.report.compiled import cache_beside
from refdem.report.contents import Contents, anchor, page
from refdem.report.invariants import law_sheets
from refdem.report.mathml import equations
from refdem.report.moved import HEAD, cells_of, words_of
from refdem.report.numbers import ABSENT, decades, significant, two
from refdem.report.overview import advice_text, advised, shown_digits
from refdem.report.reasons import refusals
from refdem.report.tolerance import TARGETS, WORST, Row, best_errors

MARKS = {
    "fail": "✗",
    "worse": "↘",
    "lost": "∅",
    "absent": "⊘",
    "stale": "↻",
    "error": "!",
    "undecided": "?",
    "expected": "≈",
    "unsupported": "—",
    "pass": "✓",
}
MEANINGS = {
    "fail": "a value is above its bound",
    "worse": "worse than the baseline accepts, beyond noise",
    "lost": "decided in the baseline, but not in this run",
    "absent": "in the baseline, but missing in this run",
    "error": "no usable run",
    "stale": "an expected deviation that is no longer needed",
    "undecided": "could not be decided",
    "expected": "a known deviation, within its limits",
    "unsupported": "the engine or method does not support the scene",
    "pass": "within the bound",
}


def pages(
    contents: Contents,
    rows: dict[str, list[Row]],
    specs: dict[str, dict[str, str]],
    *,
    has_gallery: bool = False,
    has_site: bool = False,
) -> Iterator[tuple[str, str]]:
    """(file name, text) of every page: cases, engines, and last the index with its parts.

    The index links to a gallery and to the site of `make docs` where these exist.
    """
    templates = environment()
    shared = shared_by_all(contents) | {"has_site": has_site}
    yield from _case_pages(contents, rows, specs, templates, shared)
    yield "engines.html", templates.get_template("engines.html").render(shared, root="")
    beside = {"has_gallery": has_gallery}
    chart = specs[""].get("tolerance")
    yield from index.files(contents, rows, chart, templates, shared | beside)


def shared_by_all(contents: Contents) -> dict[str, Any]:
    """The variables of all templates of pages."""
    return {
        "contents": contents,
        "counts": contents.counts(),
        "marks": MARKS,
        "meanings": MEANINGS,
        "targets": TARGETS,
        "advised": advised(contents),
        "laws": law_sheets(contents),
        "moved_head": HEAD,
    }


def _case_pages(
    contents: Contents,
    rows: dict[str, list[Row]],
    specs: dict[str, dict[str, str]],
    templates: Environment,
    shared: dict[str, Any],
) -> Iterator[tuple[str, str]]:
    """(file name, text) of the page of every case, with links to the case before and after it;
    `shared` are the variables of all templates.
    """
    template = templates.get_template("case.html")
    labels = [sheet.label for sheet in contents.cases]
    neighbours = [None, *labels, None]
    for number, sheet in enumerate(contents.cases):
        label = sheet.label
        counts = contents.counts(contents.of(label))
        # `neighbours` has one entry more in front: the case itself is at number + 1.
        before = neighbours[number]
        after = neighbours[number + 2]
        text = template.render(
            shared,
            root="../",
            sheet=sheet,
            engines=by_engine(contents, label),
            rows=rows[label],
            specs=specs[label],
            equations=equations(sheet.latex),
            counts=counts,
            distances=distances(rows[label]),
            moved=contents.moved.get(label),
            before=before,
            after=after,
        )
        yield f"cases/{page(label)}.html", text


def by_engine(contents: Contents, label: str) -> list[tuple[EngineSheet, list[Record]]]:
    """The engines that have records of an instance, with these, in the order of the report."""
    groups = []
    for sheet in contents.engines:
        records = [record for record in contents.of(label) if record.engine == sheet.engine]
        if records:
            groups.append((sheet, records))
    return groups


def worst_first(findings: tuple[Finding, ...]) -> list[Finding]:
    """Findings sorted by outcome, worst first; the sort is stable."""
    return sorted(findings, key=lambda finding: WORST_FIRST.index(finding.outcome))


def distances(rows: list[Row]) -> list[tuple[str, str, float, float]]:
    """(engine, engine, at least, at most) for each pair, from the errors of their best methods at
    the finest level.
    """
    best = best_errors(rows, WORST)
    pairs = []
    for a, b in itertools.combinations(best, 2):
        # |error_a - error_b| <= distance <= error_a + error_b.
        at_least = abs(best[a] - best[b])
        at_most = best[a] + best[b]
        pairs.append((a, b, at_least, at_most))
    return pairs


def environment() -> Environment:
    """The environment: undefined names are errors, everything is escaped."""
    folder = Path(__file__).with_name("templates")
    templates = Environment(
        loader=FileSystemLoader(folder),
        bytecode_cache=cache_beside(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=shown,
    )
    functions = (
        two,
        significant,
        decades,
        page,
        anchor,
        script_json,
        shade,
        step,
        target,
        worst_first,
        refusals,
        span,
        advice_text,
        shown_digits,
        cells_of,
        words_of,
    )
    templates.filters |= {function.__name__: function for function in functions}
    templates.tests["joined"] = lambda row: row.quantity == WORST
    return templates


def shown(value: Any) -> Any:
    """Text without characters that do not print; what is markup already stays."""
    if type(value) is str:
        return printable(value)
    return value


def script_json(text: str) -> Markup:
    """JSON that can stand inside a script element: no character of it can end the element."""
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def shade(digits: float | None) -> int:
    """The shade of a cell of the matrix, from 0 for no correct digit to 5 for 12 and more."""
    if digits is None:
        return 0
    return sum(digits >= limit for limit in (1, 3, 6, 9, 12))


def target(value: float) -> str:
    """A target of the tolerance table as a power of ten."""
    return f"1e{math.log10(value):.0f}"


def span(apart: tuple[str, float, float]) -> str:
    """A distance that is known by its bounds."""
    low = two(apart[1])
    high = two(apart[2])
    if low == high:
        return low
    return f"{low} to {high}"


def step(row: Row, index: int) -> str:
    """The largest step whose error is within a target, as text.

    `≥` precedes the coarsest step that ran, and a dash stands for no step.
    """
    held: Any = row.steps[index]
    if held is None:
        return ABSENT
    if row.control == "exact":
        return "any"
    largest, is_coarsest = held
    if is_coarsest:
        return f"≥ {two(largest)}"
    return two(largest)
