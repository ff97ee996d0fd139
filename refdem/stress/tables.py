"""A record as tables of text: breaking points, and what each method did on each ladder."""

from collections.abc import Sequence
from dataclasses import dataclass

from refdem.stress.record import Climb, Record
from refdem.stress.verdict import number, words

NONE = "\N{EN DASH}"


@dataclass(frozen=True)
class Table:
    """A heading, and cells row by row under a header."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def introduction(record: Record) -> str:
    """What the numbers are, in words."""
    return (
        "Scenes are made harder rung by rung. Each rung is judged as refdem run judges: against"
        " certified truth where there is one, and by what mechanics keeps, each bound with its"
        " reason. A method holds to the last rung before the first that it does not pass."
        " Undecided means that the bound itself is so large there that nothing could be proved,"
        " which is never a pass; not run, that a rung was forecast to take more than"
        f" {record.longest:g} s. The reference promises ranges and is held to them; where another"
        " engine breaks is information, not a mark against it."
    )


def summary(record: Record) -> list[Table]:
    """The farthest rung that the methods of each engine hold, ladder by ladder, and the
    promises.
    """
    engines = list(dict.fromkeys(climb.engine for climb in record.climbs))
    ladders = list(
        dict.fromkeys((climb.battery, climb.ladder, climb.along) for climb in record.climbs)
    )
    rows = []
    for battery, ladder, along in ladders:
        of = [
            climb for climb in record.climbs if (climb.battery, climb.ladder) == (battery, ladder)
        ]
        rows.append(
            (
                battery,
                ladder,
                along,
                *(_range([climb for climb in of if climb.engine == engine]) for engine in engines),
            )
        )
    title = "Each engine holds to (its methods from the first to break to the last; +: to the end)"
    found = [Table(title, ("battery", "ladder", "rung", *engines), rows)]
    broken = [climb for climb in record.climbs if climb.kept is False]
    required = [climb for climb in record.climbs if climb.required is not None]
    if broken:
        found.append(
            Table(
                "Promises that broke",
                ("ladder", "method", "promised", "why", "what happened"),
                [_broken(c) for c in broken],
            )
        )
    elif required:
        found.append(Table("Promises", ("ranges", "kept", "not run"), [_count(required)]))
    return found


def _count(required: Sequence[Climb]) -> tuple[str, str, str]:
    kept = sum(climb.kept is True for climb in required)
    return str(len(required)), str(kept), str(len(required) - kept)


def _broken(climb: Climb) -> tuple[str, ...]:
    end = climb.end
    if climb.required is None:
        promised = NONE
    else:
        promised = number(climb.required)
    return (
        climb.ladder,
        f"{climb.engine} {climb.method}",
        promised,
        climb.basis,
        "" if end is None else f"at {end.rung}: {end.sentence}",
    )


def _range(climbs: Sequence[Climb]) -> str:
    """From the method that ends first to that which ends last;

    `+` where it is the last rung of the ladder.
    """
    if not climbs:
        return NONE
    steps = sorted((_steps(climb), climb.method, climb) for climb in climbs)
    least = _told(steps[0][2])
    most = _told(steps[-1][2])
    if least == most:
        return least
    return f"{least} to {most}"


def _steps(climb: Climb) -> int:
    """Rungs before the first that does not pass."""
    end = climb.end
    if end is None:
        return len(climb.rungs)
    return climb.rungs.index(end)


def _told(climb: Climb) -> str:
    holds, _ = words(climb)
    return holds + ("+" if climb.end is None else "")


def details(record: Record, battery: str) -> list[Table]:
    """What each method did on each ladder of a battery, and who cannot climb them."""
    climbs = [climb for climb in record.climbs if climb.battery == battery]
    ladders = {climb.ladder for climb in climbs}
    refused = [(engine, ladder, why) for engine, ladder, why in record.refused if ladder in ladders]
    found = [
        Table(
            "Breaking points",
            ("ladder", "rung", "method", "holds to", "ends", "promised", "why there"),
            [_row(climb) for climb in climbs],
        ),
        Table("Not supported", ("engine", "ladder", "reason"), refused),
    ]
    return [table for table in found if table.rows]


def _row(climb: Climb) -> tuple[str, ...]:
    holds, ends = words(climb)
    if climb.required is None:
        promised = NONE
    else:
        promised = (
            number(climb.required)
            + {True: ", kept", False: ", broken", None: ", not all run"}[climb.kept]
        )
    end = climb.end
    if end is None:
        why = NONE
    else:
        why = end.sentence
    return climb.ladder, climb.along, f"{climb.engine} {climb.method}", holds, ends, promised, why


def lines(record: Record) -> list[str]:
    """What a terminal shows: every climb that ended before the last rung, broken promises first,
    and counts.
    """
    broken = [climb for climb in record.climbs if climb.kept is False]
    shown = [
        f"BROKEN {_name(c)}: promised to {number(c.required or 0.0)}; {_sentence(c)}"
        for c in broken
    ]
    shown += [f"       {_name(c)}: {_sentence(c)}" for c in record.climbs if c.kept is not False]
    required = [climb for climb in record.climbs if climb.required is not None]
    rungs = sum(len(climb.rungs) for climb in record.climbs)
    held = sum(climb.kept is True for climb in required)
    return [
        *shown,
        (
            f"{len(record.climbs)} climbs, {rungs} rungs; {held} of {len(required)} promises kept,"
            f" {len(broken)} broken"
        ),
    ]


def _name(climb: Climb) -> str:
    return f"{climb.battery}/{climb.ladder}/{climb.engine}/{climb.method}"


def _sentence(climb: Climb) -> str:
    holds, ends = words(climb)
    return f"holds to {holds} ({climb.along}), ends: {ends}"
