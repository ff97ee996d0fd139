"""Findings that must be there and are not: lost, absent, or folded under the error or the refusal
that explains them.

A baseline and the list of a campaign are held in the same way: a finding that vanishes is never
green.
"""

from collections.abc import Iterable

import msgspec

from refdem.core.finding import DECIDED, Finding, Record

SHOWN = 6
"""Names of missing findings that a sentence has; it says how many more there are."""
Place = tuple[str, str, str]
"""Label, engine and method: what a record is of."""


def parts(name: str) -> tuple[Place, str, str]:
    """The place, the check and the quantity of a finding's id."""
    label, engine, method, check, quantity = name.rsplit("/", 4)
    return (label, engine, method), check, quantity


def with_missing(records: list[Record], wanted: Iterable[str], owner: str) -> list[Record]:
    """The records, in which everything `wanted` (ids) that was not found is told; `owner` is who
    wants it, as "the baseline".

    What follows from an error or a refusal is said there and makes no finding of its own.
    """
    seen: set[str] = set()
    for record in records:
        seen |= {record.id(finding) for finding in record.findings}
    gone: dict[Place, list[str]] = {}
    for name in sorted(set(wanted)):
        if name not in seen:
            place, check, quantity = parts(name)
            gone.setdefault(place, []).append(f"{check}/{quantity}")
    changed = []
    for record in records:
        missed = gone.pop((record.label, record.engine, record.method), [])
        changed.append(_with_gone(record, missed, owner))
    vanished = [_vanished(place, names, owner) for place, names in gone.items()]
    return [*changed, *vanished]


def with_lost(records: list[Record], wanted: Iterable[str], owner: str) -> list[Record]:
    """The records, in which what `wanted` (ids) has decided and nobody decided now is lost."""
    asked = set(wanted)
    found = []
    for record in records:
        findings = tuple(_lost(record, finding, asked, owner) for finding in record.findings)
        found.append(msgspec.structs.replace(record, findings=findings))
    return found


def _lost(record: Record, finding: Finding, asked: set[str], owner: str) -> Finding:
    """The finding as it is, or lost."""
    if record.id(finding) not in asked or finding.outcome in (*DECIDED, "error"):
        return finding
    sentence = f"{finding.sentence} {_capital(owner)} contains a decided finding here."
    return msgspec.structs.replace(finding, outcome="lost", sentence=sentence)


def _with_gone(record: Record, gone: list[str], owner: str) -> Record:
    """A record with what is gone from it, each under the finding that explains it, or absent."""
    found = []
    left = gone
    for finding in record.findings:
        explained = [name for name in left if _explains(finding, name)]
        left = [name for name in left if name not in explained]
        if explained:
            finding = _folded(finding, explained, owner)
        found.append(finding)
    found += [_absent(name, owner) for name in left]
    return msgspec.structs.replace(record, findings=tuple(found))


def _explains(finding: Finding, name: str) -> bool:
    """True if the finding `name` (check/quantity) could not be made because of this one.

    A run that broke or was refused leaves nothing to judge; an error of one check takes the
    findings of that check alone.
    """
    if finding.outcome not in ("error", "unsupported"):
        return False
    if finding.check in ("run", "record"):
        return True
    return finding.outcome == "error" and name.startswith(f"{finding.check}/")


def _folded(finding: Finding, explained: list[str], owner: str) -> Finding:
    """The finding, with the findings that it explains appended to its sentence.

    "unsupported" becomes "lost" here: an earlier run judged what this one refused.
    """
    sentence = (
        f"{finding.sentence} Therefore {_counted(explained)} of {owner} could not be made:"
        f" {_named(explained)}."
    )
    if finding.outcome == "unsupported":
        outcome = "lost"
    else:
        outcome = finding.outcome
    return msgspec.structs.replace(finding, outcome=outcome, sentence=sentence)


def _absent(name: str, owner: str) -> Finding:
    """A finding that was not made, in a record where nothing explains that."""
    check, _, quantity = name.partition("/")
    sentence = (
        f"{_capital(owner)} contains this finding, and this run did not produce"
        " it: its cause was removed, or it could not be judged."
    )
    return Finding(check=check, quantity=quantity, outcome="absent", sentence=sentence)


def _vanished(place: Place, names: list[str], owner: str) -> Record:
    """A record that was not made at all: one finding for all that is gone with it."""
    label, engine, method = place
    sentence = (
        f"{_capital(owner)} contains {_counted(names)} for this case and method,"
        " and this run produced none: the case, the method or its support was"
        f" removed ({_named(names)})."
    )
    gone = Finding(check="record", quantity="findings", outcome="absent", sentence=sentence)
    return Record(
        case=label.partition("[")[0],
        label=label,
        parameters={},
        engine=engine,
        version="",
        method=method,
        is_reference=False,
        runs=(),
        findings=(gone,),
    )


def _counted(names: list[str]) -> str:
    if len(names) == 1:
        return "1 finding"
    return f"{len(names)} findings"


def _named(names: list[str]) -> str:
    """The first few names, and how many more there are."""
    if len(names) > SHOWN:
        more = f" and {len(names) - SHOWN} more"
    else:
        more = ""
    return ", ".join(names[:SHOWN]) + more


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
