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
"""Spheres of the smallest crowd: fewer spend their time in the calls and not in the contacts."""


def command(
    case: Annotated[
        list[str] | None,
        typer.Argument(help="Cases, also as `pendulum[theta0=2]`; default: pendulum."),
    ] = None,
    engine: Annotated[
        list[str] | None,
        typer.Option(help="Engines, or paths of refdem.toml; default: all installed."),
    ] = None,
    method: Annotated[
        str, typer.Option(help="Only this method of the engines; peers are kept.")
    ] = "",
    set: Annotated[
        list[str] | None, typer.Option(help="Parameter of the cases, name=value.")
    ] = None,
    rounds: Annotated[
        int, typer.Option(help="Number of interleaved repeats of every run.", min=1)
    ] = 5,
    most_steps: Annotated[float, typer.Option(help="Largest number of steps of a run.")] = 1e6,
    longest: Annotated[
        float,
        typer.Option(help="Longest run [s]; refinement ends with the first one that takes longer."),
    ] = 0.3,
    grow: Annotated[
        list[str] | None,
        typer.Option(help="Measure run time against a parameter, as samples=64,256,1024."),
    ] = None,
    peers: Annotated[
        bool, typer.Option(help="Include the peers heyoka and SciPy, where installed.")
    ] = True,
    memory: Annotated[
        bool, typer.Option(help="Measure the peak memory, in a separate process.")
    ] = True,
    crowd: Annotated[
        str,
        typer.Option(
            help=(
                "Measure the cost per body and step in gases of these numbers of spheres,"
                " as 1000,10000."
            )
        ),
    ] = "",
    stability: Annotated[bool, typer.Option(help="Measure the largest stable step.")] = True,
    against: Annotated[
        Path | None,
        typer.Option(
            help=(
                "Compare with the Python of another installation, run in turns with this"
                " one, or with a bench.json."
            )
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for bench.md, bench.html, bench.json.")] = Path(
        "refdem-bench"
    ),
) -> None:
    """Measures run time against error; exit 1 if a method is slower than in the record that it is
    compared with.

    Example: refdem bench pendulum two-body-orbit --engine reference --engine rebound --rounds 7
    """
    from refdem.bench.record import read
    from refdem.bench.session import Bench
    from refdem.campaign.specification import Entry
    from refdem.cli.outputs import refuse_unwritable
    from refdem.core.parameters import labelled, settings

    given = settings(set or [])
    entries = [Entry(name, own | given) for name, own in map(labelled, case or ["pendulum"])]
    beside = runnable(against)
    if against and not beside:
        then = read(against)
    else:
        then = None
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
        progress=lambda told: print(told, file=sys.stderr),
    )
    record = bench.record()
    more = []
    if crowd:
        more.append(_cells(crowded(crowd, rounds)))
        more.append(_cells(collided(crowd, rounds)))
    tell(record, out, then, more)


def tell(
    record: "BenchRecord", out: Path, then: "BenchRecord | None", more: "Sequence[Cells]"
) -> None:
    """Writes the record and its pages, and ends the program: 1 if a method is slower."""
    import msgspec

    (out / "bench.json").write_bytes(msgspec.json.encode(record))
    slower = written(out, record, then, more)
    print(f"bench: {out / 'bench.html'}")
    if slower:
        status = 1
    else:
        status = 0
    raise typer.Exit(status)


def runnable(against: Path | None) -> Path | None:
    """The Python to run in turns with this one, if it is that."""
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
    return table(
        costs(list(map(int, sizes.split(","))), rounds, lambda told: print(told, file=sys.stderr))
    )


def collided(sizes: str, rounds: int) -> "Table":
    """Impacts a second of so many rigid spheres in boxes, by sizes that `crowded` has accepted."""
    from refdem.bench.hard_spheres import rates, table

    return table(
        rates(list(map(int, sizes.split(","))), rounds, lambda told: print(told, file=sys.stderr))
    )


def written(
    out: Path, record: "BenchRecord", then: "BenchRecord | None", more: "Sequence[Cells]" = ()
) -> bool:
    """Writes the pages and prints the tables; whether a method is slower than `then`."""
    from refdem.bench.comparison import compared, compared_in_turns, false_alarm_rate
    from refdem.bench.tables import changes, chart_rows, introduction, tables
    from refdem.report.bench import Section, write

    if then:
        found = compared(record, then)
    else:
        found = compared_in_turns(record)
    if found:
        extra: list[Cells] = [_cells(changes(found))]
    else:
        extra = []
    extra += more
    words = introduction(record)
    if (rate := false_alarm_rate(record)) is not None:
        words += (
            " Comparisons of a half of the rounds with the other half raise a false alarm in"
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
    for title, header, rows in [
        *extra,
        *(table for section in sections for table in section.tables),
    ]:
        print(
            "\n".join([f"{title}: {'; '.join(header)}", *("  " + "; ".join(row) for row in rows)])
        )
    return any(change.verdict == "slower" for change in found)


def _cells(table: "Table") -> "Cells":
    return table.title, table.header, table.rows
