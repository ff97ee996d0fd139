"""refdem compare: engines beside each other in the same cases."""

import math
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import completion, options
from refdem.cli.advise import (
    CHECKS,
    MOST_DIGITS,
    count_text,
    measured,
    requested_campaign,
    shown,
    unmeasured,
)

if TYPE_CHECKING:
    from refdem.core.finding import Record
    from refdem.report.advice import Recommendation
    from refdem.report.contents import Contents

LAWS = ("momentum", "angular-momentum", "energy")
"""Checks of conservation laws, in the order of the columns."""
WORDS = {
    "pass": "holds",
    "fail": "FAILS",
    "error": "BROKE",
    "expected": "known deviation",
    "undecided": "undecided",
    "unsupported": "not supported",
}
"""The text of a column for the worst outcome of a law."""


def command(
    engine: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.engines,
            help="Engines, or paths to refdem.toml files; default: all installed engines.",
        ),
    ] = None,
    case: Annotated[
        list[str] | None,
        typer.Option(
            autocompletion=completion.cases,
            help="Cases such as `pendulum` or `pendulum[theta0=2]`.",
        ),
    ] = None,
    motion: Annotated[
        str,
        typer.Option(
            autocompletion=completion.motions,
            help="Kind of motion, as for `refdem advise`. Selects all cases with this motion.",
        ),
    ] = "",
    digits: Annotated[
        float,
        typer.Option(
            help="Number of correct digits at which costs are compared.", min=0.0, max=MOST_DIGITS
        ),
    ] = 3.0,
    set: options.Settings = None,
    jobs: options.Jobs = None,
) -> None:
    """Compares engines on the same cases.

    The table shows error, order, cost and conserved quantities.

    Exit status 1 if a check of a conservation law that an engine claims failed, 2 if nothing was
    measured.

    Example: refdem compare mujoco pymunk rebound --case pendulum
    """
    specification = requested_campaign(case or [], set or [], motion)
    contents = measured(specification, engine or [], jobs, (*CHECKS, *LAWS))
    printed = []
    for sheet in contents.cases:
        printed += [*table(contents, sheet.label, digits), ""]
    without = unmeasured(contents)
    if without:
        printed += [*without, ""]
    printed.append(answer(contents, digits))
    print("\n".join(map(shown, printed)).strip())
    counts = contents.counts()
    if "pass" not in counts and "fail" not in counts:
        raise typer.Exit(2)
    raise typer.Exit(int("fail" in counts))


def table(contents: "Contents", label: str, digits: float) -> list[str]:
    """One case: a row a method, the cheapest at the wanted digits first."""
    from refdem.report.advice import choices
    from refdem.report.tolerance import rows_of, worst_rows

    own = {
        choice.name: choice for choice in choices(contents, digits) if choice.record.label == label
    }
    rows = worst_rows(rows_of(contents, label))
    rows.sort(key=lambda row: (own[f"{row.record.engine}/{row.record.method}"].cost, row.series))
    head = ("method", "digits", "order", "step", "cost [s/s]", *LAWS)
    cells: list[tuple[str, ...]] = [head]
    for row in rows:
        choice = own[f"{row.record.engine}/{row.record.method}"]
        cells.append(
            (
                choice.name,
                digits_of(min(level.error for level in row.levels)),
                order_of(row.order_seen, row.order_claimed),
                step_of(choice.level, choice.control, choice.is_extrapolated),
                cost_of(choice.cost),
                *(law_of(row.record, law) for law in LAWS),
            )
        )
    widths = [max(len(line[column]) for line in cells) for column in range(len(head))]
    lines = [
        f"{label}: step and cost for {digits:g} digits; digits: the most that were measured;"
        " order: measured of claimed"
    ]
    for line in cells:
        padded = [text.ljust(width) for text, width in zip(line, widths, strict=True)]
        lines.append("  " + "  ".join(padded).rstrip())
    return lines


def digits_of(error: float) -> str:
    """Correct digits of an error, at most those of binary64."""
    from refdem.report.tolerance import digits

    return f"{min(digits(error), MOST_DIGITS + 1):.1f}"


def order_of(measured: float | None, claimed: float | None) -> str:
    """The measured order and the claimed one."""
    if claimed is None:
        return ""
    if measured is None:
        return f"? of {claimed:g}"
    return f"{measured:.2f} of {claimed:g}"


def step_of(level: float | None, control: str, is_extrapolated: bool) -> str:
    """The step [s], or the tolerance, that holds the digits."""
    if level is None:
        return "none"
    if control == "exact":
        return "any"
    if control == "tolerance":
        return f"tol {level:.2g}"
    if is_extrapolated:
        return f"~{level:.2g} s"
    return f"{level:.2g} s"


def cost_of(cost: float) -> str:
    """Seconds of computing for a second of motion."""
    if math.isinf(cost):
        return ""
    return f"{cost:.1e}"


def law_of(record: "Record", law: str) -> str:
    """The worst outcome of a law in a record, as text."""
    from refdem.core.finding import WORST_FIRST

    outcomes = {finding.outcome for finding in record.findings if finding.check == law}
    worst = next((outcome for outcome in WORST_FIRST if outcome in outcomes), None)
    if worst is None:
        return "-"
    return WORDS.get(worst, worst)


def answer(contents: "Contents", digits: float) -> str:
    """One sentence: the method that holds the digits in the most settings, among these the
    cheapest, and the best method of each other engine for comparison.

    It is empty if nothing was measured.
    """
    from refdem.report.advice import choices, recommendations

    best: dict[str, Recommendation] = {}
    for one in recommendations(choices(contents, digits)):
        best.setdefault(one.engine, one)
    if not best:
        return ""
    first, *others = best.values()
    settings = len(contents.cases)
    opening = f"For {digits:g} digits in {count_text(settings, 'setting')}"
    if not first.held:
        return f"{opening}: no method holds them in any."
    name = f"{first.engine}/{first.method}"
    if len(first.held) == settings:
        parts = [f"{name} costs least"]
    else:
        parts = [f"{name} holds them in most, in {len(first.held)}"]
    parts += [_beside(first, other) for other in others]
    return f"{opening}: {'; '.join(parts)}."


def _beside(first: "Recommendation", other: "Recommendation") -> str:
    """How the best method of another engine compares with the first one."""
    name = f"{other.engine}/{other.method}"
    if not other.held:
        return f"{other.engine} does not hold them in any"
    if len(other.held) < len(first.held):
        return f"{name} holds them in {len(other.held)}"
    return f"{name} takes {times(other.cost / first.cost)} as long"


def times(ratio: float) -> str:
    """A ratio to two digits, in whole numbers from ten on: `1.4 times`, `450 times`."""
    if ratio < 10:
        return f"{ratio:.2g} times"
    return f"{float(f'{ratio:.2g}'):,.0f} times"
