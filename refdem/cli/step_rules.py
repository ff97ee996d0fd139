"""The table of `refdem advise --rules`: steps of DEM codes, the limit of stability, and errors."""

import json as encoder
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.bench.step_rules import Judged
    from refdem.planning.specification import Specification

HEADER = ("setting", "code", "what it does", "step [s]", "step / (2/omega)", "error")
TITLE = "Steps that DEM codes choose or accept, judged"
WORDS = """\
The step that a DEM code chooses, accepts without a warning or shows in its documentation, for the
contacts of each setting. Beside it stands the part that it is of 2/omega, the largest step at which
velocity Verlet is stable, and the largest error of velocity Verlet against certified truth with
that step, in the worst quantity and in units of its scale. A part above 1 is unstable: the contact
gains energy, and a larger step does not resolve it at all. An error of 0.01 is one per cent. There
is no run where a step is longer than the run.

All steps of a run have one size, as in DEM codes, and a contact begins and ends within a step: with
a step a little shorter or longer it begins at another part of one, and the error may differ by a
factor of a few.

Every rule is a formula of the code's documentation or source, which the last table names. It is
applied to refdem's scene; no code runs here. Rules with the Rayleigh time need a shear modulus,
which follows from Hertz's stiffness with Poisson's ratio 1/4."""


def refuse_without_use(options: Mapping[str, object]) -> None:
    """Raises UsageError if an option is given that means nothing with --rules."""
    given = [name for name, value in options.items() if value not in (None, [])]
    if given:
        raise UsageError(
            f"got {' and '.join(given)} with --rules, which always judges velocity Verlet in one"
            " process; expected only cases or --motion, --set, --out and --json"
        )


def print_step_rules(specification: "Specification", out: Path | None, *, json: bool) -> None:
    """Prints the table, or JSON; writes steps.md into `out` as well if it is given.

    Settings to which no rule applies are listed on standard error. Raises UsageError if there is no
    other.
    """
    from refdem.bench.step_rules import judged
    from refdem.cli.outputs import refuse_unwritable
    from refdem.core import discovery
    from refdem.report.files import written

    if out is not None:
        refuse_unwritable(out)
    found: dict[str, list[Judged]] = {}
    refused: list[UsageError] = []
    for entry in specification.case:
        instance = discovery.case(entry.id).at(**entry.set)
        try:
            found[instance.label] = judged(instance)
        except UsageError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    for reason in refused:
        print(reason, file=sys.stderr)
    if out is not None:
        written(out / "steps.md", markdown(found))
    if json:
        print(encoder.dumps(documents(found), indent=1, allow_nan=False))
    else:
        print(text(found))


def documents(found: "dict[str, list[Judged]]") -> list[dict[str, object]]:
    """The rows as they are in JSON."""
    return [
        {
            "setting": label,
            "code": one.advice.code,
            "words": one.advice.words,
            "source": one.advice.source,
            "step": one.step,
            "part": one.part,
            "error": one.error,
        }
        for label, steps in found.items()
        for one in steps
    ]


def rows(found: "dict[str, list[Judged]]") -> list[tuple[str, ...]]:
    """The cells of the table, a line a rule."""
    lines: list[tuple[str, ...]] = []
    for label, steps in found.items():
        for one in steps:
            error = "no run"
            if one.error is not None:
                error = f"{one.error:.1g}"
            part = f"{one.part:.2g}"
            if one.part > 1:
                part += ", unstable"
            lines.append((label, one.advice.code, one.advice.words, f"{one.step:.2g}", part, error))
    return lines


def text(found: "dict[str, list[Judged]]") -> str:
    """The table for a terminal."""
    cells: list[Sequence[str]] = [HEADER, *rows(found)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for line in cells:
        padded = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
        lines.append("  ".join(padded).rstrip())
    return "\n".join(lines)


def markdown(found: "dict[str, list[Judged]]") -> str:
    """The table as a page, with the source of each rule below it."""
    from refdem.bench.step_rules import ADVICE
    from refdem.core.outside import markdown_text
    from refdem.report.markdown import table

    lines = [list(map(markdown_text, row)) for row in rows(found)]
    sources = [[one.code, one.words, one.source] for one in ADVICE]
    settings = " ".join(f"'{label}'" for label in found)
    parts = [
        f"# {TITLE}",
        WORDS,
        table(list(HEADER), lines),
        "## Where the rules are written",
        table(["code", "what it does", "source"], sources),
        f"Made by `refdem advise {settings} --rules --out reports`.",
    ]
    return "\n\n".join(parts) + "\n"
