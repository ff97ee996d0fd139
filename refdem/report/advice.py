"""Which method and which step hold a number of correct digits, from the errors that a campaign
measured.

Errors are in units of the scale of each quantity, the largest over the run and over all quantities;
d digits are held where the error is at most 10^-d.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from refdem.core.finding import CaseSheet, Level, Record
from refdem.report.contents import Contents
from refdem.report.tolerance import Control, Row, rows_of, worst_rows

FINER = 100.0
"""Largest ratio of the smallest step that ran to an extrapolated step. Below that, round-off may
dominate the error, and the measured order need not hold.
"""
LEAST_ORDER = 0.5
"""Smallest observed order of convergence at which errors are extrapolated to smaller steps."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """The largest step [s], or tolerance, with which one method holds the digits in one setting.

    `level` is None where none does; `error` is then the smallest that was measured. `cost` is the
    time [s] of computing for one second of motion. `steps_taken` is the number of steps per tau in
    the run of that level; None where the engine did not count them, or where the step is
    extrapolated. An extrapolated step is smaller than all that ran; it and its cost follow from the
    measured order. `is_coarsest` is true where no larger step ran.
    """

    record: Record
    control: Control
    tau: float
    level: float | None
    error: float
    cost: float
    steps_taken: float | None = None
    is_extrapolated: bool = False
    is_coarsest: bool = False

    @property
    def name(self) -> str:
        """The engine and its method, as `mujoco/rk4`."""
        return f"{self.record.engine}/{self.record.method}"

    @property
    def steps_per_tau(self) -> float | None:
        """How many steps the shortest time tau of the setting has; None without a step."""
        if self.level is None or self.control != "step":
            return None
        return self.tau / self.level


@dataclass(frozen=True, kw_only=True)
class Loss:
    """The error of one method in one setting at the step [s] that its engine takes by default.

    `finding` is the id of the finding on the worst quantity. The error is interpolated between
    measured ones. Where the default step is larger than all that ran, `error` is a lower bound;
    where it is smaller than all, the error is extrapolated with the measured order.
    """

    record: Record
    step: float
    error: float
    finding: str
    is_least: bool = False
    is_extrapolated: bool = False


def choices(contents: Contents, digits: float) -> list[Choice]:
    """One choice for every method of every engine in every setting whose error was measured."""
    found = []
    for case in contents.cases:
        if not case.scales:
            continue
        for row in worst_rows(rows_of(contents, case.label)):
            found.append(_choice(case, row, 10.0**-digits))
    return found


def _choice(case: CaseSheet, row: Row, target: float) -> Choice:
    """The choice of one method in one setting for an error of at most `target`."""
    tau = case.scales["tau"]
    duration = case.scales["T"]
    levels = row.levels
    holding = _coarsest_holding(levels, target)
    finest = levels[-1]
    if holding is not None:
        chosen = levels[holding]
        return Choice(
            record=row.record,
            control=row.control,
            tau=tau,
            level=chosen.level,
            error=chosen.error,
            cost=chosen.seconds / duration,
            steps_taken=_steps_taken(chosen, tau / duration),
            is_coarsest=holding == 0,
        )
    # error ~ h^p, so that the step for an error e is h_f (e/e_f)^(1/p), with the finest f.
    order = _order(row)
    if row.control == "step" and order is not None:
        ratio = (target / finest.error) ** (1 / order)
        if ratio * FINER >= 1:
            return Choice(
                record=row.record,
                control=row.control,
                tau=tau,
                level=finest.level * ratio,
                error=target,
                cost=finest.seconds / duration / ratio,
                is_extrapolated=True,
            )
    return Choice(
        record=row.record,
        control=row.control,
        tau=tau,
        level=None,
        error=min(level.error for level in levels),
        cost=math.inf,
    )


def _steps_taken(level: Level, part: float) -> float | None:
    """The steps of a run in this part of its duration, None where they were not counted."""
    if not level.steps:
        return None
    return level.steps * part


def _coarsest_holding(levels: tuple[Level, ...], target: float) -> int | None:
    """The index of the coarsest level such that it and all finer ones have errors of at most the
    target; None if the error of the finest level is larger.
    """
    holding = None
    for number in range(len(levels) - 1, -1, -1):
        if not levels[number].error <= target:
            break
        holding = number
    return holding


def _order(row: Row) -> float | None:
    """The order with which errors are extrapolated: the smaller of the measured and the claimed."""
    measured = row.order_seen
    if measured is None or measured < LEAST_ORDER:
        return None
    if row.order_claimed is None:
        return measured
    return min(measured, row.order_claimed)


@dataclass(frozen=True, kw_only=True)
class Recommendation:
    """One method in all of its settings: the step that holds the digits in every one of them, in
    units of the shortest time, and the cost of all.

    `missed` are the choices where no step holds them; `extrapolated` counts the steps that did not
    run.
    """

    engine: str
    method: str
    control: Control
    held: tuple[Choice, ...]
    missed: tuple[Choice, ...]

    @property
    def holds(self) -> bool:
        """True if the method holds the digits in every setting."""
        return not self.missed

    @property
    def steps_per_tau(self) -> float | None:
        """Steps in the shortest time, enough for every setting in which some step holds."""
        return max(
            (choice.steps_per_tau for choice in self.held if choice.steps_per_tau is not None),
            default=None,
        )

    @property
    def chooses_steps(self) -> bool:
        """True for a method that has neither step nor tolerance and takes steps all the same."""
        return any(choice.steps_taken for choice in self.held) and self.control == "exact"

    @property
    def most_steps_per_tau(self) -> float:
        """Steps per shortest time in the setting that needs most of them.

        With a fixed step they follow from the recommended step. A method that chooses its own steps
        has them counted during the run; where they were not counted, they are taken as 0 for an
        exact method and as infinitely many for one controlled by a tolerance.
        """
        return max((_steps_of(choice) for choice in self.held), default=math.inf)

    @property
    def tolerance(self) -> float | None:
        """The tolerance that is enough for every setting, of a method controlled by one."""
        if self.control != "tolerance":
            return None
        return min((choice.level for choice in self.held if choice.level is not None), default=None)

    @property
    def cost(self) -> float:
        """Time [s] of computing for one second of motion, the largest of all settings."""
        return max((choice.cost for choice in self.held), default=math.inf)

    @property
    def extrapolated(self) -> int:
        """How many of the steps are smaller than all that ran."""
        return sum(choice.is_extrapolated for choice in self.held)


def _steps_of(choice: Choice) -> float:
    """Steps in one tau by which methods are compared."""
    if choice.steps_per_tau is not None:
        return choice.steps_per_tau
    if choice.steps_taken is not None:
        return choice.steps_taken
    if choice.control == "exact":
        return 0.0
    return math.inf


def recommendations(found: Iterable[Choice]) -> list[Recommendation]:
    """One for every method: first those that hold the digits in most settings, of these the
    cheapest first.
    """
    of_method: dict[tuple[str, str], list[Choice]] = {}
    for choice in found:
        of_method.setdefault((choice.record.engine, choice.record.method), []).append(choice)
    every = []
    for (engine, method), own in of_method.items():
        held = tuple(choice for choice in own if choice.level is not None)
        missed = tuple(choice for choice in own if choice.level is None)
        every.append(
            Recommendation(
                engine=engine,
                method=method,
                control=own[0].control,
                held=held,
                missed=missed,
            )
        )
    return sorted(every, key=lambda one: (-len(one.held), one.cost, one.engine, one.method))


def losses(contents: Contents) -> list[Loss]:
    """The largest error of each method with a fixed step at the default step of its engine.

    There is one entry for each method, on the setting where its error is largest. Engines without
    a default step are left out.
    """
    found: dict[tuple[str, str], Loss] = {}
    default_steps = {engine.engine: engine.default_step for engine in contents.engines}
    for case in contents.cases:
        for row in worst_rows(rows_of(contents, case.label)):
            step = default_steps.get(row.record.engine)
            if step is None or row.control != "step":
                continue
            loss = _loss(row, step)
            method = (row.record.engine, row.record.method)
            if method not in found or loss.error > found[method].error:
                found[method] = loss
    return [found[method] for method in sorted(found)]


def _loss(row: Row, step: float) -> Loss:
    """The error of a run with this step [s]."""
    coarsest = row.levels[0]
    finest = row.levels[-1]
    finding = _finding_of_worst(row, step)
    if step > coarsest.level:
        return Loss(
            record=row.record, step=step, error=coarsest.error, finding=finding, is_least=True
        )
    if step < finest.level:
        order = _order(row) or 0.0
        error = finest.error * (step / finest.level) ** order
        return Loss(
            record=row.record, step=step, error=error, finding=finding, is_extrapolated=True
        )
    return Loss(record=row.record, step=step, error=_interpolated(row, step), finding=finding)


def _interpolated(row: Row, step: float) -> float:
    """The error at a step between two that ran, interpolated linearly in log(error), log(step)."""
    for coarse, fine in zip(row.levels, row.levels[1:], strict=False):
        if not fine.level <= step <= coarse.level:
            continue
        if coarse.error <= 0 or fine.error <= 0:
            return max(coarse.error, fine.error)
        part = math.log(step / fine.level) / math.log(coarse.level / fine.level)
        return math.exp((1 - part) * math.log(fine.error) + part * math.log(coarse.error))
    return row.levels[0].error


def _finding_of_worst(row: Row, step: float) -> str:
    """The id of the finding on the quantity whose error is largest near a step."""
    errors = [found for found in row.record.findings if found.check == "error" and found.levels]

    def near(levels: tuple[Level, ...]) -> float:
        return min(levels, key=lambda level: abs(math.log(level.level / step))).error

    return row.record.id(max(errors, key=lambda found: near(found.levels)))


def without(contents: Contents) -> dict[str, list[str]]:
    """The labels of the settings in which no method of an engine was measured, by engine."""
    missing: dict[str, list[str]] = {}
    for case in contents.cases:
        measured = {row.record.engine for row in rows_of(contents, case.label)}
        for engine in contents.engines:
            if engine.engine not in measured:
                missing.setdefault(engine.engine, []).append(case.label)
    return missing
