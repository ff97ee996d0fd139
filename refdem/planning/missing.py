"""Findings that are required and were not made.

A baseline and the list of a campaign name findings that must be made. One that was judged but is
not decided now is *lost*; one that was not made is *absent*, or named in the sentence of the error
or refusal that explains it. A finding that vanishes never passes.
"""

from collections.abc import Iterable

import msgspec

from refdem.core.finding import DECIDED, Finding, Record

MAX_NAMES = 6
"""Most names of missing findings in a sentence, which states how many more there are."""
Place = tuple[str, str, str]
"""Label, engine and method, which identify a record."""


def parts(name: str) -> tuple[Place, str, str]:
    """The place, the check and the quantity of a finding's id."""
    label, engine, method, check, quantity = name.rsplit("/", 4)
    return (label, engine, method), check, quantity


def with_missing(records: list[Record], wanted: Iterable[str], owner: str) -> list[Record]:
    """The records with a finding added for every id in `wanted` that no finding has.

    `owner` is what requires them, such as "the baseline". An id whose absence follows from an error
    or a refusal is named in the sentence of that finding and gets no finding of its own.
    """
    present: set[str] = set()
    for record in records:
        present |= {record.id(finding) for finding in record.findings}
    missing: dict[Place, list[str]] = {}
    for name in sorted(set(wanted)):
        if name not in present:
            place, check, quantity = parts(name)
            missing.setdefault(place, []).append(f"{check}/{quantity}")
    completed = []
    for record in records:
        missing_here = missing.pop((record.label, record.engine, record.method), [])
        completed.append(_with_absent(record, missing_here, owner))
    # The remaining ids belong to records that were not made at all.
    vanished = [_vanished(place, names, owner) for place, names in missing.items()]
    return [*completed, *vanished]


def with_lost(records: list[Record], wanted: Iterable[str], owner: str) -> list[Record]:
    """The records in which a finding among `wanted` (ids) that is not decided now is lost."""
    wanted_ids = set(wanted)
    changed = []
    for record in records:
        findings = tuple(_lost(record, finding, wanted_ids, owner) for finding in record.findings)
        changed.append(msgspec.structs.replace(record, findings=findings))
    return changed


def _lost(record: Record, finding: Finding, wanted: set[str], owner: str) -> Finding:
    """The finding as it is, or as lost if it is wanted and not decided."""
    if record.id(finding) not in wanted or finding.outcome in (*DECIDED, "error"):
        return finding
    sentence = f"{finding.sentence} {_capital(owner)} contains a decided finding here."
    return msgspec.structs.replace(finding, outcome="lost", sentence=sentence)


def _with_absent(record: Record, missing: list[str], owner: str) -> Record:
    """A record with the findings (check/quantity) that are missing from it.

    Each is named in the sentence of the first finding that explains it, or else is absent.
    """
    findings = []
    unexplained = missing
    for finding in record.findings:
        explained = [name for name in unexplained if _explains(finding, name)]
        unexplained = [name for name in unexplained if name not in explained]
        if explained:
            finding = _folded(finding, explained, owner)
        findings.append(finding)
    findings += [_absent(name, owner) for name in unexplained]
    return msgspec.structs.replace(record, findings=tuple(findings))


def _explains(finding: Finding, name: str) -> bool:
    """True if the finding `name` (check/quantity) could not be made because of this one.

    A run that failed or was refused leaves nothing to judge. An error of one check explains only
    the missing findings of that check.
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
    """A record that was not made at all, with one finding for all that are missing with it."""
    label, engine, method = place
    sentence = (
        f"{_capital(owner)} contains {_counted(names)} for this case and method,"
        " and this run produced none: the case, the method or its support was"
        f" removed ({_named(names)})."
    )
    absent = Finding(check="record", quantity="findings", outcome="absent", sentence=sentence)
    return Record(
        case=label.partition("[")[0],
        label=label,
        parameters={},
        engine=engine,
        version="",
        method=method,
        is_reference=False,
        runs=(),
        findings=(absent,),
    )


def _counted(names: list[str]) -> str:
    """The number of findings in words."""
    if len(names) == 1:
        return "1 finding"
    return f"{len(names)} findings"


def _named(names: list[str]) -> str:
    """The first few names, and how many more there are."""
    if len(names) > MAX_NAMES:
        remainder = f" and {len(names) - MAX_NAMES} more"
    else:
        remainder = ""
    return ", ".join(names[:MAX_NAMES]) + remainder


def _capital(words: str) -> str:
    """The words with a capital first letter."""
    return words[:1].upper() + words[1:]
