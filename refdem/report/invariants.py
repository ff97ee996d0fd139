"""What is conserved: for each law of mechanics and each engine whether the law is kept to
round-off, within an error of the step, or is lost.

A law is judged where it applies: momentum without external forces, the length of a rod where there
is one. An engine is represented by its method that conserves a law best, as in the matrix of
correct digits. Energy whose work was integrated between samples is left out, because the error of
that integration would be attributed to the engine.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from refdem.core.finding import DECIDED, Finding, Record
from refdem.core.judgement import INTEGRATED
from refdem.core.once import once_for_each
from refdem.report.contents import Contents
from refdem.report.overview import MOST_DIGITS

Verdict = Literal["kept", "approximate", "lost", "undecided"]
BEST_FIRST: tuple[Verdict, ...] = ("kept", "approximate", "undecided", "lost")
KEPT = 1e-12
"""Change, in units of the scale of what is conserved, that counts as round-off."""


@dataclass(frozen=True)
class Law:
    """A law, the check that judges it, and the quantities of that check whose value is the change.

    Where a law has several groups of quantities, the first group with a decided finding is shown:
    the energy at the finest level is preferred to that at the coarsest.
    """

    title: str
    check: str
    groups: tuple[tuple[str, ...], ...]


LAWS = (
    Law("momentum", "momentum", (("total", "pairs", "flights"),)),
    Law("angular momentum", "angular-momentum", (("total", "orbital", "spin"),)),
    Law("energy, with the work that a run reports", "energy", (("finest",), ("balance",))),
    Law("length of rods", "constraint", (("length",),)),
    Law("norm of attitudes |q| = 1", "quaternion-norm", (("norm",),)),
    Law("time reversal: back to the start", "reversal", (("reversed",),)),
)


@dataclass(frozen=True)
class Conserved:
    """How one engine keeps one law in one setting: the verdict, the largest change in units of the
    scale, and the order with which the change decreases; None where unknown.

    `at_default` is the change at the default step of the engine, extrapolated from the finest step
    with that order; None where the change is round-off, or the engine has no default step.
    """

    verdict: Verdict
    change: float | None
    order: float | None
    label: str
    method: str
    at_default: float | None = None

    @property
    def digits(self) -> float:
        """Digits of the conserved quantity that do not change, at most 16; all 16 where the law is
        kept to round-off.
        """
        if self.verdict == "kept" or not self.change:
            return MOST_DIGITS
        return -math.log10(self.change)

    @property
    def rank(self) -> tuple[int, float]:
        """Sorts the better before the worse."""
        return BEST_FIRST.index(self.verdict), self.change or 0.0


@dataclass(frozen=True)
class Summary:
    """How one engine keeps one law in all settings in which that was judged."""

    settings: tuple[Conserved, ...]

    @cached_property
    def counts(self) -> dict[Verdict, int]:
        """The number of settings with each verdict, without zeros."""
        verdicts = [one.verdict for one in self.settings]
        return {name: verdicts.count(name) for name in BEST_FIRST if name in verdicts}

    @property
    def kept(self) -> int:
        """The number of settings in which the law is kept to round-off."""
        return self.counts.get("kept", 0)

    @property
    def digits(self) -> float:
        """The share of the settings in which the law is kept, times 16, for the shade of a cell."""
        return MOST_DIGITS * self.kept / len(self.settings)

    @property
    def largest_error(self) -> Conserved | None:
        """The setting with the largest error among those in which the law is not kept to
        round-off.
        """
        approximate = [one for one in self.settings if one.verdict == "approximate"]
        return max(approximate, key=lambda one: one.rank, default=None)

    @property
    def at_default(self) -> float | None:
        """The largest change at the default step of the engine; None where that is not known."""
        known = [one.at_default for one in self.settings if one.at_default is not None]
        return max(known, default=None)


@dataclass(frozen=True)
class LawSheet:
    """One law: a summary for each engine, and for each case the worst of its settings by engine."""

    law: Law
    summaries: Mapping[str, Summary]
    cases: Mapping[str, Mapping[str, Conserved]]


@once_for_each
def law_sheets(contents: Contents) -> list[LawSheet]:
    """A sheet for each law that is judged in at least one setting."""
    titles = {sheet.label: sheet.title for sheet in contents.cases}
    default_steps = {engine.engine: engine.default_step for engine in contents.engines}
    sheets = []
    for law in LAWS:
        found = _settings(contents.records, law, default_steps)
        if not found:
            continue
        summaries = {
            engine.engine: Summary(
                tuple(one for (_, name), one in found.items() if name == engine.engine)
            )
            for engine in contents.engines
        }
        cases: dict[str, dict[str, Conserved]] = {}
        for (label, engine_name), one in found.items():
            line = cases.setdefault(titles[label], {})
            line[engine_name] = max(one, line.get(engine_name, one), key=lambda each: each.rank)
        sheets.append(LawSheet(law, summaries, cases))
    return sheets


def _settings(
    records: Iterable[Record], law: Law, default_steps: Mapping[str, float | None]
) -> dict[tuple[str, str], Conserved]:
    """How each engine keeps a law in each setting in which that was judged, by its best method; by
    label and engine.
    """
    found: dict[tuple[str, str], Conserved] = {}
    for record in records:
        one = _conserved(record, law, default_steps.get(record.engine))
        if one is None:
            continue
        place = record.label, record.engine
        found[place] = min(one, found.get(place, one), key=lambda each: each.rank)
    return found


def _conserved(record: Record, law: Law, default_step: float | None) -> Conserved | None:
    """How one method keeps a law; None where that was not judged."""
    judged = [
        finding
        for finding in record.findings
        if finding.check == law.check
        and finding.outcome != "unsupported"
        and INTEGRATED not in finding.basis
    ]
    if not judged:
        return None
    change = _change(judged, law)
    verdict = _verdict(judged, change)
    order = _order(record.findings)
    at_default = None
    if verdict == "approximate" and change is not None and order is not None:
        at_default = _at_step(change, order, _steps(record.findings), default_step)
    return Conserved(
        verdict=verdict,
        change=change,
        order=order,
        label=record.label,
        method=record.method,
        at_default=at_default,
    )


def _at_step(change: float, order: float, steps: list[float], step: float | None) -> float | None:
    """The change at a step [s], extrapolated from the finest one: change ~ h^p, and at least
    round-off.

    None for a step that is larger than all that ran, where the order may not hold.
    """
    if not steps or step is None or step > max(steps):
        return None
    ratio = math.pow(step / min(steps), order)
    return max(KEPT, change * ratio)


def _steps(findings: Iterable[Finding]) -> list[float]:
    """The steps [s] of which an error was measured; none for a method without steps."""
    return [
        level.level
        for finding in findings
        if finding.check == "error" and finding.order_claimed is not None
        for level in finding.levels
        if level.level > 0
    ]


def _change(judged: list[Finding], law: Law) -> float | None:
    """The largest change of what is conserved; None if no group of quantities was decided."""
    for group in law.groups:
        values = [
            finding.value
            for finding in judged
            if finding.quantity in group
            and finding.outcome in DECIDED
            and finding.value is not None
        ]
        if values:
            return max(values)
    return None


def _verdict(judged: list[Finding], change: float | None) -> Verdict:
    """Lost where some finding does not pass; else by the size of the change."""
    outcomes = {finding.outcome for finding in judged}
    if outcomes - {"pass", "undecided"}:
        return "lost"
    if change is None:
        return "undecided"
    if change <= KEPT:
        return "kept"
    return "approximate"


def _order(findings: Iterable[Finding]) -> float | None:
    """The observed order of convergence of the method; None if the order was not judged."""
    for finding in findings:
        if finding.check == "order" and finding.outcome == "pass":
            return finding.order_claimed
    return None
