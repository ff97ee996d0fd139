"""The index of a report: a first page that opens at once, and the parts of it that a reader's
browser loads when they come into view.

A part is a script beside the page, as a page that is opened from disk may load nothing else. It
hands over its HTML as one string, made by the same templates, with the same escapes, as pages are.
"""

from collections.abc import Iterator
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from refdem.core.finding import BROKEN
from refdem.report.contents import Contents, advice
from refdem.report.invariants import KEPT
from refdem.report.overview import SENSITIVE, WANTED, case_lines, part_refused
from refdem.report.reasons import reasons_by_outcome
from refdem.report.replays import handed_over
from refdem.report.tolerance import Row, cell

FEW = 40
"""Findings of one outcome that stand in the page itself; of more, the list is a part."""


def files(
    contents: Contents,
    rows: dict[str, list[Row]],
    chart: str | None,
    templates: Environment,
    shared: dict[str, Any],
) -> Iterator[tuple[str, str]]:
    """(file name, text) of every part, and at last of index.html.

    `chart` is the specification of the chart of every case, `shared` are the variables of all
    templates.
    """
    cells = {}
    for sheet in contents.cases:
        label = sheet.label
        for engine in contents.engines:
            cells[label, engine.engine] = cell(contents, rows[label], label, engine.engine)
    found = reasons_by_outcome(contents)
    reasons = {
        outcome: Markup(
            templates.get_template("index_reasons.html").render(
                shared, root="", outcome=outcome, reasons=own
            )
        )
        for outcome, own in found.items()
    }
    inline = {
        outcome: reasons[outcome]
        for outcome, own in found.items()
        if sum(reason.count for reason in own) <= FEW
    }
    for outcome in found:
        if outcome not in inline:
            yield _part(f"reasons-{outcome}", reasons[outcome])
    drawn: dict[str, dict[str, Any]] = {"tolerance": {"rows": rows}, "digits": {"cells": cells}}
    if shared["laws"]:
        drawn["invariants"] = {}
    if chart is not None:
        drawn["overview"] = {"chart": chart}
    for name, variables in drawn.items():
        template = templates.get_template(f"index_{name}.html")
        yield _part(name, template.render(shared, root="", **variables))
    lines = case_lines(contents, cells)
    text = templates.get_template("index.html").render(
        shared,
        root="",
        lines=lines,
        part_refused=part_refused(lines),
        sensitive=SENSITIVE,
        kept=KEPT,
        wanted=WANTED,
        broken=[outcome for outcome in found if outcome in BROKEN],
        has_chart=chart is not None,
        advice=advice(contents.counts()),
        groups=found,
        inline=inline,
    )
    yield "index.html", text


def is_part(name: str) -> bool:
    """True for the name of a file in assets/ that is a part of an index."""
    return name.startswith("index-") and name.endswith(".js")


def _part(name: str, html: str) -> tuple[str, str]:
    """(file name, text) of the script that hands a part over to report.js."""
    return f"assets/index-{name}.js", handed_over("refdemPart", name, html)
