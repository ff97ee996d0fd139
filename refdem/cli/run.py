"""refdem run: cases in engines, judged, reported."""

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import completion, options
from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.core.finding import Sheet
    from refdem.core.moved import Moved
    from refdem.core.store import Store
    from refdem.planning.specification import Specification


def command(
    case: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.cases,
            help=(
                "Cases such as `pendulum` or `pendulum[theta0=2]`; default: those of the campaign."
            ),
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Run only this method of each engine.")] = "",
    step: Annotated[
        float | None, typer.Option(help="Largest step [s]. Each refinement halves the step.")
    ] = None,
    steps_per_tau: Annotated[
        float | None,
        typer.Option(help="Largest step, given as the number of steps per shortest time tau."),
    ] = None,
    set: options.Settings = None,
    campaign: Annotated[
        str,
        typer.Option(
            help=(
                "Campaign: a name or a TOML file. If cases are named as well, only these cases of"
                " the campaign run. Default without cases: main."
            )
        ),
    ] = "",
    bless: Annotated[
        bool,
        typer.Option(
            "--bless",
            help=(
                "Record the findings that are decided in this run as those that the campaign must"
                " decide, and show the changes."
            ),
        ),
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("refdem-report"),
    jobs: options.Jobs = None,
    scheduler: options.Scheduler = None,
    no_cache: Annotated[
        bool, typer.Option("--no-cache", help="Ignore stored runs and compute all of them.")
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print the outcome as JSON instead of the summary.")
    ] = False,
) -> None:
    """Runs cases in engines, judges the runs, and writes a report.

    If some of several named engines are not installed, the others run. A message at the end
    explains how to install each missing one, and the exit status is 2 if nothing else failed.

    Example: refdem run pendulum --set theta0=2 --engine reference --engine mujoco --out report
    """
    import msgspec

    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.summary import exit_status, lines, printed_json
    from refdem.cli.without_effect import of_settings
    from refdem.core.store import Store, default_path
    from refdem.planning.campaign import Campaign
    from refdem.planning.plan import present
    from refdem.report import resolution, write_report

    start = time.perf_counter()
    if step is not None and steps_per_tau is not None:
        raise UsageError("got both --step and --steps-per-tau; expected at most one of them")
    address = options.scheduler_address(scheduler)
    base = specification_of(case or [], set or [], campaign)
    refuse_partial(base, bless, method or step or steps_per_tau)
    # Options that are not given keep the values of the campaign.
    given = {"engines": engine, "method": method, "step": step, "steps_per_tau": steps_per_tau}
    overruled = {name: value for name, value in given.items() if value not in (None, "", [])}
    specification = msgspec.structs.replace(base, **overruled)
    count = workers(jobs)
    specification, absent = present(specification)
    refuse_unwritable(out)
    measured = resolution.read(out)
    store = Store(default_path())
    if bless:
        specification = msgspec.structs.replace(specification, required="")
    progress = Progress()
    whole = Campaign(specification, store, count, not no_cache, progress, address)
    sheets = whole.sheets()
    moved = of_single_case(specification, store)
    resolutions = resolution.of_records(measured, sheets)
    write_report(out, [*sheets, *resolutions, *moved], store)
    changes = []
    if bless:
        changes = blessed(base, sheets)
    without_effect = []
    if not campaign:
        without_effect = of_settings(specification, store)
    if json:
        print(printed_json(sheets, out / "index.html", changes, absent, without_effect))
    else:
        print("\n".join([*lines(sheets), *without_effect, *changes, *absent]))
        print(f"report: {out / 'index.html'} ({time.perf_counter() - start:.1f} s in all)")
    raise typer.Exit(exit_status(sheets, absent))


def of_single_case(specification: "Specification", store: "Store") -> "list[Moved]":
    """The sensitivities to each number of the case, for the report of a single case."""
    from refdem.planning import moved

    return moved.sheets(specification, store)


def specification_of(cases: list[str], pairs: list[str], campaign: str) -> "Specification":
    """The named cases with parameters, or the campaign, or the named cases of the campaign; raises
    UsageError for parameters without a case.
    """
    from refdem.core.parameters import labelled, settings
    from refdem.planning.specification import Entry, Specification, named

    given = settings(pairs)
    if not cases and given:
        raise UsageError("--set requires a case, as in `refdem run pendulum --set theta0=2`")
    if not cases:
        return named(campaign or "main")
    if campaign:
        return part(named(campaign), cases, given)
    entries = []
    for label in cases:
        name, of_label = labelled(label)
        entries.append(Entry(name, of_label | given))
    return Specification(name="run", case=entries)


def part(whole: "Specification", cases: list[str], given: dict[str, str]) -> "Specification":
    """A campaign without the cases that were not named; raises UsageError for one that it does not
    have.
    """
    import msgspec

    from refdem.core.parameters import labelled, nearest

    if given:
        raise UsageError(
            "--set cannot be combined with --campaign, whose cases set their own parameters; omit"
            " one of them"
        )
    chosen = []
    for label in cases:
        name, of_label = labelled(label)
        # A bare name means all settings of that case.
        entries = [entry for entry in whole.case if entry.id == name]
        if of_label:
            entries = [entry for entry in entries if entry.set == of_label]
        if not entries:
            raise UsageError(
                f"campaign {whole.name} has no {label!r};"
                f" {nearest(name, {entry.id for entry in whole.case})}"
            )
        chosen += [entry for entry in entries if entry not in chosen]
    return msgspec.structs.replace(whole, case=chosen, is_part=True)


def refuse_partial(specification: "Specification", bless: bool, other: str | float | None) -> None:
    """Raises UsageError if a list of findings is to be written for part of a campaign only."""
    if bless and (not specification.required or specification.is_part or other):
        raise UsageError(
            "--bless is for a whole campaign: give --campaign, and neither cases nor --method nor a"
            " step"
        )


def blessed(specification: "Specification", sheets: "list[Sheet]") -> list[str]:
    """Writes the lists of findings that a campaign must make, one for each engine that ran; returns
    the changes, a line each.
    """
    from refdem.core.finding import Record
    from refdem.planning import required

    return required.written(specification, [sheet for sheet in sheets if isinstance(sheet, Record)])


def workers(jobs: int | None) -> int:
    """How many worker processes; raises UsageError for less than one."""
    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs is {jobs}; expected a number >= 1")
    return jobs or os.cpu_count() or 1
