"""Refinement of each method down to the floor of its error, then repeated timing of all levels,
interleaved with those of other methods.
"""

import gc
import hashlib
import statistics
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import chain
from time import perf_counter

from refdem.bench.entrant import Entrant
from refdem.bench.record import Point
from refdem.core.trajectory import Cost
from refdem.core.truth import SampledTruth
from refdem.errors import RefdemError
from refdem.kernels import repeated

ENOUGH = 1e-14
"""Error, in units of the scale, below which a method is not refined further."""
MIN_ROUND = 2e-3
"""Runs shorter than this [s] are repeated within a round, as a clock and a cache that is cold would
be seen; the median counts.
"""
MOST_INNER = 15
"""Largest number of runs in a round; the median of 15 is stable enough."""
MIN_READING = 1e-4
"""Runs shorter than this [s] are repeated within one reading of the clock too, where the engine
allows it, until they have taken as long: what Python does between two runs leaves caches cold,
which would cost a run of a microsecond as much again.
"""
MOST_REPEATS = 100
"""Largest number of repeats within one reading: MIN_READING over a microsecond."""
WORK = b"\0" * (1 << 20)
Other = Callable[[int], float | None]


@dataclass
class Measured:
    """The measurements of an entrant: each level's errors, first set-up, and rounds of costs."""

    entrant: Entrant
    errors: dict[float, dict[str, float]] = field(default_factory=dict)
    first: dict[float, Cost] = field(default_factory=dict)
    rounds: dict[float, list[Cost]] = field(default_factory=dict)
    beside: dict[float, list[float]] = field(default_factory=dict)
    refusal: str = ""

    @property
    def compiled(self) -> float:
        """Seconds that the first set-up cost beyond the median of later ones: compilation, imports,
        tables.
        """
        later = [cost.setup for cost in chain.from_iterable(self.rounds.values())]
        if not later:
            return 0.0
        longest_first = max((cost.setup for cost in self.first.values()), default=0.0)
        return max(0.0, longest_first - statistics.median(later))

    def points(self, names: set[str]) -> list[Point]:
        """One point a level, coarse to fine; the error is the largest among `names`."""
        points = []
        for level, errors in self.errors.items():
            compared = [errors[name] for name in names & errors.keys()]
            costs = self.rounds.get(level, [])
            if not compared or not costs:
                continue
            seconds = [cost.seconds for cost in costs]
            setup = statistics.median(cost.setup for cost in costs)
            point = Point(
                level=level,
                error=max(compared),
                rounds=seconds,
                setup=setup,
                steps=self.first[level].steps,
                beside=self.beside.get(level, []),
            )
            points.append(point)
        return points


def refined(entrant: Entrant, truth: SampledTruth, *, longest: float) -> Measured:
    """Runs level by level until the error is at most ENOUGH, no longer decreases, or a run takes
    more than `longest` [s].

    A coarse level at which the engine fails is left out; if it fails at all of them, the last
    reason is the refusal.
    """
    measured = Measured(entrant)
    best = float("inf")
    levels_without_gain = 0
    for level in entrant.levels:
        try:
            trajectory, cost = entrant.run(level)
            errors = entrant.errors(trajectory, truth, level)
        except (RefdemError, ArithmeticError) as error:
            measured.refusal = str(error)
            continue
        measured.errors[level] = errors
        measured.first[level] = cost
        measured.rounds[level] = []
        worst = max(errors.values())
        # Two levels in sequence that do not lower the error are at its floor.
        levels_without_gain += 1
        if worst < 0.7 * best:
            levels_without_gain = 0
        best = min(best, worst)
        if best <= ENOUGH or levels_without_gain >= 2 or cost.seconds > longest:
            break
    if measured.errors:
        measured.refusal = ""
    return measured


def interleaved(
    entrants: Iterable[Measured],
    rounds: int,
    report: Callable[[int], None] = lambda done: None,
    other: Other | None = None,
) -> list[float]:
    """Times every level of every entrant once a round, from another one on in each; returns the
    yardstick [s] round by round.

    `other` times the same place of another installation, by its number, right before or right
    after: in turns. None where it cannot.
    """
    places: list[tuple[Measured, float]] = []
    for measured in entrants:
        places += [(measured, level) for level in measured.errors]
    yardstick = []
    with _no_collection():
        for number in range(rounds):
            gc.collect()
            yardstick.append(_yardstick())
            turn = number * len(places) // max(1, rounds)
            for place in [*range(turn, len(places)), *range(turn)]:
                measured, level = places[place]
                late = other is not None and (number + place) % 2 == 1
                if late:
                    _beside(measured, level, other, place)
                measured.rounds[level].append(_timed(measured, level))
                if not late:
                    _beside(measured, level, other, place)
            report(number + 1)
    return yardstick


def _timed(measured: Measured, level: float) -> Cost:
    """The cost of a run at this level, measured now."""
    return median_cost(lambda: measured.entrant.run(level)[1], measured.first[level].seconds)


def _beside(measured: Measured, level: float, other: Other | None, place: int) -> None:
    """Keeps the seconds that the other installation takes for the same place now."""
    if other:
        seconds = other(place)
    else:
        seconds = None
    if seconds is not None:
        measured.beside.setdefault(level, []).append(seconds)


def median_cost(run: Callable[[], Cost], first: float) -> Cost:
    """The cost of one run; of short ones, which took `first` seconds once, the run with the median
    time.
    """
    # 1e-7 s: what a clock does not resolve counts as so much.
    least = max(first, 1e-7)
    if first > MIN_ROUND:
        inner = 1
    else:
        inner = min(MOST_INNER, int(MIN_ROUND / least) + 1)
    repeats = min(MOST_REPEATS, int(MIN_READING / least) + 1)
    with repeated(repeats):
        costs = sorted((run() for _ in range(inner)), key=lambda cost: cost.seconds)
    return costs[inner // 2]


def _yardstick() -> float:
    """Seconds of a fixed piece of work, the median of 5: the current speed of this machine."""
    times = []
    for _ in range(5):
        started = perf_counter()
        hashlib.sha256(WORK).digest()
        times.append(perf_counter() - started)
    return statistics.median(times)


@contextmanager
def _no_collection() -> Iterator[None]:
    """Disables the garbage collector within this context, between two readings of the clock."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()
