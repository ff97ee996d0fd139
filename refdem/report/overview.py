"""The first screen of a report: how accurate each engine is in each case, grouped by the kind of
motion, and which method and step to take.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import get_args

from refdem.core.case import Moving
from refdem.core.finding import WORST_FIRST, CaseSheet, Outcome
from refdem.core.once import once_for_each
from refdem.report.advice import Choice, Recommendation, choices, recommendations
from refdem.report.contents import Contents
from refdem.report.tolerance import Cell

MOST_DIGITS = 16.0
"""Digits that are shown of an error, at most: binary64 has no more."""
SENSITIVE = 1e8
"""Growth of round-off above which a cell shows it: half of the digits of binary64 are lost."""
WANTED = (3, 6, 9)
"""Correct digits for which a method and a step are recommended."""


@dataclass(frozen=True)
class CaseCell:
    """One engine in all settings of a case.

    `cell` has the digits of the setting `label`, in which the fewest are correct, and the outcomes
    of all settings. The engine was requested to run `requested` settings, and digits were
    measured in `measured` of these. `refused` has the reasons why it did not run the others, with
    the number of settings.
    """

    cell: Cell
    label: str
    measured: int
    requested: int
    refused: Mapping[str, int]


@dataclass(frozen=True)
class CaseLine:
    """One case in all of its settings: a cell an engine, in the order of the report."""

    case: str
    title: str
    settings: int
    cells: Mapping[str, CaseCell]


@dataclass(frozen=True)
class Advised:
    """The recommended methods of one engine for one kind of motion.

    For each number of digits in WANTED it is the method that holds them in the most settings, among
    these the one with the fewest steps; None where no method does.
    """

    motion: str
    engine: str
    settings: int
    best: tuple[Recommendation | None, ...]


def motions(contents: Contents) -> dict[str, list[CaseSheet]]:
    """The instances by their kind of motion, in the order of these kinds."""
    found: dict[str, list[CaseSheet]] = {name: [] for name in get_args(Moving)}
    for sheet in contents.cases:
        # A record may come from a later version, with a kind that is not known here.
        found.setdefault(sheet.motion, []).append(sheet)
    return {name: sheets for name, sheets in found.items() if sheets}


def case_lines(
    contents: Contents, cells: Mapping[tuple[str, str], Cell]
) -> dict[str, list[CaseLine]]:
    """The lines of the matrix by motion, from the cells of every instance and engine."""
    lines = {}
    for motion, sheets in motions(contents).items():
        by_case: dict[str, list[CaseSheet]] = {}
        for sheet in sheets:
            by_case.setdefault(sheet.case, []).append(sheet)
        lines[motion] = [_line(contents, own, cells) for own in by_case.values()]
    return lines


def part_refused(lines: Mapping[str, list[CaseLine]]) -> list[tuple[str, str, CaseCell]]:
    """The title, the engine and the cell of every case of which an engine runs only a part."""
    return [
        (line.title, engine, found)
        for own in lines.values()
        for line in own
        for engine, found in line.cells.items()
        if found.refused and found.measured
    ]


def _line(
    contents: Contents, sheets: list[CaseSheet], cells: Mapping[tuple[str, str], Cell]
) -> CaseLine:
    """The line of one case, from its instances."""
    joined = {}
    for engine in contents.engines:
        own = {sheet.label: cells[sheet.label, engine.engine] for sheet in sheets}
        joined[engine.engine] = _case_cell(contents, engine.engine, own)
    first = sheets[0]
    return CaseLine(first.case, first.title, len(sheets), joined)


def _case_cell(contents: Contents, engine: str, cells: Mapping[str, Cell]) -> CaseCell:
    """One engine in one case, from its cells in the settings of that case."""
    counts: dict[Outcome, int] = {}
    for outcome in WORST_FIRST:
        number = sum(cell.counts.get(outcome, 0) for cell in cells.values())
        if number:
            counts[outcome] = number
    label = min(cells, key=lambda name: _fewest_first(cells[name]))
    refused = Counter(
        contents.refusal(name, engine)
        for name, cell in cells.items()
        if cell.worst == "unsupported" and cell.digits is None
    )
    return CaseCell(
        cell=Cell(cells[label].digits, cells[label].method, counts, cells[label].growth),
        label=label,
        measured=sum(cell.digits is not None for cell in cells.values()),
        requested=sum(cell.worst is not None for cell in cells.values()),
        refused=dict(refused.most_common()),
    )


def _fewest_first(cell: Cell) -> tuple[bool, float]:
    """Sorts cells by their digits, those without any after those whose error is exactly 0."""
    return cell.digits is None, cell.digits or 0.0


@once_for_each
def advised(contents: Contents) -> list[Advised]:
    """A line for every motion and every engine other than the reference that was measured there."""
    by_motion = motions(contents)
    of_label = {sheet.label: name for name, sheets in by_motion.items() for sheet in sheets}
    wanted = [choices(contents, digits) for digits in WANTED]
    references = {engine.engine for engine in contents.engines if engine.is_reference}
    lines = []
    for motion in by_motion:
        for engine in contents.engines:
            if engine.engine in references or motion == "formula":
                continue
            own = [
                [choice for choice in found if _is_of(choice, engine.engine, motion, of_label)]
                for found in wanted
            ]
            settings = len({choice.record.label for choice in own[0]})
            if settings:
                best = tuple(_best(found) for found in own)
                lines.append(Advised(motion, engine.engine, settings, best))
    return lines


def _is_of(choice: Choice, engine: str, motion: str, of_label: Mapping[str, str]) -> bool:
    """True for a choice of this engine in this kind of motion."""
    return choice.record.engine == engine and of_label[choice.record.label] == motion


def _best(found: list[Choice]) -> Recommendation | None:
    """The method that holds in the most settings; None if none holds in any.

    Ties are broken by the number of steps, then by name. Steps are counted and not timed, so that a
    report of the same runs gives the same recommendation on every machine.
    """
    best = min(recommendations(found), key=_fewest_steps_first)
    if not best.held:
        return None
    return best


def _fewest_steps_first(one: Recommendation) -> tuple[int, float, str]:
    """Sorts methods of one engine: most settings, fewest steps as they are shown, name."""
    return -len(one.held), _shown_steps(one.most_steps_per_tau), one.method


def _shown_steps(steps: float) -> float:
    """A number of steps in two digits, rounded up: fewer were not shown to hold the digits."""
    if not 0 < steps < math.inf:
        return steps
    unit = 10.0 ** max(0, math.floor(math.log10(steps)) - 1)
    return math.ceil(steps / unit) * unit


def advice_text(best: Recommendation | None, settings: int) -> str:
    """The text for a reader: method, step in units of the shortest time, and in how many settings;
    `~` before a step that is extrapolated.
    """
    if best is None:
        return "none"
    if best.tolerance is not None:
        how = f"tolerance {best.tolerance:.1g}"
    elif best.chooses_steps:
        how = "steps of its own"
    elif best.steps_per_tau is None:
        how = "any step"
    else:
        mark = ""
        if best.extrapolated:
            mark = "~"
        how = f"{mark}{_shown_steps(best.steps_per_tau):.0f} steps per tau"
    if len(best.held) < settings:
        return f"{best.method}, {how} ({len(best.held)} of {settings} settings)"
    return f"{best.method}, {how}"


def shown_digits(digits: float) -> str:
    """Correct digits as the matrix shows them: at most those of binary64."""
    if digits >= MOST_DIGITS:
        return f"{MOST_DIGITS:.0f}"
    return f"{digits:.1f}"
