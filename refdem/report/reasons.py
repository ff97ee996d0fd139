"""Reasons why findings are not passes.

For each outcome every sentence is shown once, with the findings that have it. Undecided findings
are grouped by their first statement.
"""

from dataclasses import dataclass, field

from refdem.core.finding import WORST_FIRST, Finding, Outcome, Record
from refdem.report.contents import Contents

Findings = list[tuple[Record, Finding]]
"""Findings with the records that they stand in."""


@dataclass(frozen=True)
class Reason:
    """A reason, and the findings for which it holds, by the rest of their sentences after it, which
    may be empty.
    """

    heading: str
    details: dict[str, Findings] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """The number of findings of all its sentences."""
        return sum(len(found) for found in self.details.values())


def reasons_by_outcome(contents: Contents) -> dict[Outcome, list[Reason]]:
    """What is not a pass: the reasons of each outcome, worst outcome first."""
    sentences: dict[Outcome, dict[str, Findings]] = {}
    for record, finding in contents.findings():
        if finding.outcome != "pass":
            by_sentence = sentences.setdefault(finding.outcome, {})
            by_sentence.setdefault(finding.sentence, []).append((record, finding))
    return {
        outcome: _grouped(sentences[outcome], outcome)
        for outcome in WORST_FIRST
        if outcome in sentences
    }


def _grouped(sentences: dict[str, Findings], outcome: Outcome) -> list[Reason]:
    """Sentences as reasons: undecided ones with the same first statement are joined.

    Sentences of failures stay separate, because a reader needs the numbers in them.
    """
    if outcome != "undecided":
        return [Reason(sentence, {"": found}) for sentence, found in sentences.items()]
    reasons: dict[str, Reason] = {}
    for sentence, found in sentences.items():
        first, stop, rest = sentence.partition(". ")
        heading = first + stop.strip()
        reasons.setdefault(heading, Reason(heading)).details[rest] = found
    return sorted(reasons.values(), key=lambda reason: -reason.count)


def refusals(refused: Findings) -> list[tuple[str, list[str], dict[str, str]]]:
    """(engine, methods, {label: id of a finding}) for each engine that refused for one reason."""
    engines: dict[str, tuple[list[str], dict[str, str]]] = {}
    for record, finding in refused:
        methods, places = engines.setdefault(record.engine, ([], {}))
        places.setdefault(record.label, record.id(finding))
        if record.method not in methods:
            methods.append(record.method)
    return [(engine, methods, places) for engine, (methods, places) in engines.items()]
