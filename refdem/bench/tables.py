"""A record as tables of text: time to each error, ratios to the best peer, and what else was seen
of each method.
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from refdem.bench.comparison import Change
from refdem.bench.precision import per_step, seconds
from refdem.bench.record import TARGETS, Curve, Growth, Reach, Record

NONE = "\N{EN DASH}"
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))


@dataclass(frozen=True)
class Table:
    """A heading, and cells row by row under a header."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def tables(record: Record, label: str) -> list[Table]:
    """What is said of one instance."""
    curves = [curve for curve in record.curves if curve.label == label]
    able = [curve for curve in curves if curve.points]
    goals = tuple(f"to {target:.0e}".replace("e-0", "e-") for target in TARGETS)
    seen = (
        "method",
        "order",
        "C",
        "a step",
        "grows as",
        "memory",
        "largest stable step / (2/omega)",
    )
    found = [
        Table(
            "Time to an error",
            ("method", *goals, "least error", "set-up of a run", "compile or first set-up"),
            [_times(curve) for curve in able],
        ),
        Table("Faster than the best peer by", ("method", *goals), _ratios(able)),
        Table("What else was seen", seen, [_more(curve) for curve in able]),
        Table(
            "Not run",
            ("method", "reason"),
            [(_name(curve), curve.refusal) for curve in curves if curve.refusal],
        ),
    ]
    return [table for table in found if table.rows]


def changes(found: Sequence[Change]) -> Table:
    """A comparison of two records."""
    rows = [
        (
            change.key[0],
            " ".join(change.key[1:]),
            f"{change.factor:.2f}",
            change.verdict,
            two(change.error_factor),
        )
        for change in found
    ]
    return Table(
        "Against the other code",
        ("case", "method", "time now / then", "verdict", "error now / then, at most"),
        rows,
    )


def _name(curve: Curve) -> str:
    return f"{curve.engine} {curve.method}" + (
        " (reference)" if curve.is_reference else " (peer)" if curve.is_peer else ""
    )


def _times(curve: Curve) -> tuple[str, ...]:
    least = min(point.error for point in curve.points)
    setup = statistics.median(point.setup for point in curve.points)
    return (
        _name(curve),
        *(_reached(reach) for reach in curve.reached),
        two(least),
        duration(setup),
        duration(curve.compiled),
    )


def _reached(reach: Reach | None) -> str:
    """The median with the least and the most of the rounds."""
    if reach is None:
        return "not reached"
    return f"{duration(reach.seconds)} ({duration(reach.least)} to {duration(reach.most)})"


def _ratios(curves: Sequence[Curve]) -> list[tuple[str, ...]]:
    """Time of the fastest peer over that of every other method, at each error; in brackets the
    extremes of the rounds.
    """
    best = [
        _fastest([curve.reached[k] for curve in curves if curve.is_peer])
        for k in range(len(TARGETS))
    ]
    if not any(best):
        return []
    return [
        (_name(c), *(_ratio(peer, own) for peer, own in zip(best, c.reached, strict=True)))
        for c in curves
        if not c.is_peer
    ]


def _fastest(reached: Sequence[Reach | None]) -> Reach | None:
    return min(
        (reach for reach in reached if reach is not None),
        key=lambda reach: reach.seconds,
        default=None,
    )


def _ratio(peer: Reach | None, own: Reach | None) -> str:
    if peer is None:
        if own:
            return "no peer gets there"
        return NONE
    if own is None:
        return "not reached"
    return (
        f"{two(peer.seconds / own.seconds)}x ({two(peer.least / own.most)} to"
        f" {two(peer.most / own.least)})"
    )


def _more(curve: Curve) -> tuple[str, ...]:
    if curve.order_seen is not None:
        orders = f"{curve.order_seen:.2f} (claimed {curve.order_claimed})"
    else:
        orders = NONE
    if curve.control == "step":
        step = per_step(curve.points)
    else:
        step = None
    grows = "; ".join(map(_growth, curve.growth)) or NONE
    if curve.memory is None:
        memory = NONE
    else:
        memory = f"{two(curve.memory / 2**20)} MiB"
    limit = curve.limited or (NONE if curve.limit is None else f"{curve.limit:.3f}")
    return (
        _name(curve),
        orders,
        two(curve.constant_seen),
        NONE if step is None else duration(step),
        grows,
        memory,
        limit,
    )


def _growth(growth: Growth) -> str:
    """The power, and the time at the largest size."""
    if growth.exponent is None:
        power = NONE
    else:
        power = f"{growth.by}^{growth.exponent:.1f}"
    return f"{power}, {duration(growth.seconds[-1])} at {growth.sizes[-1]:g}"


def two(value: float | None) -> str:
    """Two significant digits; a dash if there is none."""
    if value is None or not math.isfinite(value):
        if value is None:
            return NONE
        return str(value)
    if 1e-3 <= abs(value) < 1e6 or value == 0:
        return f"{float(f'{value:.1e}'):.4g}"
    return f"{value:.1e}".replace("e-0", "e-")


def duration(value: float) -> str:
    """A time with two significant digits and its unit."""
    unit, name = next(((unit, name) for unit, name in UNITS if value >= unit), UNITS[-1])
    return f"{two(value / unit)} {name}"


def introduction(record: Record) -> str:
    """What the numbers are, in words."""
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


def chart_rows(record: Record, label: str) -> list[tuple[Curve, float, float]]:
    """(curve, seconds, error) of every point of an instance."""
    return [
        (c, seconds(point), point.error)
        for c in record.curves
        if c.label == label
        for point in c.points
        if seconds(point) > 0
    ]
