"""What a run prints at its end: counts, the worst findings in full sentences, and the exit
status.
"""

import json
from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path

from refdem.core.finding import (
    BROKEN,
    DECIDED,
    FAILING,
    WORST_FIRST,
    CampaignSheet,
    Record,
    Sheet,
    findings_of,
    worst_first,
)
from refdem.core.outside import one_line

MAX_FINDINGS = 20
"""Largest number of printed findings, the worst ones: one screen of them."""
MAX_REASONS = 6
"""Largest number of printed reasons for partial refusals, those of most findings."""
FEW = 4
"""Largest number of names in a line."""
VOID = 2
"""Exit status if nothing was judged: the request cannot be judged, which is neither a pass nor a
failure.
"""


def exit_status(sheets: Iterable[Sheet], absent: Collection[str] = ()) -> int:
    """1 if a check failed or a deviation is stale, else 3 if an engine broke, else 2 if nothing was
    judged or a requested engine is `absent`, else 0.
    """
    outcomes = {finding.outcome for _, finding in worst_first(sheets)}
    if outcomes & set(FAILING):
        return 1
    if "error" in outcomes:
        return 3
    if outcomes & set(DECIDED) and not absent:
        return 0
    return VOID


def lines(sheets: list[Sheet]) -> list[str]:
    """The summary, line by line: errors first, then what failed, then engines that judged nothing,
    with their reasons, then counts, and why engines that judged something refused the rest.
    """
    findings = worst_first(sheets)
    broken = [(record, finding) for record, finding in findings if finding.outcome in BROKEN]
    printed = []
    for record, finding in broken[:MAX_FINDINGS]:
        # Records may come from a file: line breaks in them would be taken for the end of a finding.
        printed.append(f"{finding.outcome.upper():6} {one_line(record.id(finding))}")
        printed.append(f"       {one_line(finding.sentence)}")
    if len(broken) > MAX_FINDINGS:
        printed.append(f"       ... and {len(broken) - MAX_FINDINGS} more; the report lists all")
    printed += unjudged(sheets)
    counts = Counter[str](finding.outcome for _, finding in findings)
    totals = ", ".join(f"{counts[name]} {name}" for name in WORST_FIRST if counts[name])
    printed.append(totals or "nothing was found")
    printed += refused(sheets)
    for sheet in sheets:
        if isinstance(sheet, CampaignSheet):
            printed.append(
                f"{sheet.runs_made} runs made, {sheet.runs_read} read from the store,"
                f" {sheet.seconds:.1f} s"
            )
    if exit_status(sheets) == VOID:
        printed.append(
            "nothing was judged: `refdem explain CASE --engine ENGINE` says what would run, and"
            " what is left out and why"
        )
    return printed


def printed_json(
    sheets: list[Sheet],
    report: Path,
    changes: list[str],
    absent: list[str],
    without_effect: list[str],
) -> str:
    """The outcome of a run as JSON: how many findings have each outcome, every finding that failed
    or broke, why engines judged nothing or refused a part, and where the report is.

    `changes` are those to the list of findings that the campaign must make; `absent` has a sentence
    for each engine that was requested and is not installed, `without_effect` one for each parameter
    that changes nothing.
    """
    findings = worst_first(sheets)
    counts = Counter[str](finding.outcome for _, finding in findings)
    broken = [
        {"id": record.id(finding), "outcome": finding.outcome, "sentence": finding.sentence}
        for record, finding in findings
        if finding.outcome in BROKEN
    ]
    answer = {
        "exit_status": exit_status(sheets, absent),
        "outcomes": {name: counts[name] for name in WORST_FIRST if counts[name]},
        "broken": broken,
        "unjudged": unjudged(sheets),
        "refused": refused(sheets, most=None),
        "absent": absent,
        "without_effect": without_effect,
        "changes": changes,
        "report": str(report),
    }
    return json.dumps(answer, indent=1)


def judged_engines(records: list[Record]) -> set[str]:
    """The engines with a decided finding or an error."""
    return {
        record.engine
        for record, finding in findings_of(records)
        if finding.outcome in (*DECIDED, *BROKEN)
    }


def refused(sheets: Iterable[Sheet], most: int | None = MAX_REASONS) -> list[str]:
    """A line for each reason for which engines that judged something refused a part: the engine,
    how many methods and cases; the `most` frequent reasons, or all.
    """
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    judged = judged_engines(records)
    # The records by engine and reason.
    of_reason: dict[tuple[str, str], list[Record]] = {}
    for record, finding in findings_of(records):
        if finding.outcome == "unsupported" and record.engine in judged:
            of_reason.setdefault((record.engine, finding.sentence), []).append(record)
    by_count = sorted(of_reason.items(), key=lambda item: -len(item[1]))
    printed = []
    for (engine, reason), own in by_count[:most]:
        methods = listed(record.method for record in own)
        cases = listed(record.case for record in own)
        printed.append(
            one_line(f"{len(own)} unsupported in {engine} ({methods}; {cases}): {reason}")
        )
    left_out = len(by_count) - len(printed)
    if left_out:
        printed.append(f"... and {left_out} more reasons for refusals; the report lists all")
    return printed


def listed(names: Iterable[str]) -> str:
    """The names, each once; of many the number and the first."""
    once = list(dict.fromkeys(names))
    if len(once) <= FEW:
        return ", ".join(once)
    return f"{', '.join(once[:FEW])} and {len(once) - FEW} more"


def unjudged(sheets: Iterable[Sheet]) -> list[str]:
    """A line for each case and reason of every engine of which nothing was judged, with the methods
    that have that reason.
    """
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    judged = judged_engines(records)
    # The methods by case, engine and reason.
    methods_by_reason: dict[tuple[str, str, str], list[str]] = {}
    for record in records:
        if record.engine in judged:
            continue
        for finding in record.findings:
            key = (record.label, record.engine, finding.sentence)
            methods_by_reason.setdefault(key, []).append(record.method)
    printed = []
    for (label, engine, reason), methods in methods_by_reason.items():
        printed.append(one_line(f"{label}/{engine} ({', '.join(methods)}): {reason}"))
    left_out = len(printed) - MAX_FINDINGS
    if left_out > 0:
        return [
            *printed[:MAX_FINDINGS],
            f"... and {left_out} more reasons; the report lists all",
        ]
    return printed
