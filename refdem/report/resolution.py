"""The resolution of verdicts as text and as Markdown: for each case, method and number the smallest
misreading that would close the gate.
"""

from collections.abc import Iterable
from itertools import groupby

from refdem.core.outside import markdown_text, one_line
from refdem.core.resolution import Seen
from refdem.report.markdown import table

INTRODUCTION = """# Resolution: what a pass would have seen

Each number of a scene was misread by a factor 1 + a in every request that an engine got, and its
runs were judged as if it had been read right. The table has the smallest a at which some finding
fails, and the finding that is farthest beyond its bound there. `refdem resolution CASE --engine E`
measures it anew; trials lie within a factor of 1.5 of each other.
"""


def lines(found: Iterable[Seen]) -> list[str]:
    """Lines for a terminal: a heading for each method on each case, and a line for each number."""
    printed = []
    for (label, engine, method), group in groupby(found, key=_method):
        printed.append(one_line(f"{label} in {engine}, {method}, would have noticed"))
        for seen in group:
            if seen.smallest is None:
                printed.append(one_line(f"  nothing of {seen.number}: {seen.reason}"))
            else:
                printed.append(one_line(f"  {seen.number:36}{seen.size:>10}  {seen.by}"))
    return printed


def markdown(found: Iterable[Seen]) -> str:
    """The page: for each case a table of its numbers, with a column for each method."""
    parts = [INTRODUCTION]
    for label, of_case in groupby(found, key=lambda seen: seen.label):
        parts.append(_table(label, list(of_case)))
    return "\n".join(parts)


def _method(seen: Seen) -> tuple[str, str, str]:
    return seen.label, seen.engine, seen.method


def _table(label: str, found: list[Seen]) -> str:
    """The table of one case, and the reasons of what is not seen."""
    methods = list(dict.fromkeys(f"{seen.engine} {seen.method}" for seen in found))
    names = list(dict.fromkeys(seen.number for seen in found))
    by_place = {(seen.number, f"{seen.engine} {seen.method}"): seen for seen in found}
    rows = []
    for name in names:
        cells = []
        for method in methods:
            seen = by_place.get((name, method))
            if seen is None:
                cells.append("")
            elif seen.smallest is None:
                cells.append("nothing")
            else:
                cells.append(f"{seen.size} ({markdown_text(seen.by)})")
        rows.append([markdown_text(name), *cells])
    head = ["number", *map(markdown_text, methods)]
    parts = [f"## {markdown_text(label)}", "", table(head, rows)]
    reasons = _reasons(found)
    if reasons:
        parts += ["", *reasons]
    return "\n".join([*parts, ""])


def _reasons(found: list[Seen]) -> list[str]:
    """A line for each number and reason for which nothing of it is seen, with the methods that do
    not.
    """
    blind: dict[tuple[str, str], list[str]] = {}
    for seen in found:
        if seen.smallest is None:
            methods = blind.setdefault((seen.number, seen.reason), [])
            methods.append(f"{seen.engine} {seen.method}")
    lines = []
    for (number, reason), methods in blind.items():
        where = markdown_text(", ".join(methods))
        lines.append(
            f"- {markdown_text(number)}: nothing, since {markdown_text(reason)} ({where})."
        )
    return lines
