"""A stress record as tables of text: where each engine breaks, and the result of each method on
each sweep.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from refdem.stress.record import MethodSweep, StressRecord
from refdem.stress.verdict import number, words

NONE = "\N{EN DASH}"


@dataclass(frozen=True)
class Table:
    """A title, a header, and rows of cells."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def introduction(record: StressRecord) -> str:
    """The paragraph that explains how sweeps are judged."""
    return (
        "Each sweep makes a scene harder point by point. Each point is judged as in"
        " `refdem run`: against certified truth where there is one, and by"
        " conservation laws, each bound with its basis. A method holds up to the"
        " last point before the first that it does not pass. Undecided means that"
        " the bound is too large to prove anything, which is never a pass; not"
        f" run means that a point was forecast to take more than {record.longest:g}"
        " s. The reference promises ranges and is held to them; the breaking"
        " point of another engine is information, not a mark against it."
    )


def summary(record: StressRecord) -> list[Table]:
    """For each sweep the last point that each engine holds; and the promises that were broken, or
    their count.
    """
    others = {result.engine: not result.is_reference for result in record.results}
    # The reference comes first, then the engines by name.
    engines = sorted(others, key=lambda name: (others[name], name))
    sweeps: dict[tuple[str, str, str], list[MethodSweep]] = {}
    for result in record.results:
        sweeps.setdefault((result.battery, result.sweep, result.along), []).append(result)
    rows = []
    for sweep, results in sweeps.items():
        ranges = []
        for engine in engines:
            ranges.append(_range([result for result in results if result.engine == engine]))
        rows.append((*sweep, *ranges))
    title = (
        "Last point that each engine holds (from its first method to break to its"
        " last; +: to the end)"
    )
    tables = [Table(title, ("battery", "sweep", "point", *engines), rows)]
    broken = [result for result in record.results if result.kept is False]
    required = [result for result in record.results if result.required is not None]
    if broken:
        header = ("sweep", "method", "promised", "why", "what happened")
        tables.append(Table("Promises that broke", header, [_broken(result) for result in broken]))
    elif required:
        tables.append(Table("Promises", ("ranges", "kept", "not run"), [_count(required)]))
    return tables


def _count(required: Sequence[MethodSweep]) -> tuple[str, str, str]:
    """Cells of the table of promises: how many were required, kept, and not completely run."""
    kept = sum(result.kept is True for result in required)
    return str(len(required)), str(kept), str(len(required) - kept)


def _broken(result: MethodSweep) -> tuple[str, ...]:
    """Cells of a method sweep that broke its promise."""
    end = result.end
    if end is None:
        happened = ""
    else:
        happened = f"at {end.point}: {end.sentence}"
    if result.required is None:
        promised = NONE
    else:
        promised = number(result.required)
    method = f"{result.engine} {result.method}"
    return (result.sweep, method, promised, result.basis, happened)


def _range(results: Sequence[MethodSweep]) -> str:
    """The range of an engine, from the method that breaks first to the one that breaks last; `+` is
    the sweep's end.
    """
    if not results:
        return NONE
    by_length = sorted(results, key=lambda result: (_steps(result), result.method))
    shortest = _holds_to(by_length[0])
    farthest = _holds_to(by_length[-1])
    if shortest == farthest:
        return shortest
    return f"{shortest} to {farthest}"


def _steps(result: MethodSweep) -> int:
    """Number of points before the first that does not pass."""
    end = result.end
    if end is None:
        return len(result.points)
    return result.points.index(end)


def _holds_to(result: MethodSweep) -> str:
    """The last point that a method sweep holds, with `+` at the end of the sweep."""
    holds, _ = words(result)
    if result.end is None:
        return f"{holds}+"
    return holds


def details(record: StressRecord, battery: str) -> list[Table]:
    """The method sweeps of a battery, and the engines that cannot run its sweeps."""
    results = [result for result in record.results if result.battery == battery]
    sweeps = {result.sweep for result in results}
    refused = [(engine, sweep, why) for engine, sweep, why in record.refused if sweep in sweeps]
    header = ("sweep", "point", "method", "holds to", "ends", "promised", "reason")
    tables = [
        Table("Breaking points", header, [_row(result) for result in results]),
        Table("Not supported", ("engine", "sweep", "reason"), refused),
    ]
    return [table for table in tables if table.rows]


def _row(result: MethodSweep) -> tuple[str, ...]:
    """Cells of a method sweep in the table of breaking points."""
    holds, ends = words(result)
    promised = NONE
    if result.required is not None:
        kept = {True: "kept", False: "broken", None: "not all run"}[result.kept]
        promised = f"{number(result.required)}, {kept}"
    end = result.end
    if end is None:
        why = NONE
    else:
        why = end.sentence
    method = f"{result.engine} {result.method}"
    return result.sweep, result.along, method, holds, ends, promised, why


def lines(record: StressRecord) -> list[str]:
    """Lines for a terminal: broken promises first, then all other method sweeps, then counts."""
    broken = [result for result in record.results if result.kept is False]
    printed = []
    for result in broken:
        promised = number(result.required or 0.0)
        printed.append(f"BROKEN {_name(result)}: promised to {promised}; {_sentence(result)}")
    for result in record.results:
        if result.kept is not False:
            printed.append(f"       {_name(result)}: {_sentence(result)}")
    required = [result for result in record.results if result.required is not None]
    points = sum(len(result.points) for result in record.results)
    n_kept = sum(result.kept is True for result in required)
    printed.append(
        f"{len(record.results)} method sweeps, {points} points;"
        f" {n_kept} of {len(required)} promises kept, {len(broken)} broken"
    )
    return printed


def _name(result: MethodSweep) -> str:
    """Id of a method sweep: battery/sweep/engine/method."""
    return f"{result.battery}/{result.sweep}/{result.engine}/{result.method}"


def _sentence(result: MethodSweep) -> str:
    """How far a method sweep holds, and how it ends."""
    holds, ends = words(result)
    return f"holds to {holds} ({result.along}), ends: {ends}"
