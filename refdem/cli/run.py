"""refdem run: cases in engines, judged, reported."""

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.campaign.specification import Specification


def command(
    case: Annotated[list[str] | None, typer.Argument(help="Cases, also as `pendulum[theta0=2]`; none: the campaign.")] = None,
    engine: Annotated[list[str] | None, typer.Option(help="Engines, or paths of refdem.toml; none: all installed.")] = None,
    method: Annotated[str, typer.Option(help="Only this method of the engine.")] = "",
    step: Annotated[float | None, typer.Option(help="First step [s]; refinement goes on from there.")] = None,
    steps_per_tau: Annotated[float | None, typer.Option(help="First step as steps per shortest time.")] = None,
    set: Annotated[list[str] | None, typer.Option(help="Parameter of the cases, name=value.")] = None,
    campaign: Annotated[str, typer.Option(help="Campaign to run when no case is named; a name, or a TOML file.")] = "main",
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("refdem-report"),
    jobs: Annotated[int | None, typer.Option(help="Worker processes; default: one a core.")] = None,
    no_cache: Annotated[bool, typer.Option("--no-cache", help="Read no stored runs.")] = False,
) -> None:
    """Runs cases in engines and writes a report.

    Example: refdem run pendulum --set theta0=2 --engine reference --engine mujoco --out report
    """
    import msgspec

    from refdem.campaign.campaign import Campaign
    from refdem.cli.progress import Progress
    from refdem.cli.summary import exit_status, lines
    from refdem.core.store import Store, default_path
    from refdem.report import write_report

    start = time.perf_counter()
    if step is not None and steps_per_tau is not None:
        raise UsageError("--step and --steps-per-tau both came; expected at most one of them")
    base = asked_for(case or [], set or [], campaign)
    overruled = {"engines": engine or base.engines, "method": method, "step": step, "steps_per_tau": steps_per_tau}
    specification = msgspec.structs.replace(base, **overruled)
    count = workers(jobs)
    refuse_unwritable(out)
    store = Store(default_path())
    sheets = Campaign(specification, store, count, not no_cache, Progress()).sheets()
    write_report(out, sheets, store)
    print("\n".join(lines(sheets)))
    print(f"report: {out / 'index.html'} ({time.perf_counter() - start:.1f} s in all)")
    raise typer.Exit(exit_status(sheets))


def asked_for(cases: list[str], pairs: list[str], campaign: str) -> "Specification":
    """The cases named, with parameters, or else the campaign; raises UsageError for parameters without a case."""
    from refdem.campaign.specification import Entry, Specification, named
    from refdem.core.parameters import labelled, settings

    given = settings(pairs)
    if not cases and given:
        raise UsageError("--set came without a case; name the case, as in `refdem run pendulum --set theta0=2`")
    if not cases:
        return named(campaign)
    return Specification(name="run", case=[Entry(name, own | given) for name, own in map(labelled, cases)])


def workers(jobs: int | None) -> int:
    """How many worker processes; raises UsageError for less than one."""
    if jobs is not None and jobs < 1:
        raise UsageError(f"--jobs is {jobs}; expected a number >= 1")
    return jobs or os.cpu_count() or 1


def refuse_unwritable(folder: Path) -> None:
    """Raises StoreError before any work is done if the report cannot be written."""
    from refdem.errors import StoreError

    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".refdem-probe"
        probe.write_text("")
        probe.unlink()
    except OSError as error:
        raise StoreError(f"folder {folder} cannot be written: {error.strerror}. Choose another with --out.") from None
