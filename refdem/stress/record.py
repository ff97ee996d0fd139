"""What a stress test finds: verdicts rung by rung, where a method breaks, and whether a promise
broke.
"""

from pathlib import Path
from typing import Literal

import msgspec

from refdem.errors import UNREADABLE, UsageError

Verdict = Literal["pass", "fail", "error", "undecided", "unsupported", "not run"]
BROKEN: tuple[Verdict, ...] = ("fail", "error")
"""What breaks a method; the others end what is known of it."""


class Rung(msgspec.Struct, frozen=True, kw_only=True):
    """One rung: the finding that is worst, or comes nearest to its bound. `value` and `bound` as
    there; `seconds` of the engine's loop.

    `forecast` [s] is what a rung that was not run would have taken.
    """

    rung: str
    verdict: Verdict
    quantity: str = ""
    value: float | None = None
    bound: float | None = None
    basis: str = ""
    sentence: str = ""
    seconds: float = 0.0
    forecast: float | None = None


class Climb(msgspec.Struct, frozen=True, kw_only=True):
    """One method on one ladder. `holds` is the last rung before the first that does not pass,
    `breaks` that one, if it failed.

    `required`: the last rung that had to hold, if any; `kept`: it did, None where nothing was
    required or the budget ended before.
    """

    battery: str
    ladder: str
    label: str
    along: str
    engine: str
    version: str
    method: str
    is_reference: bool
    rungs: list[Rung]
    holds: float | None = None
    breaks: float | None = None
    required: float | None = None
    basis: str = ""
    kept: bool | None = None

    @property
    def end(self) -> Rung | None:
        """The first rung that does not pass."""
        return next((rung for rung in self.rungs if rung.verdict != "pass"), None)


class Ask(msgspec.Struct, frozen=True, kw_only=True):
    """The question of a battery, as the report shows it."""

    id: str
    title: str
    question: str


class StressRecord(msgspec.Struct, frozen=True, kw_only=True):
    """Everything that one stress test found.

    `refused`: engines and ladders that none of their methods can climb, with reasons.
    """

    format: int = 1
    refdem: str
    longest: float
    batteries: list[Ask]
    climbs: list[Climb]
    refused: list[tuple[str, str, str]] = []


def read(path: Path) -> StressRecord:
    """The record in a file; raises UsageError if there is none."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=StressRecord)
    except OSError as error:
        raise UsageError(
            f"{path} cannot be read: {error.strerror}; expected a stress.json that `refdem stress`"
            " wrote"
        ) from None
    except UNREADABLE as error:
        raise UsageError(f"{path} is not a record of a stress test: {error}") from None
