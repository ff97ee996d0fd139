"""Results of a stress test: a verdict for each point, the point at which a method breaks, and
whether a promise was kept.
"""

from pathlib import Path
from typing import Literal

import msgspec

from refdem.core.reading import content
from refdem.errors import UNREADABLE, UsageError

Verdict = Literal["pass", "fail", "error", "undecided", "unsupported", "not run"]
BROKEN: tuple[Verdict, ...] = ("fail", "error")
"""Verdicts that break a method; after any other but `pass` it is unknown whether the method
holds.
"""


class Point(msgspec.Struct, frozen=True, kw_only=True):
    """The result of one point: its worst finding, or of passes the one nearest to its bound.

    `value`, `bound`, `basis` and `sentence` are those of the finding; `seconds` is the time in the
    engine's loop. `forecast` [s] is the expected time of a point that was not run.
    """

    point: str
    verdict: Verdict
    quantity: str = ""
    value: float | None = None
    bound: float | None = None
    basis: str = ""
    sentence: str = ""
    seconds: float = 0.0
    forecast: float | None = None


class MethodSweep(msgspec.Struct, frozen=True, kw_only=True):
    """One method on one sweep.

    `holds` is the last point before the first that does not pass; `breaks` is that first one if it
    failed. `required` is the last point that had to hold, if any. `kept` is True if all points up
    to it passed, and None if nothing was required or some were not run.
    """

    battery: str
    sweep: str
    label: str
    along: str
    engine: str
    version: str
    method: str
    is_reference: bool
    points: list[Point]
    holds: float | None = None
    breaks: float | None = None
    required: float | None = None
    basis: str = ""
    kept: bool | None = None

    @property
    def end(self) -> Point | None:
        """The first point that does not pass."""
        return next((point for point in self.points if point.verdict != "pass"), None)


class Ask(msgspec.Struct, frozen=True, kw_only=True):
    """The question of a battery, for the report."""

    id: str
    title: str
    question: str


class StressRecord(msgspec.Struct, frozen=True, kw_only=True):
    """All results of one stress test.

    `refused` lists (engine, sweep, reason) where no method of the engine supports the sweep.
    """

    format: int = 2
    refdem: str
    longest: float
    batteries: list[Ask]
    results: list[MethodSweep]
    refused: list[tuple[str, str, str]] = []


def read(path: Path) -> StressRecord:
    """The record in a file; raises UsageError if there is none."""
    data = content(path, "a stress.json that `refdem stress` wrote")
    try:
        return msgspec.json.decode(data, type=StressRecord)
    except UNREADABLE as error:
        raise UsageError(f"{path} is not a record of a stress test: {error}") from None
