"""Results that follow from the points of a curve: order, error constant, growth, and the time to
reach an error.
"""

import math
import statistics
from collections.abc import Sequence
from itertools import combinations, pairwise

from refdem.bench.record import Growth, Point, Reach
from refdem.core.trajectory import Cost

CLEAR = 30.0
"""Least ratio of the finer error of a pair of levels to the least error of the curve at which the
pair shows truncation.
"""
ROUND_OFF = 1e-12
"""Accumulated round-off in runs as long as those of a bench; smaller errors show no truncation."""


def seconds(point: Point) -> float:
    """The median of the rounds [s]."""
    return statistics.median(point.rounds)


def seconds_of(costs: Sequence[Cost]) -> float:
    """The median of the seconds of some costs."""
    return statistics.median(cost.seconds for cost in costs)


def reach(points: Sequence[Point], target: float) -> Reach | None:
    """Seconds to an error of `target`; None if no point is as good.

    It is interpolated linearly in log(seconds) and log(error) between the first point that meets
    the target and the one before, round by round. The first point of a curve, and one that takes no
    longer than the one before, is taken as it is.
    """
    meets = next((k for k, point in enumerate(points) if point.error <= target), None)
    if meets is None:
        return None
    count = min(len(points[k].rounds) for k in range(max(0, meets - 1), meets + 1))
    times = [_crossing(points, meets, target, number) for number in range(count)]
    return Reach(seconds=statistics.median(times), least=min(times), most=max(times))


def _crossing(points: Sequence[Point], meets: int, target: float, number: int) -> float:
    """Seconds of one round at which the line between two points has the error `target`."""
    after = points[meets]
    if meets == 0:
        return after.rounds[number]
    before = points[meets - 1]
    early = before.rounds[number]
    late = after.rounds[number]
    if not (after.error > 0 and early < late):
        return late
    # Fraction of the line, in logarithms, from the point before to the one that meets the target:
    # log(e_0/e)/log(e_0/e_1).
    part = math.log(before.error / target) / math.log(before.error / after.error)
    met: float = early * (late / early) ** part
    return met


def error_within(points: Sequence[Point], budget: float) -> float | None:
    """The error that a method reaches in `budget` seconds; None if its cheapest level takes longer.

    It is interpolated linearly in the logarithms of the medians between the last point within the
    budget and the next one. Beyond the last point, and where errors no longer decrease, it is the
    least error so far.
    """
    affordable = [k for k, point in enumerate(points) if seconds(point) <= budget]
    if not affordable:
        return None
    last = affordable[-1]
    least = min(points[k].error for k in affordable)
    if last + 1 == len(points):
        return least
    before = points[last]
    after = points[last + 1]
    if not 0 < after.error < before.error:
        return least
    # Fraction of the line, in logarithms, from the point before to the one beyond the budget:
    # log(s/s_0)/log(s_1/s_0).
    part = math.log(budget / seconds(before)) / math.log(seconds(after) / seconds(before))
    between: float = before.error * (after.error / before.error) ** part
    return min(least, between)


def order(points: Sequence[Point]) -> float | None:
    """The order between the finest two levels whose errors are truncation.

    None without such levels.
    """
    pairs = _truncating(points)
    if not pairs:
        return None
    coarse, fine = pairs[-1]
    return math.log(coarse.error / fine.error) / math.log(coarse.level / fine.level)


def constant(points: Sequence[Point], *, claimed: int, tau: float, duration: float) -> float | None:
    """C in error = C (1 + T/tau) (h/tau)^p at the finest level that shows truncation, p claimed."""
    pairs = _truncating(points)
    if not pairs or claimed < 1:
        return None
    _, finest = pairs[-1]
    growth_in_time = 1 + duration / tau
    step_in_tau = finest.level / tau
    return finest.error / (growth_in_time * step_in_tau**claimed)


def _truncating(points: Sequence[Point]) -> list[tuple[Point, Point]]:
    """Neighbouring levels whose errors are truncation: they fall, and lie clear of the floor of
    round-off and of the scale itself.
    """
    floor = min((point.error for point in points), default=0.0)
    last = 0.0
    if points:
        last = points[-1].error
    still_falling = len(points) > 1 and last == floor and points[-2].error > 3 * last
    # While errors still fall, the smallest of them is not yet the floor of round-off.
    least = ROUND_OFF
    if not still_falling:
        least = max(ROUND_OFF, CLEAR * floor)
    pairs = []
    for coarse, fine in pairwise(points):
        # Errors near the scale itself do not show the order: only smaller ones are truncation.
        is_falling = 0 < fine.error < coarse.error < 0.3
        if is_falling and fine.error > least:
            pairs.append((coarse, fine))
    return pairs


def growth(by: str, sizes: Sequence[float], times: Sequence[float]) -> Growth:
    """Seconds against sizes; the exponent is the median over all pairs of sizes of the slope in
    logarithms (Theil and Sen).
    """
    slopes = []
    for first, second in combinations(zip(sizes, times, strict=True), 2):
        size, time = first
        other_size, other_time = second
        if size != other_size and min(time, other_time) > 0:
            slopes.append(math.log(other_time / time) / math.log(other_size / size))
    exponent = None
    if slopes:
        exponent = statistics.median(slopes)
    return Growth(by=by, sizes=list(sizes), seconds=list(times), exponent=exponent)


def per_step(points: Sequence[Point]) -> float | None:
    """Seconds a step at the finest level; None where steps are not counted."""
    if not points or not points[-1].steps:
        return None
    return seconds(points[-1]) / points[-1].steps
