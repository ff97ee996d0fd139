"""The tolerance table: accuracy, step and cost of each method; and the matrix of correct digits."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from refdem.core.finding import WORST_FIRST, Finding, Level, Outcome, Record
from refdem.core.once import once_for_each
from refdem.report.contents import Contents

TARGETS = (1e-3, 1e-6, 1e-9)
UNIT = 2.0**-53
"""The unit round-off of binary64."""
WORST = "worst of all"
"""The name of the row that joins all quantities of a run: at every level the largest error and the
smallest bound.
"""

Control = Literal["step", "tolerance", "exact"]


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line: a case in one method of one engine, in one quantity; errors are in units of the
    quantity's scale.

    `steps` has the largest step (or tolerance) that holds each of TARGETS, and whether it is the
    coarsest that ran.
    `apart` is the engine whose result is farthest away, with bounds on the distance. For errors
    a and b of the two: |a - b| <= distance <= a + b (triangle inequality).
    """

    record: Record
    quantity: str
    control: Control
    outcome: Outcome
    levels: tuple[Level, ...]
    bound_held: float | None
    steps: tuple[tuple[float, bool] | None, ...]
    order_seen: float | None
    order_claimed: float | None
    constant: float | None
    seconds: float | None
    apart: tuple[str, float, float] | None = None

    @property
    def error(self) -> float:
        """The error at the finest level."""
        return self.levels[-1].error

    @property
    def series(self) -> str:
        """Engine and method, as charts name them."""
        return f"{self.record.engine} {self.record.method}"


def control_of(finding: Finding) -> Control:
    """How accuracy was controlled: a finding with an order has a step, an exact method level 0."""
    if all(level.level == 0 for level in finding.levels):
        return "exact"
    if finding.order_claimed is not None:
        return "step"
    return "tolerance"


def rows_of(contents: Contents, label: str) -> list[Row]:
    """All rows of one instance: for every engine and method the worst of all, then each
    quantity.
    """
    return list(_rows_by_label(contents).get(label, ()))


@once_for_each
def _rows_by_label(contents: Contents) -> dict[str, list[Row]]:
    """The rows of every instance, from which tables, matrix and advice are made."""
    return {sheet.label: _rows(contents, sheet.label) for sheet in contents.cases}


def _rows(contents: Contents, label: str) -> list[Row]:
    """The rows of one instance."""
    rows = []
    for record in contents.of(label):
        errors = [
            finding for finding in record.findings if finding.check == "error" and finding.levels
        ]
        each = [_row(record, finding) for finding in errors]
        if each:
            rows.append(_joined(record, each))
        # A single quantity is the worst of all already.
        if len(each) > 1:
            rows += each
    quantities = {row.quantity for row in rows}
    best = {quantity: best_errors(rows, quantity) for quantity in quantities}
    return [replace(row, apart=_apart(row, best[row.quantity])) for row in rows]


def worst_rows(rows: Iterable[Row]) -> list[Row]:
    """The rows that cover all quantities of a run."""
    return [row for row in rows if row.quantity == WORST]


def _row(record: Record, finding: Finding) -> Row:
    """The row of one quantity, from the finding that has its levels."""
    levels = finding.levels
    control = control_of(finding)
    held = [level.bound for level in levels if level.error <= level.bound]
    steps = tuple(_largest(levels, target) for target in TARGETS)
    return Row(
        record=record,
        quantity=finding.quantity,
        control=control,
        outcome=finding.outcome,
        levels=levels,
        bound_held=min(held, default=None),
        steps=steps,
        order_seen=finding.order_seen,
        order_claimed=finding.order_claimed,
        constant=finding.constant_seen,
        seconds=_seconds_at(levels, steps[1]),
    )


