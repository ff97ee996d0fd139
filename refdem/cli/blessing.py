"""Accepting findings as a baseline, as `refdem gate` and `refdem judge` do it."""

from pathlib import Path
from typing import TYPE_CHECKING

from refdem.core.outside import one_line
from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.core.finding import Record


def refuse_without_why(why: str, *, is_requested: bool) -> None:
    """Raises UsageError for findings to be accepted without a reason, or a reason alone."""
    if is_requested and not why.strip():
        raise UsageError("--bless requires --why: state briefly why these findings are correct")
    if why and not is_requested:
        raise UsageError("got --why without --bless; expected both, or neither")


def accept(path: Path, engine: str, records: "list[Record]", why: str) -> None:
    """Writes the baseline of an engine and shows what it changes."""
    from refdem.core.finding import findings_of
    from refdem.gate import baseline
    from refdem.gate.baseline import Accepted

    before: dict[str, Accepted] = {}
    if path.is_file():
        _, before = baseline.read(path, engine)
    for line in baseline.differences(before, records):
        print(one_line(line))
    count = baseline.write(path, records, why)
    print(one_line(f"baseline {path}: {count} findings accepted"))
    outcomes = [finding.outcome for _, finding in findings_of(records)]
    broken = outcomes.count("error")
    if broken:
        print(
            f"errors: {broken}; what their runs would have shown is not in the baseline: once they"
            " work, accept again"
        )
    failing = outcomes.count("fail")
    if failing:
        print(
            f"{failing} of them fail, which no baseline can accept: correct the program or a claim"
            " in its refdem.toml, or explain the deviation there in an [[expected]] entry"
        )


def verdict(engines: list[str], status: int) -> str:
    """The sentence that says whether the gate of engines is open, by their exit status."""
    state = "open"
    if status:
        state = "closed"
    return f"the gate of {', '.join(engines)} is {state}"
