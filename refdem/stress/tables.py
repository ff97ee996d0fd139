"""A stress record as tables of text: where each engine breaks, and the result of each method on
each ladder.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from refdem.stress.record import Climb, StressRecord
from refdem.stress.verdict import number, words

NONE = "\N{EN DASH}"


@dataclass(frozen=True)
class Table:
    """A title, a header, and rows of cells."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def introduction(record: StressRecord) -> str:
    """The paragraph that explains how ladders are judged."""
    return (
        "Each ladder makes a scene harder rung by rung. Each rung is judged as in"
        " `refdem run`: against certified truth where there is one, and by"
        " conservation laws, each bound with its basis. A method holds up to the"
        " last rung before the first that it does not pass. Undecided means that"
        " the bound is too large to prove anything, which is never a pass; not"
        f" run means that a rung was forecast to take more than {record.longest:g}"
        " s. The reference promises ranges and is held to them; the breaking"
        " point of another engine is information, not a mark against it."
    )


def summary(record: StressRecord) -> list[Table]:
    """For each ladder the last rung that each engine holds; and the promises that were broken, or
    their count.
    """
    others = {climb.engine: not climb.is_reference for climb in record.climbs}
    # The reference comes first, then the engines by name.
    engines = sorted(others, key=lambda name: (others[name], name))
    ladders: dict[tuple[str, str, str], list[Climb]] = {}
    for climb in record.climbs:
        ladders.setdefault((climb.battery, climb.ladder, climb.along), []).append(climb)
    rows = []
    for ladder, climbs in ladders.items():
        ranges = []
        for engine in engines:
            ranges.append(_range([climb for climb in climbs if climb.engine == engine]))
        rows.append((*ladder, *ranges))
    title = (
        "Last rung that each engine holds (from its first method to break to its"
        " last; +: to the end)"
    )
    tables = [Table(title, ("battery", "ladder", "rung", *engines), rows)]
    broken = [climb for climb in record.climbs if climb.kept is False]
    required = [climb for climb in record.climbs if climb.required is not None]
    if broken:
        header = ("ladder", "method", "promised", "why", "what happened")
        tables.append(Table("Promises that broke", header, [_broken(climb) for climb in broken]))
    elif required:
        tables.append(Table("Promises", ("ranges", "kept", "not run"), [_count(required)]))
    return tables


def _count(required: Sequence[Climb]) -> tuple[str, str, str]:
    """Cells of the table of promises: how many were required, kept, and not completely run."""
    kept = sum(climb.kept is True for climb in required)
    return str(len(required)), str(kept), str(len(required) - kept)


def _broken(climb: Climb) -> tuple[str, ...]:
    """Cells of a climb that broke its promise."""
    end = climb.end
    if end is None:
        happened = ""
    else:
        happened = f"at {end.rung}: {end.sentence}"
    if climb.required is None:
        promised = NONE
    else:
        promised = number(climb.required)
    method = f"{climb.engine} {climb.method}"
    return (climb.ladder, method, promised, climb.basis, happened)


def _range(climbs: Sequence[Climb]) -> str:
    """The range of an engine, from the method that breaks first to the one that breaks last; `+` is
    the ladder's end.
    """
    if not climbs:
        return NONE
    by_length = sorted(climbs, key=lambda climb: (_steps(climb), climb.method))
    shortest = _holds_to(by_length[0])
    farthest = _holds_to(by_length[-1])
    if shortest == farthest:
        return shortest
    return f"{shortest} to {farthest}"


def _steps(climb: Climb) -> int:
    """Number of rungs before the first that does not pass."""
    end = climb.end
    if end is None:
        return len(climb.rungs)
    return climb.rungs.index(end)


def _holds_to(climb: Climb) -> str:
    """The last rung that a climb holds, with `+` at the end of the ladder."""
    holds, _ = words(climb)
    if climb.end is None:
        return f"{holds}+"
    return holds


def details(record: StressRecord, battery: str) -> list[Table]:
    """The climbs of a battery, and who cannot climb its ladders."""
    climbs = [climb for climb in record.climbs if climb.battery == battery]
    ladders = {climb.ladder for climb in climbs}
    refused = [(engine, ladder, why) for engine, ladder, why in record.refused if ladder in ladders]
    header = ("ladder", "rung", "method", "holds to", "ends", "promised", "reason")
    tables = [
        Table("Breaking points", header, [_row(climb) for climb in climbs]),
        Table("Not supported", ("engine", "ladder", "reason"), refused),
    ]
    return [table for table in tables if table.rows]


def _row(climb: Climb) -> tuple[str, ...]:
    """Cells of a climb in the table of breaking points."""
    holds, ends = words(climb)
    promised = NONE
    if climb.required is not None:
        kept = {True: "kept", False: "broken", None: "not all run"}[climb.kept]
        promised = f"{number(climb.required)}, {kept}"
    end = climb.end
    if end is None:
        why = NONE
    else:
        why = end.sentence
    method = f"{climb.engine} {climb.method}"
    return climb.ladder, climb.along, method, holds, ends, promised, why


def lines(record: StressRecord) -> list[str]:
    """Lines for a terminal: broken promises first, then all other climbs, then counts."""
    broken = [climb for climb in record.climbs if climb.kept is False]
    printed = []
    for climb in broken:
        promised = number(climb.required or 0.0)
        printed.append(f"BROKEN {_name(climb)}: promised to {promised}; {_sentence(climb)}")
    for climb in record.climbs:
        if climb.kept is not False:
            printed.append(f"       {_name(climb)}: {_sentence(climb)}")
    required = [climb for climb in record.climbs if climb.required is not None]
    rungs = sum(len(climb.rungs) for climb in record.climbs)
    n_kept = sum(climb.kept is True for climb in required)
    printed.append(
        f"{len(record.climbs)} climbs, {rungs} rungs; {n_kept} of {len(required)} promises kept,"
        f" {len(broken)} broken"
    )
    return printed


def _name(climb: Climb) -> str:
    """Id of a climb: battery/ladder/engine/method."""
    return f"{climb.battery}/{climb.ladder}/{climb.engine}/{climb.method}"


def _sentence(climb: Climb) -> str:
    """How far a climb holds, and how it ends."""
    holds, ends = words(climb)
    return f"holds to {holds} ({climb.along}), ends: {ends}"
