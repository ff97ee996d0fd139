"""refdem stress: scenes of increasing difficulty, until a method fails."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import completion, options

if TYPE_CHECKING:
    from refdem.core.store import Store
    from refdem.report.markdown import Cells
    from refdem.report.stress import Section
    from refdem.stress.record import StressRecord
    from refdem.stress.tables import Table

TITLE = "Numerical stability"


def command(
    case: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.cases,
            help=(
                "Run only sweeps on these cases, such as `pendulum` or `pendulum[theta0=2]`;"
                " default: all."
            ),
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Run only this method of each engine.")] = "",
    battery: Annotated[
        list[str] | None, typer.Option(help="Run only these batteries; default: all.")
    ] = None,
    require: Annotated[
        bool,
        typer.Option(
            "--require",
            help="Require of every engine the ranges that are promised for the reference.",
        ),
    ] = False,
    longest: Annotated[
        float,
        typer.Option(
            help=(
                "Longest forecast of a run time [s]. Runs with a longer forecast are skipped."
                " Raise it for runs of up to 1e8 steps."
            )
        ),
    ] = 5.0,
    timeout: Annotated[
        float,
        typer.Option(
            help=(
                "Time limit of a run [s]. A run that exceeds it is killed and counts as an error."
            )
        ),
    ] = 20.0,
    jobs: options.Jobs = None,
    out: Annotated[
        Path, typer.Option(help="Folder for stress.md, stress.html, stress.json.")
    ] = Path("refdem-stress"),
    json: Annotated[bool, typer.Option("--json", help="Print the record as JSON.")] = False,
) -> None:
    """Finds where methods fail: scenes become harder step by step.

    Exit status 1 if a method fails within a promised range, 3 if it only crashes or hangs there, 2
    if nothing was judged.

    Example: refdem stress two-spheres --engine reference --engine refdem.toml --battery mass-ratio
    --battery frame
    """
    import msgspec

    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.core.parameters import labelled
    from refdem.core.store import Store, default_path
    from refdem.planning.specification import Entry
    from refdem.stress.selection import batteries
    from refdem.stress.session import Stress
    from refdem.stress.tables import lines

    chosen = batteries(
        battery or [], [Entry(name, given) for name, given in map(labelled, case or [])]
    )
    refuse_unwritable(out)
    store = Store(default_path())
    record = Stress(
        chosen,
        store,
        engines=engine or [],
        method=method,
        jobs=workers(jobs),
        timeout=timeout,
        longest=longest,
        require=require,
        progress=Progress(),
    ).record()
    (out / "stress.json").write_bytes(msgspec.json.encode(record))
    written(out, record, store)
    if json:
        print(msgspec.json.encode(record).decode())
    else:
        print("\n".join([*lines(record), f"stress: {out / 'stress.html'}"]))
    raise typer.Exit(status(record))


def status(record: "StressRecord") -> int:
    """The exit status: 1 if a required point failed or could not be decided, 3 if engines only
    crashed or hung at such points, 2 if nothing was judged, else 0.
    """
    from refdem.errors import UsageError
    from refdem.stress.record import BROKEN

    ends = {
        result.end.verdict
        for result in record.results
        if result.kept is False and result.end is not None
    }
    if ends:
        if ends == {"error"}:
            return 3
        return 1
    verdicts = {point.verdict for result in record.results for point in result.points}
    if not verdicts & {"pass", *BROKEN}:
        for engine, sweep, reason in record.refused:
            print(f"{engine}, {sweep}: {reason}", file=sys.stderr)
        raise UsageError(
            "nothing was judged: no method of the engines supports a point of these sweeps"
        )
    return 0


def written(out: Path, record: "StressRecord", store: "Store | None" = None) -> None:
    """Writes the tables, pages and JSON of a stress test."""
    from refdem.report.stress import write
    from refdem.stress.tables import introduction, summary

    sections = [_section(record, number) for number in range(len(record.batteries))]
    write(
        out,
        TITLE,
        introduction(record),
        [_cells(table) for table in summary(record)],
        [s for s in sections if s.tables],
        store,
    )


def _section(record: "StressRecord", number: int) -> "Section":
    """A battery with its marks and tables."""
    from refdem.report.stress import Mark, Section
    from refdem.stress.tables import details
    from refdem.stress.verdict import ratio, shown_point

    battery = record.batteries[number]
    marks = []
    for result in record.results:
        if result.battery != battery.id:
            continue
        for index, point in enumerate(result.points):
            mark = Mark(
                result.sweep,
                result.along,
                index,
                shown_point(point.point),
                result.engine,
                result.method,
                result.is_reference,
                ratio(point),
                point.verdict,
            )
            marks.append(mark)
    tables = [_cells(table) for table in details(record, battery.id)]
    return Section(battery.id, battery.title, battery.question, marks, tables)


def _cells(table: "Table") -> "Cells":
    return table.title, table.header, table.rows
