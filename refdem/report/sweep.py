"""The table of a parameter study: error, cost and verdict at every setting, method and step."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from refdem.core.finding import DECIDED, WORST_FIRST, Finding, Outcome, Record
from refdem.core.outside import markdown_text, one_line
from refdem.report.contents import Contents
from refdem.report.markdown import table
from refdem.report.numbers import two
from refdem.report.tables import csv_text
from refdem.report.tolerance import Control, Row, rows_of, worst_rows

MEASURED = ("engine", "method", "control", "level", "error", "bound", "cost", "verdict", "reason")
"""Columns after those of the parameters."""
SHOWN = ("engine", "method", "step", "error", "bound", "cost [s/s]", "verdict")
"""The same for people."""
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
"""A number in a sentence."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """One method of one engine at one setting with one step.

    `setting` has the values of the parameters that vary, as text. `level` is the step [s] or the
    tolerance, 0 for an exact method; `error` and `bound` are the largest error over the run, of
    the worst quantity, and the smallest bound, in units of the quantity's scale; `cost` is the time
    [s] of computing for a second of motion. They are None where nothing was measured. `verdict` is
    the worst outcome of what was decided of the method at this setting, over all of its steps, and
    `reason` the sentence of that finding.
    """

    setting: Mapping[str, str]
    engine: str
    method: str
    verdict: Outcome
    reason: str
    control: Control | None = None
    level: float | None = None
    error: float | None = None
    bound: float | None = None
    cost: float | None = None

    def cells(self) -> list[Any]:
        """The values of the parameters, and those of the columns MEASURED."""
        return [*self.setting.values(), *(getattr(self, name) for name in MEASURED)]

    def shown(self) -> list[str]:
        """The values of the parameters, and those of the columns SHOWN, for people."""
        return [
            *self.setting.values(),
            one_line(self.engine),
            one_line(self.method),
            self._step(),
            two(self.error),
            two(self.bound),
            two(self.cost),
            self.verdict,
        ]

    def _step(self) -> str:
        """The step or the tolerance in words."""
        if self.control == "exact":
            return "any"
        if self.control == "tolerance":
            return f"tol {two(self.level)}"
        return two(self.level)


def points(contents: Contents, settings: Mapping[str, Mapping[str, str]]) -> list[Point]:
    """The points of a study, in the order of its settings; `settings` has the parameters that vary
    of each instance by its label.
    """
    sheets = {sheet.label: sheet for sheet in contents.cases}
    found = []
    for label, setting in settings.items():
        duration = sheets[label].scales["T"]
        measured = {
            (row.record.engine, row.record.method): row
            for row in worst_rows(rows_of(contents, label))
        }
        for record in contents.of(label):
            row = measured.get((record.engine, record.method))
            found += _points_of(record, row, setting, duration)
    return found


def _points_of(
    record: Record, row: Row | None, setting: Mapping[str, str], duration: float
) -> list[Point]:
    """The points of one record, one a level; one without numbers if nothing was measured."""
    worst = _deciding(record)
    without_numbers = Point(
        setting=setting,
        engine=record.engine,
        method=record.method,
        verdict=worst.outcome,
        reason=worst.sentence,
    )
    if row is None:
        return [without_numbers]
    return [
        replace(
            without_numbers,
            control=row.control,
            level=level.level,
            error=level.error,
            bound=level.bound,
            cost=level.seconds / duration,
        )
        for level in row.levels
    ]


def _deciding(record: Record) -> Finding:
    """The worst finding of those that were decided or broke; of all, if none was."""
    findings = record.findings
    decided = [finding for finding in findings if finding.outcome in (*DECIDED, "error")]
    return min(decided or findings, key=lambda finding: WORST_FIRST.index(finding.outcome))


def text(names: Sequence[str], found: Sequence[Point]) -> str:
    """The table for a terminal: columns that are padded."""
    cells = [[*names, *SHOWN], *(point.shown() for point in found)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for line in cells:
        padded = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
        lines.append("  ".join(padded).rstrip())
    return "\n".join([*lines, *reasons(found)])


def reasons(found: Sequence[Point]) -> list[str]:
    """A line for each reason why something is no pass, with the number of points that have it.

    Reasons of one method that differ in their numbers alone are one line, with the first of them.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for point in found:
        if point.verdict != "pass":
            source = f"{point.verdict}, {point.engine}/{point.method}"
            kind = NUMBER.sub("0", point.reason)
            alike.setdefault((source, kind), []).append(point.reason)
    lines = []
    for (source, _), listed in alike.items():
        rows = f"{len(listed)} of {len(found)} rows"
        if len(set(listed)) > 1:
            rows += "; this is the first, the others differ in numbers"
        lines.append(one_line(f"{source}: {listed[0]} ({rows})"))
    return lines


def markdown(
    title: str, names: Sequence[str], found: Sequence[Point], *, has_map: bool = False
) -> str:
    """The table in Markdown, below a title and the heat map, with the reasons below it."""
    lines = [list(map(markdown_text, point.shown())) for point in found]
    parts = [f"# {markdown_text(title)}"]
    if has_map:
        parts.append("![correct digits, with contours of 3, 6 and 9](sweep.svg)")
    parts.append(table([*names, *SHOWN], lines))
    parts += [markdown_text(reason) for reason in reasons(found)]
    return "\n\n".join(parts) + "\n"


def csv(names: Sequence[str], found: Sequence[Point]) -> str:
    """The table as CSV with all digits; absent values are empty."""
    return csv_text([*names, *MEASURED], [point.cells() for point in found])


def as_json(label: str, names: Sequence[str], found: Sequence[Point], absent: Sequence[str]) -> str:
    """The table as JSON: a list of points, each with its setting; absent numbers are null.

    `absent` has a sentence for each engine that was requested and is not installed.
    """
    documents = []
    for point in found:
        document: dict[str, Any] = {"setting": dict(point.setting)}
        for name in MEASURED:
            value = getattr(point, name)
            if isinstance(value, float) and not math.isfinite(value):
                value = None
            document[name] = value
        documents.append(document)
    answer = {
        "case": label,
        "parameters": list(names),
        "points": documents,
        "absent": list(absent),
    }
    return json.dumps(answer, indent=1, allow_nan=False)
