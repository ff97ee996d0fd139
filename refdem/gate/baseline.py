"""The baseline: the findings on a program at the time when they were accepted, with the reason.

The first line of the file has the engine, the number of findings and their digest. Without it, a
truncated baseline, or that of another program, would let the gate pass on all findings that it
lacks.
"""

import hashlib
from collections.abc import Iterable
from pathlib import Path

import msgspec

from refdem.core.finding import DECIDED, Finding, Outcome, Record, findings_of
from refdem.core.named_file import put
from refdem.core.outside import one_line
from refdem.core.reading import content, json_as
from refdem.errors import StoreError, UsageError

FORMAT = 2
"""Version of the format of a baseline."""
MOST_SHOWN = 20
"""Most changes of each kind that are listed when a baseline is written."""
PARTS = 5
"""Number of parts of an id: case, engine, method, check, quantity."""


class Accepted(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One accepted finding: its id, outcome, value and measured error constant."""

    id: str
    outcome: Outcome
    value: float | None = None
    constant: float | None = None

    @property
    def size(self) -> float | None:
        """The number that a later run is compared with: the error constant, or else the value."""
        if self.constant is not None:
            return self.constant
        return self.value


class Header(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The first line of a baseline file; `findings` is their number, `sha256` the digest of their
    lines.
    """

    format: int
    engine: str
    version: str
    why: str
    findings: int = -1
    sha256: str = ""


def accepted(record: Record, finding: Finding) -> Accepted:
    """The entry of a finding in a baseline."""
    return Accepted(
        id=record.id(finding),
        outcome=finding.outcome,
        value=finding.value,
        constant=finding.constant_seen,
    )


def read(path: Path, engine: str = "") -> tuple[Header, dict[str, Accepted]]:
    """Header and findings by id.

    Raises UsageError, which states how to make a baseline, if the file is missing or malformed, or
    belongs to another engine than `engine`.
    """
    if not path.is_file():
        raise UsageError(
            f"no baseline {path}; look at the findings, then accept them with: refdem gate --bless"
            ' --why "first baseline"'
        )
    lines = content(path, "a baseline that `--bless` wrote").splitlines()
    if not lines:
        raise UsageError(f"baseline {path} is empty; restore it from version control")
    header = json_as(Header, lines[0], f"baseline {path}, line 1")
    entries = [
        json_as(Accepted, line, f"baseline {path}, line {number}")
        for number, line in enumerate(lines[1:], 2)
    ]
    _refuse_wrong_ids(path, entries)
    if header.format != FORMAT:
        raise UsageError(
            f"baseline {path} has format {header.format}; expected {FORMAT}: delete it and bless"
            " anew"
        )
    if (header.findings, header.sha256) != (len(entries), digest(lines[1:])):
        raise UsageError(
            f"baseline {path} has {len(entries)} findings; its first line was written for"
            f" {header.findings}, or for others; restore it from version control, or delete it and"
            " bless anew"
        )
    if engine and header.engine != engine:
        raise UsageError(
            f"baseline {path} is that of {one_line(header.engine, 80)!r}; expected one of"
            f" {engine!r}: put that in its place, or delete this one and bless anew"
        )
    return header, {entry.id: entry for entry in entries}


def digest(lines: Iterable[bytes]) -> str:
    """sha256 of the lines of findings, each with its newline."""
    return hashlib.sha256(b"".join(line + b"\n" for line in lines)).hexdigest()


def _refuse_wrong_ids(path: Path, entries: list[Accepted]) -> None:
    """Raises UsageError for an id that names no finding, does not print, or is there twice."""
    ids: set[str] = set()
    # The header is line 1.
    for number, entry in enumerate(entries, 2):
        where = f"baseline {path}, line {number}"
        shown = repr(one_line(entry.id, 80))
        if entry.id.count("/") < PARTS - 1:
            raise UsageError(f"{where}: id is {shown}; expected case/engine/method/check/quantity")
        if not entry.id.isprintable():
            raise UsageError(
                f"{where}: id {shown} has characters that do not print; expected one that"
                " `--bless` wrote"
            )
        if entry.id in ids:
            raise UsageError(f"{where}: {shown} is listed twice; remove one, or bless again")
        ids.add(entry.id)


def write(path: Path, records: list[Record], why: str) -> int:
    """Writes a baseline of all decided findings, sorted by id, and returns their number.

    The file is replaced as a whole or not at all. Raises UsageError without a reason `why`, or if
    nothing was decided.
    """
    if not why.strip():
        raise UsageError("--bless requires --why: state briefly why these findings are correct")
    entries = list(_decided(records).values())
    if not entries:
        raise UsageError(
            f"nothing was decided, so there is nothing to accept; baseline {path} is unchanged;"
            " look at the errors first"
        )
    entries.sort(key=lambda entry: entry.id)
    lines = [msgspec.json.encode(entry) for entry in entries]
    header = Header(
        format=FORMAT,
        engine=records[0].engine,
        version=records[0].version,
        why=why,
        findings=len(entries),
        sha256=digest(lines),
    )
    try:
        put(path, b"\n".join([msgspec.json.encode(header), *lines]) + b"\n")
    except OSError as error:
        raise StoreError(f"baseline {path} cannot be written: {error.strerror}") from None
    return len(entries)


def differences(before: dict[str, Accepted], records: list[Record]) -> list[str]:
    """The changes of a baseline if these records are accepted, one line each.

    There are at most MOST_SHOWN of each kind, and none if there is no baseline yet.
    """
    if not before:
        return []
    now = _decided(records)
    gone = [f"- {name}: {before[name].outcome}" for name in sorted(before.keys() - now.keys())]
    other = [
        f"~ {name}: {_outcome_and_size(before[name])} -> {_outcome_and_size(now[name])}"
        for name in sorted(now.keys() & before.keys())
        if not _agree(before[name], now[name])
    ]
    return [*additions(before, records), *_shortened(gone, "gone"), *_shortened(other, "changed")]


def additions(before: dict[str, Accepted], records: list[Record]) -> list[str]:
    """The findings that a baseline does not have, one line each, at most MOST_SHOWN."""
    now = _decided(records)
    new = [f"+ {name}: {now[name].outcome}" for name in sorted(now.keys() - before.keys())]
    return _shortened(new, "new")


def _decided(records: list[Record]) -> dict[str, Accepted]:
    """The decided findings of records by their ids, as a baseline keeps them."""
    return {
        record.id(finding): accepted(record, finding)
        for record, finding in findings_of(records)
        if finding.outcome in DECIDED
    }


def _shortened(lines: list[str], kind: str) -> list[str]:
    """The first lines, and how many more there are of that kind."""
    more = len(lines) - MOST_SHOWN
    if more <= 0:
        return lines
    return [*lines[:MOST_SHOWN], f"{lines[0][0]} and {more} more that are {kind}"]


def _agree(old: Accepted, new: Accepted) -> bool:
    """True if two findings have the same outcome, and sizes that are near."""
    return old.outcome == new.outcome and _near(old.size, new.size)


def _outcome_and_size(entry: Accepted) -> str:
    """The outcome of a finding and its size."""
    return f"{entry.outcome} {_number(entry.size)}"


def _near(a: float | None, b: float | None) -> bool:
    """True if two numbers agree to a tenth of the larger, or are both missing."""
    if a is None or b is None:
        return a is b
    # Equality is tested first, because the difference of two infinities is NaN.
    return a == b or abs(a - b) <= 0.1 * max(abs(a), abs(b))


def _number(value: float | None) -> str:
    """A number to two digits, "-" for a missing one."""
    if value is None:
        return "-"
    return f"{value:.2g}"
