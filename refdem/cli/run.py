"""refdem run: cases in engines, judged, reported."""

import os
import time
from pathlib import Path
from typing import Annotated

import typer

from refdem.errors import UsageError


def command(
    case: Annotated[list[str] | None, typer.Argument(help="Cases, also as `pendulum[theta0=2]`; none: the campaign.")] = None,
    engine: Annotated[list[str] | None, typer.Option(help="Engines; none: all that are installed.")] = None,
    method: Annotated[str, typer.Option(help="Only this method of the engine.")] = "",
    step: Annotated[float | None, typer.Option(help="First step [s]; refinement goes on from there.")] = None,
    steps_per_tau: Annotated[float | None, typer.Option(help="First step as steps per shortest time.")] = None,
    set: Annotated[list[str] | None, typer.Option(help="Parameter of the cases, name=value.")] = None,
    campaign: Annotated[str, typer.Option(help="Campaign to run when no case is named.")] = "main",
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("refdem-report"),
    jobs: Annotated[int, typer.Option(help="Worker processes; 0: one a core.")] = 0,
    no_cache: Annotated[bool, typer.Option("--no-cache", help="Read no stored runs.")] = False,
) -> None:
    """Runs cases in engines and writes a report.

    Example: refdem run pendulum --set theta0=2 --engine reference --engine mujoco --out report
    """
    from refdem.campaign.campaign import Campaign
    from refdem.campaign.specification import Entry, Specification, named
    from refdem.cli.progress import Progress
    from refdem.cli.summary import exit_status, lines
    from refdem.core.parameters import labelled, settings
    from refdem.core.store import Store, default_path
    from refdem.report import write_report

    if jobs < 0:
        raise UsageError(f"--jobs is {jobs}; expected a number >= 1, or 0 for one a core")
    if step is not None and steps_per_tau is not None:
        raise UsageError("--step and --steps-per-tau both came; expected at most one of them")
    start = time.perf_counter()
    given = settings(set or [])
    if not case and given:
        raise UsageError("--set came without a case; name the case, as in `refdem run pendulum --set theta0=2`")
    entries = [Entry(name, own | given) for name, own in map(labelled, case or [])]
    base = Specification(name="run", case=entries) if entries else named(campaign)
    specification = replaced(base, engine or base.engines, method, step, steps_per_tau)
    refuse_unwritable(out)
    store = Store(default_path())
    sheets = Campaign(specification, store, jobs or os.cpu_count() or 1, not no_cache, Progress()).sheets()
    write_report(out, sheets, store)
    print("\n".join(lines(sheets)))
    print(f"report: {out / 'index.html'} ({time.perf_counter() - start:.1f} s in all)")
    raise typer.Exit(exit_status(sheets))


def replaced(base, engines, method, step, steps_per_tau):  # type: ignore[no-untyped-def]
    """The specification with what the command line overrules."""
    import msgspec

    return msgspec.structs.replace(base, engines=list(engines), method=method, step=step, steps_per_tau=steps_per_tau)


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
