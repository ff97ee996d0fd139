"""A record as tables of text: time to each error, ratios to the best peer, and further results of
each method.
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from refdem.bench.comparison import Change
from refdem.bench.precision import error_within, per_step, seconds
from refdem.bench.record import BUDGETS, TARGETS, BenchRecord, Curve, Growth, Reach

NONE = "\N{EN DASH}"
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))


@dataclass(frozen=True)
class Table:
    """A heading, and cells row by row under a header."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def tables(record: BenchRecord, label: str) -> list[Table]:
    """The tables about one instance: times, comparison with peers, growth, the rest."""
    curves = [curve for curve in record.curves if curve.label == label]
    able = [curve for curve in curves if curve.points]
    goals = tuple(f"to {target:.0e}".replace("e-0", "e-") for target in TARGETS)
    timed = ("method", *goals, "least error", "set-up of a run", "compile or first set-up")
    worked = ("method", *(f"in {duration(budget)}" for budget in BUDGETS))
    measured = (
        "method",
        "order",
        "C",
        "a step",
        "grows as",
        "memory",
        "largest stable step / (2/omega)",
    )
    refused = [(_name(curve), curve.refusal) for curve in curves if curve.refusal]
    about_instance = [
        Table("Time to an error", timed, [_times(curve) for curve in able]),
        Table("Error at equal work", worked, [_at_equal_work(curve) for curve in able]),
        Table("Faster than the best peer by", ("method", *goals), _ratios(able)),
        Table("What else was seen", measured, [_more(curve) for curve in able]),
        Table("Not run", ("method", "reason"), refused),
    ]
    return [table for table in about_instance if table.rows]


def changes(compared: Sequence[Change]) -> Table:
    """A comparison of two records as a table: a row a curve that both have."""
    header = ("case", "method", "time now / then", "verdict", "error now / then, at most")
    rows = []
    for change in compared:
        case, *method = change.key
        factor = f"{change.factor:.2f}"
        rows.append((case, " ".join(method), factor, change.verdict, two(change.error_factor)))
    return Table("Against the other code", header, rows)


def _name(curve: Curve) -> str:
    """Engine and method, and whether the engine is the reference or a peer."""
    name = f"{curve.engine} {curve.method}"
    if curve.is_reference:
        return f"{name} (reference)"
    if curve.is_peer:
        return f"{name} (peer)"
    return name


def _times(curve: Curve) -> tuple[str, ...]:
    """The cells of a curve: time to each error, least error, and what sets a run up."""
    least = min(point.error for point in curve.points)
    setup = statistics.median(point.setup for point in curve.points)
    reached = [_reached(reach) for reach in curve.reached]
    return (_name(curve), *reached, two(least), duration(setup), duration(curve.compiled))


def _reached(reach: Reach | None) -> str:
    """The median with the least and the most of the rounds."""
    if reach is None:
        return "not reached"
    return f"{duration(reach.seconds)} ({duration(reach.least)} to {duration(reach.most)})"


def _at_equal_work(curve: Curve) -> tuple[str, ...]:
    """The cells of a curve: the error that it reaches in each of the times."""
    return (_name(curve), *(two(error_within(curve.points, budget)) for budget in BUDGETS))


def _ratios(curves: Sequence[Curve]) -> list[tuple[str, ...]]:
    """Time of the fastest peer over that of every other method, at each error; in brackets the
    extremes of the rounds.
    """
    peers = [curve for curve in curves if curve.is_peer]
    best = []
    for k in range(len(TARGETS)):
        best.append(_fastest([peer.reached[k] for peer in peers]))
    if not any(best):
        return []
    rows = []
    for curve in curves:
        if not curve.is_peer:
            pairs = zip(best, curve.reached, strict=True)
            rows.append((_name(curve), *(_ratio(peer, reach) for peer, reach in pairs)))
    return rows


def _fastest(reached: Sequence[Reach | None]) -> Reach | None:
    """The fastest of those that reach the accuracy; None if none does."""
    able = [reach for reach in reached if reach is not None]
    return min(able, key=lambda reach: reach.seconds, default=None)


def _ratio(peer: Reach | None, method: Reach | None) -> str:
    """How many times as fast as the peer a method is, with the extremes of the rounds."""
    if peer is None:
        if method:
            return "no peer gets there"
        return NONE
    if method is None:
        return "not reached"
    median = two(peer.seconds / method.seconds)
    least = two(peer.least / method.most)
    most = two(peer.most / method.least)
    return f"{median}x ({least} to {most})"


def _more(curve: Curve) -> tuple[str, ...]:
    """The cells of a curve: order, error constant, time a step, growth, memory, stability."""
    orders = NONE
    if curve.order_seen is not None:
        orders = f"{curve.order_seen:.2f} (claimed {curve.order_claimed})"
    seconds_per_step = None
    if curve.control == "step":
        seconds_per_step = per_step(curve.points)
    step = NONE
    if seconds_per_step is not None:
        step = duration(seconds_per_step)
    grows = "; ".join(map(_growth, curve.growth)) or NONE
    memory = NONE
    if curve.memory is not None:
        memory = f"{two(curve.memory / 2**20)} MiB"
    limit = NONE
    if curve.limit is not None:
        limit = f"{curve.limit:.3f}"
    return (
        _name(curve),
        orders,
        two(curve.constant_seen),
        step,
        grows,
        memory,
        curve.limited or limit,
    )


def _growth(growth: Growth) -> str:
    """The power, and the time at the largest size."""
    power = NONE
    if growth.exponent is not None:
        power = f"{growth.by}^{growth.exponent:.1f}"
    return f"{power}, {duration(growth.seconds[-1])} at {growth.sizes[-1]:g}"


def two(value: float | None) -> str:
    """Two significant digits; a dash if there is none."""
    if value is None:
        return NONE
    if not math.isfinite(value):
        return str(value)
    rounded = f"{value:.1e}"
    if 1e-3 <= abs(value) < 1e6 or value == 0:
        return f"{float(rounded):.4g}"
    return rounded.replace("e-0", "e-")


def duration(value: float) -> str:
    """A time with two significant digits and its unit."""
    # The largest unit that the value reaches, else the smallest of all.
    unit, name = next((pair for pair in UNITS if value >= pair[0]), UNITS[-1])
    return f"{two(value / unit)} {name}"


def introduction(record: BenchRecord) -> str:
    """The paragraph that explains what was measured, and how."""
    spread = max(record.yardstick) / statistics.median(record.yardstick)
    return (
        f"Seconds in each engine's own loop, one thread, the median of {record.rounds} interleaved"
        " rounds, least and most in brackets; set-up is apart, and runs of under 0.1 ms are"
        " repeated within one reading of the clock. Errors are the largest over the run, of all"
        " quantities that every method shows, in units of their scales, against certified truth."
        f" The machine had a load of {record.load:g}; a fixed piece of work took up to"
        f" {two(spread)} times its median. Only ratios mean anything elsewhere. Refinement ended"
        f" where it no longer helped, or with a run of more than {record.longest:g} s or"
        f" {record.most_steps:.0e} steps: `not reached` is not by then."
    )


def chart_rows(record: BenchRecord, label: str) -> list[tuple[Curve, float, float]]:
    """(curve, seconds, error) of every point of an instance."""
    rows = []
    for curve in record.curves:
        if curve.label == label:
            timed = [(seconds(point), point.error) for point in curve.points]
            rows += [(curve, time, error) for time, error in timed if time > 0]
    return rows