def _joined(record: Record, each: list[Row]) -> Row:
    """The row of the worst of all quantities, from the rows of each; its order is that of the check
    of the order, where that was measured.
    """
    by_level: dict[float, list[Level]] = {}
    for row in each:
        for level in row.levels:
            by_level.setdefault(level.level, []).append(level)
    levels = tuple(_worst(by_level[h]) for h in sorted(by_level, reverse=True))
    # The bound that all hold; none if some quantity holds none.
    held = [row.bound_held for row in each if row.bound_held is not None]
    bound_held = None
    if len(held) == len(each):
        bound_held = max(held)
    orders = [finding.order_seen for finding in record.findings if finding.check == "order"]
    measured_orders = [order for order in orders if order is not None]
    constants = [row.constant for row in each if row.constant is not None]
    worst_outcome = min((row.outcome for row in each), key=WORST_FIRST.index)
    steps = tuple(_largest(levels, target) for target in TARGETS)
    return Row(
        record=record,
        quantity=WORST,
        control=each[0].control,
        levels=levels,
        outcome=worst_outcome,
        bound_held=bound_held,
        steps=steps,
        order_seen=min(measured_orders, default=None),
        order_claimed=each[0].order_claimed,
        constant=max(constants, default=None),
        seconds=_seconds_at(levels, steps[1]),
    )


def _worst(same: list[Level]) -> Level:
    """One level of all quantities: the largest error, the smallest bound."""
    return Level(
        level=same[0].level,
        error=max(x.error for x in same),
        bound=min(x.bound for x in same),
        seconds=same[0].seconds,
        counts=any(x.counts for x in same),
        steps=same[0].steps,
    )


def _largest(levels: tuple[Level, ...], target: float) -> tuple[float, bool] | None:
    """The largest step or tolerance from which on to the finest every error is at most the target,
    and True if it is the coarsest of all; None if the finest has a larger error.
    """
    largest = None
    for index in range(len(levels) - 1, -1, -1):
        if not levels[index].error <= target:
            break
        largest = index
    if largest is None:
        return None
    return (levels[largest].level, largest == 0)


def _seconds_at(levels: tuple[Level, ...], step: tuple[float, bool] | None) -> float | None:
    """The seconds that the level of a step took; None where no step holds the target."""
    if step is None:
        return None
    return next(level.seconds for level in levels if level.level == step[0])


def best_errors(rows: Iterable[Row], quantity: str) -> dict[str, float]:
    """The smallest error of each engine at its finest level."""
    best: dict[str, float] = {}
    for row in rows:
        if row.quantity == quantity:
            best[row.record.engine] = min(row.error, best.get(row.record.engine, math.inf))
    return best


def _apart(row: Row, best: dict[str, float]) -> tuple[str, float, float] | None:
    """The engine that is farthest off, and bounds on the distance; None without other engines.

    `best` is the smallest error of each engine in the quantity of the row.
    """
    others = {engine: error for engine, error in best.items() if engine != row.record.engine}
    if not others:
        return None
    name = max(sorted(others), key=lambda other: abs(others[other] - row.error))
    return name, abs(others[name] - row.error), others[name] + row.error


@dataclass(frozen=True)
class Cell:
    """One instance in one engine: the method with most correct digits (None if nothing was
    measured) and outcomes.

    `growth` is the factor by which the motion amplifies round-off, for a method that has no other
    error: its bound over the unit round-off.
    """

    digits: float | None
    method: str
    counts: dict[Outcome, int]
    growth: float = 1.0

    @property
    def worst(self) -> Outcome | None:
        """The worst outcome, None where nothing was planned."""
        return next((outcome for outcome in WORST_FIRST if outcome in self.counts), None)


def cell(contents: Contents, rows: list[Row], label: str, engine: str) -> Cell:
    """The cell of the matrix: correct digits are -log10 of the worst error at the finest level."""
    records = [record for record in contents.of(label) if record.engine == engine]
    of_engine = [row for row in worst_rows(rows) if row.record.engine == engine]
    best = min(of_engine, key=lambda row: (row.error, row.record.method), default=None)
    if best is None:
        return Cell(None, "", contents.counts(records))
    growth = 1.0
    if best.control == "exact":
        method = best.record.method
        own = [row for row in rows if (row.record.engine, row.record.method) == (engine, method)]
        growth = max(row.levels[-1].bound for row in own) / UNIT
    return Cell(digits(best.error), best.record.method, contents.counts(records), growth)


def digits(error: float) -> float:
    """Correct digits of an error in units of the scale; infinite if it is exactly 0."""
    if error > 0:
        return -math.log10(error)
    return math.inf
