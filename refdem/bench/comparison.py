"""Comparison of the run times of two codes despite noise: alternating on one machine, or by two
records. A difference is reported only if it is statistically significant.

In alternating runs each round gives a pair, and the load of the machine affects both. Rounds of two
records are in units of the yardstick of their round.
"""

import math
import statistics
from collections.abc import Sequence
from itertools import combinations

import msgspec

from refdem.bench.record import BenchRecord, Curve

CHANGE = 0.10
"""Smallest relative change of time that counts as a change."""


class Change(msgspec.Struct, frozen=True, kw_only=True):
    """One curve in both records: the factor by which its time has grown, and the verdict."""

    key: tuple[str, str, str]
    factor: float
    verdict: str
    error_factor: float | None


def compared(now: BenchRecord, then: BenchRecord) -> list[Change]:
    """The curves that both records have, at the levels that both have.

    Slower: every round now is slower than every round then, and the medians differ by more than
    CHANGE. For n rounds each of equal codes, without drift, the probability of that is at most
    1/C(2n, n): 1/252 for 5.
    """
    before = {curve.key: curve for curve in then.curves}
    changes = []
    for curve in now.curves:
        other = before.get(curve.key)
        if other:
            levels = _common(curve, other)
        else:
            levels = set()
        if other is None or not levels:
            continue
        a = rounds_of(now, curve, levels)
        b = rounds_of(then, other, levels)
        factor = math.exp(statistics.median(a) - statistics.median(b))
        change = Change(
            key=curve.key,
            factor=factor,
            verdict=verdict(a, b),
            error_factor=_largest_growth(curve, other, levels),
        )
        changes.append(change)
    return changes


def _largest_growth(now: Curve, then: Curve, levels: set[float]) -> float:
    """The largest factor by which the error at a level has grown; 1 where no error was above 0."""
    before = {point.level: point.error for point in then.points}
    factors = [
        point.error / before[point.level]
        for point in now.points
        if point.level in levels and before[point.level] > 0
    ]
    return max(factors, default=1.0)


def compared_in_turns(record: BenchRecord) -> list[Change]:
    """The curves that another installation ran alternating with this one.

    Slower: slower in every pair, and by more than CHANGE in the median. For equal codes, slower and
    faster each have a probability of at most 2^-n for n pairs: 1/32 for 5, 1/128 for 7. CHANGE
    reduces it further.
    """
    changes = []
    for curve in record.curves:
        pairs = ratios_of(curve)
        if pairs:
            factor = math.exp(statistics.median(pairs))
            verdict = verdict_of_pairs(pairs)
            changes.append(Change(key=curve.key, factor=factor, verdict=verdict, error_factor=None))
    return changes


def ratios_of(curve: Curve) -> list[float]:
    """The mean over levels of log(seconds here / seconds there), pair by pair."""
    chosen = [
        point for point in curve.points if point.beside and min(*point.beside, *point.rounds) > 0
    ]
    # Rounds that every level has on both sides.
    count = min((min(len(point.rounds), len(point.beside)) for point in chosen), default=0)
    means = []
    for k in range(count):
        logarithms = [math.log(point.rounds[k] / point.beside[k]) for point in chosen]
        means.append(statistics.fmean(logarithms))
    return means


def verdict_of_pairs(pairs: Sequence[float]) -> str:
    """`slower`, `faster` or `same` from logarithms of ratios; `same` if there are less than 4."""
    if len(pairs) < 4:
        return "same"
    change = statistics.median(pairs)
    if min(pairs) > 0 and change > math.log1p(CHANGE):
        return "slower"
    if max(pairs) < 0 and -change > math.log1p(CHANGE):
        return "faster"
    return "same"


def _common(curve: Curve, other: Curve) -> set[float]:
    return {point.level for point in curve.points} & {point.level for point in other.points}


def rounds_of(record: BenchRecord, curve: Curve, levels: set[float]) -> list[float]:
    """The mean over levels of log(seconds / yardstick), round by round."""
    chosen = [point.rounds for point in curve.points if point.level in levels]
    means = []
    for number, yard in enumerate(record.yardstick):
        has_all = all(number < len(times) and times[number] > 0 for times in chosen)
        if has_all:
            logarithms = [math.log(times[number] / yard) for times in chosen]
            means.append(statistics.fmean(logarithms))
    return means


def verdict(now: Sequence[float], then: Sequence[float]) -> str:
    """`slower`, `faster` or `same` from logarithms of times.

    `same` if there are less than 4 rounds.
    """
    if min(len(now), len(then)) < 4:
        return "same"
    change = statistics.median(now) - statistics.median(then)
    if min(now) > max(then) and change > math.log1p(CHANGE):
        return "slower"
    if max(now) < min(then) and -change > math.log1p(CHANGE):
        return "faster"
    return "same"


def false_alarm_rate(record: BenchRecord) -> float | None:
    """Fraction of comparisons of a code with itself with the verdict slower or faster, over every
    split of its rounds in two; None below 8 rounds.
    """
    alarms = 0
    total = 0
    for curve in record.curves:
        if not curve.points:
            continue
        series = rounds_of(record, curve, {point.level for point in curve.points})
        half = len(series) // 2
        if half < 4:
            continue
        for chosen in combinations(range(len(series)), half):
            rest = [value for number, value in enumerate(series) if number not in chosen]
            alarms += verdict([series[number] for number in chosen], rest) != "same"
            total += 1
    if total:
        return alarms / total
    return None
