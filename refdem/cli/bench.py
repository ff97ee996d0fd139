"""refdem bench: run time against error, with peers beside the engines."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from refdem.bench.record import BenchRecord
    from refdem.bench.tables import Table
    from refdem.report.markdown import Cells

TITLE = "Run time against error"
FEWEST_SPHERES = 100
"""Smallest number of spheres; with fewer the overhead of calls dominates the time of contacts."""


# The options of the command, in the order of its help.
Cases = Annotated[
    list[str] | None,
    typer.Argument(help="Cases such as `pendulum` or `pendulum[theta0=2]`; default: pendulum."),
]
Engines = Annotated[
    list[str] | None,
    typer.Option(help="Engines, or paths to refdem.toml files; default: all installed engines."),
]
MethodName = Annotated[
    str, typer.Option(help="Run only this method of each engine. Peers are not affected.")
]
Settings = Annotated[list[str] | None, typer.Option(help="Parameter of the cases, name=value.")]
Rounds = Annotated[
    int,
    typer.Option(
        help="Number of repetitions of every run. Repetitions of different runs are interleaved.",
        min=1,
    ),
]
MostSteps = Annotated[float, typer.Option(help="Largest number of steps of a run.")]
Longest = Annotated[
    float,
    typer.Option(help="Longest run time [s]. The step is refined until a run takes longer."),
]
Grow = Annotated[
    list[str] | None,
    typer.Option(
        help="Measure run time as a function of a parameter, such as samples=64,256,1024."
    ),
]
Peers = Annotated[
    bool, typer.Option(help="Also run the peers heyoka and SciPy if they are installed.")
]
Memory = Annotated[bool, typer.Option(help="Measure peak memory, in a separate process.")]
Crowd = Annotated[
    str,
    typer.Option(
        help=(
            "Measure the cost per body and step in gases with these numbers of spheres, such as"
            " 1000,10000."
        )
    ),
]
Stability = Annotated[bool, typer.Option(help="Measure the largest stable step.")]
Against = Annotated[
    Path | None,
    typer.Option(
        help=(
            "What to compare with: the Python executable of another installation, whose runs are"
            " interleaved with these, or a bench.json of an earlier measurement."
        )
    ),
]
Out = Annotated[Path, typer.Option(help="Folder for bench.md, bench.html, bench.json.")]


def command(
    case: Cases = None,
    engine: Engines = None,
    method: MethodName = "",
    set: Settings = None,
    rounds: Rounds = 5,
    most_steps: MostSteps = 1e6,
    longest: Longest = 0.3,
    grow: Grow = None,
    peers: Peers = True,
    memory: Memory = True,
    crowd: Crowd = "",
    stability: Stability = True,
    against: Against = None,
    out: Out = Path("refdem-bench"),
) -> None:
    """Measures run time as a function of error.

    Exit status 1 if a method is slower than in the measurement that --against names.

    Example: refdem bench pendulum two-body-orbit --engine reference --engine rebound --rounds 7
    """
    from refdem.bench.record import read
    from refdem.bench.session import Bench
    from refdem.cli.outputs import refuse_unwritable
    from refdem.core.parameters import labelled, settings
    from refdem.planning.specification import Entry

    parameters = settings(set or [])
    entries = []
    for label in case or ["pendulum"]:
        name, parameters_of_label = labelled(label)
        entries.append(Entry(name, parameters_of_label | parameters))
    # Either another Python, whose runs alternate with those of this one, or an earlier record.
    beside = runnable(against)
    earlier = None
    if against and not beside:
        earlier = read(against)
    refuse_unwritable(out)
    bench = Bench(
        cases=entries,
        engines=engine or [],
        method=method,
        rounds=rounds,
        most_steps=most_steps,
        longest=longest,
        with_peers=peers,
        with_memory=memory,
        with_stability=stability,
        grow=grown(grow or []),
        beside=beside,
        progress=_report,
    )
    record = bench.record()
    crowds = []
    if crowd:
        crowds = [_cells(crowded(crowd, rounds)), _cells(collided(crowd, rounds))]
    finish(record, out, earlier, crowds)


def _report(progress: str) -> None:
    """Prints a line of progress to stderr, apart from the tables."""
    print(progress, file=sys.stderr)


def finish(
    record: "BenchRecord", out: Path, earlier: "BenchRecord | None", more: "Sequence[Cells]"
) -> None:
    """Writes the record and its pages, and ends the program: 1 if a method is slower than in the
    earlier record.
    """
    import msgspec

    (out / "bench.json").write_bytes(msgspec.json.encode(record))
    is_slower = written(out, record, earlier, more)
    print(f"bench: {out / 'bench.html'}")
    raise typer.Exit(int(is_slower))


def runnable(against: Path | None) -> Path | None:
    """The path if it is executable, and so another Python; None for a record."""
    if against and os.access(against, os.X_OK):
        return against
    return None


def grown(pairs: list[str]) -> dict[str, list[str]]:
    """Values by parameter from `name=value,value` texts."""
    from refdem.core.parameters import settings

    return {name: values.split(",") for name, values in settings(pairs).items()}


def crowded(sizes: str, rounds: int) -> "Table":
    """The cost of a body and step in gases of these sizes, beside LAMMPS, MuJoCo and pymunk where
    they are installed.
    """
    from refdem.bench.crowd import costs, table
    from refdem.errors import UsageError

    if not all(size.isdecimal() and int(size) >= FEWEST_SPHERES for size in sizes.split(",")):
        raise UsageError(
            f"--crowd is {sizes!r}; expected numbers of spheres, at least {FEWEST_SPHERES}, as"
            " 1000,10000"
        )
    return table(costs(_numbers(sizes), rounds, _report))


def collided(sizes: str, rounds: int) -> "Table":
    """Impacts a second of so many rigid spheres in boxes, by sizes that `crowded` has accepted."""
    from refdem.bench.hard_spheres import rates, table

    return table(rates(_numbers(sizes), rounds, _report))


def _numbers(sizes: str) -> list[int]:
    """The numbers of a text such as 1000,10000."""
    return [int(size) for size in sizes.split(",")]


def written(
    out: Path, record: "BenchRecord", earlier: "BenchRecord | None", more: "Sequence[Cells]" = ()
) -> bool:
    """Writes the pages and prints the tables; True if a method is slower than in the earlier
    record, or than in the other installation, in turns with which it ran.
    """
    from refdem.bench.comparison import compared, compared_in_turns, false_alarm_rate
    from refdem.bench.tables import changes, chart_rows, introduction, tables
    from refdem.report.bench import Section, write

    if earlier:
        comparison = compared(record, earlier)
    else:
        comparison = compared_in_turns(record)
    extra: list[Cells] = []
    if comparison:
        extra.append(_cells(changes(comparison)))
    extra += more
    words = introduction(record)
    if (rate := false_alarm_rate(record)) is not None:
        words += (
            " Comparisons of one half of the rounds with the other raise a false alarm in"
            f" {100 * rate:.2g} % of all splits."
        )
    sections = []
    for label in record.compared:
        points = [
            (c.engine, c.method, c.is_reference, seconds, error)
            for c, seconds, error in chart_rows(record, label)
        ]
        sections.append(Section(label, points, [_cells(table) for table in tables(record, label)]))
    write(out, TITLE, words, extra, sections)
    for cells in extra:
        _print_table(cells)
    for section in sections:
        for cells in section.tables:
            _print_table(cells)
    return any(change.verdict == "slower" for change in comparison)


def _print_table(cells: "Cells") -> None:
    """Prints a table as lines of text with semicolons between the cells."""
    title, header, rows = cells
    print(f"{title}: {'; '.join(header)}")
    for row in rows:
        print("  " + "; ".join(row))


def _cells(table: "Table") -> "Cells":
    """The table as reports take it: title, header, rows."""
    return table.title, table.header, table.rows
