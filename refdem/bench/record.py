"""The results of a bench: points of error and time, a curve of points for each method, and a record
of all curves.
"""

from pathlib import Path

import msgspec

from refdem.core.reading import content
from refdem.errors import UNREADABLE, UsageError

TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)
"""Errors, in units of each quantity's scale, for which the time to reach them is reported."""


BUDGETS = (1e-4, 1e-3, 1e-2)
"""Times [s] for which the error reached within them is reported: equal work of all methods."""


class Point(msgspec.Struct, frozen=True, kw_only=True):
    """One level: largest error over the run, seconds in the engine's own loop round by round,
    set-up [s], steps (0: unknown).

    `beside`: seconds of another installation, each taken in turn with that of the same round here.
    """

    level: float
    error: float
    rounds: list[float]
    setup: float = 0.0
    steps: int = 0
    beside: list[float] = []


class Reach(msgspec.Struct, frozen=True, kw_only=True):
    """Seconds to an error: the median of the rounds, the least and the most."""

    seconds: float
    least: float
    most: float


class Growth(msgspec.Struct, frozen=True, kw_only=True):
    """Seconds against a number (steps, or a parameter of the case), and the exponent of the power
    that they follow.
    """

    by: str
    sizes: list[float]
    seconds: list[float]
    exponent: float | None


class Curve(msgspec.Struct, frozen=True, kw_only=True):
    """One method on one instance; `refusal` in place of points if it cannot run it.

    `compiled` [s]: what the first set-up cost beyond later ones. `memory` [bytes]: the peak of the
    finest run beyond what was held before it. `limit`: largest stable step as a multiple of
    2/omega; infinite if none was found too large.
    """

    label: str
    engine: str
    method: str
    control: str
    is_reference: bool = False
    is_peer: bool = False
    refusal: str = ""
    order_claimed: int = 0
    order_seen: float | None = None
    constant_seen: float | None = None
    points: list[Point] = []
    reached: list[Reach | None] = []
    compiled: float = 0.0
    memory: int | None = None
    limit: float | None = None
    limited: str = ""
    growth: list[Growth] = []

    @property
    def key(self) -> tuple[str, str, str]:
        """The key by which a curve is found in another record."""
        return self.label, self.engine, self.method


class BenchRecord(msgspec.Struct, frozen=True, kw_only=True):
    """All curves of one session. `yardstick` [s]: a fixed piece of work, timed once in every round;
    `load`: of the machine, 1 minute.

    Refinement ended with a run of more than `longest` [s] or `most_steps`: what was not reached by
    then may be reached later.

    `compared` names, for each instance, the quantities that every run shows: errors are the largest
    among these.
    """

    format: int = 1
    refdem: str
    rounds: int
    load: float
    longest: float
    most_steps: float
    yardstick: list[float]
    compared: dict[str, list[str]]
    curves: list[Curve]


def read(path: Path) -> BenchRecord:
    """The record in a file; raises UsageError if there is none."""
    data = content(path, "a bench.json that `refdem bench` wrote")
    try:
        return msgspec.json.decode(data, type=BenchRecord)
    except UNREADABLE as error:
        raise UsageError(f"{path} is not a record of a bench: {error}") from None
