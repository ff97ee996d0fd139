"""refdem gate: compares a program with certified truth and with its accepted baseline."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import options
from refdem.cli.blessing import accept, refuse_without_why, verdict
from refdem.core.outside import one_line

if TYPE_CHECKING:
    from refdem.core.finding import Sheet
    from refdem.core.resolution import Resolution
    from refdem.gate.gate import Gate

MOST_WORDS = 2000
"""Most characters of a line on the resolution of a gate: twenty numbers with their reasons."""


def command(
    toml: Annotated[Path, typer.Argument(help="Path to the refdem.toml of the program.")] = Path(
        "refdem.toml"
    ),
    baseline: Annotated[
        Path | None,
        typer.Option(help="File of the baseline; default: the one that refdem.toml names."),
    ] = None,
    bless: Annotated[
        bool, typer.Option("--bless", help="Accept the findings of this run as the baseline.")
    ] = False,
    why: Annotated[
        str, typer.Option(help="With --bless: the reason why these findings are accepted.")
    ] = "",
    junit: Annotated[Path | None, typer.Option(help="File for JUnit XML.")] = None,
    sarif: Annotated[
        Path | None,
        typer.Option(help="File for SARIF 2.1.0, which code hosts display next to a change."),
    ] = None,
    markdown: Annotated[
        Path | None, typer.Option(help="File for the Markdown summary of a pull request.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the full report.")] = None,
    resolution: Annotated[
        bool,
        typer.Option(
            "--resolution",
            help=(
                "Also report, for each number of the scenes, the smallest relative error in"
                " reading it that the gate detects. This takes about twenty more runs of the"
                " program per number."
            ),
        ),
    ] = False,
    jobs: options.Jobs = None,
) -> None:
    """Runs the gate of a program.

    Its runs are compared with certified truth, and the findings with the accepted baseline.

    Example: refdem gate --junit gate.xml --markdown gate.md
    """
    from refdem.cli.outputs import refuse_unwritable, refuse_unwritable_file
    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.cli.summary import exit_status, lines
    from refdem.gate import markdown as gate_markdown
    from refdem.gate.gate import of_program
    from refdem.report import write_report
    from refdem.report.files import written_to

    refuse_without_why(why, is_requested=bless)
    for option, file in (("--junit", junit), ("--sarif", sarif), ("--markdown", markdown)):
        refuse_unwritable_file(file, option)
    if out is not None:
        refuse_unwritable(out)
    gate = of_program(toml, baseline, workers(jobs), Progress())
    if bless:
        refuse_unwritable_file(gate.baseline, "--baseline")
    sheets = _judged(gate, bless=bless, why=why)
    print("\n".join(lines(sheets)))
    if markdown is not None:
        text = gate_markdown.markdown(gate.engine.name, sheets)
        written_to(markdown, text, "--markdown")
    _write(sheets, toml, junit, sarif)
    found = _resolutions(gate, is_requested=resolution)
    if out is not None:
        write_report(out, [*sheets, *found], gate.store)
    if os.environ.get("GITHUB_ACTIONS") == "true":
        print("\n".join(gate_markdown.annotations(sheets)))
    raise typer.Exit(_verdict(gate, exit_status(sheets)))


def _judged(gate: "Gate", *, bless: bool, why: str) -> "list[Sheet]":
    """The sheets of the gate, which become its baseline or are compared with that."""
    from refdem.core.finding import Record

    has_baseline = gate.baseline.is_file()
    # A baseline that cannot be read is refused before any program runs.
    if has_baseline:
        gate.accepted()
    sheets = gate.sheets()
    if bless:
        records = [sheet for sheet in sheets if isinstance(sheet, Record)]
        accept(gate.baseline, gate.engine.name, records, why)
    elif has_baseline:
        sheets = gate.against_baseline(sheets)
    return sheets


def _resolutions(gate: "Gate", *, is_requested: bool) -> "list[Resolution]":
    """The resolution of the gate for the numbers of its scenes, with a printed line for each case
    and method; empty unless it was requested.
    """
    if not is_requested:
        return []
    found = gate.resolution()
    for one in found:
        print(one_line(f"{one.label}, {one.method}: {one.sentence}", MOST_WORDS))
    return found


def _verdict(gate: "Gate", status: int) -> int:
    """Prints whether the gate is open, and returns the exit status: 1 if there is no baseline yet,
    else the given one.
    """
    if not gate.baseline.is_file():
        advice = (
            f"there is no baseline {gate.baseline} yet, so the gate fails; accept these findings"
            ' with: refdem gate --bless --why "first baseline"'
        )
        print(one_line(advice))
        return 1
    print(verdict([gate.engine.name], status))
    return status


def _write(sheets: "list[Sheet]", toml: Path, junit: Path | None, sarif: Path | None) -> None:
    """Writes the JUnit and the SARIF file, each if it was requested."""
    from refdem.report import write_junit, write_sarif

    if junit is not None:
        write_junit(junit, sheets)
    if sarif is not None:
        write_sarif(sarif, sheets, toml)
