"""What a run prints at its end: counts, the worst findings in full sentences, and the exit
status.
"""

from collections import Counter
from collections.abc import Iterable

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
"""Findings that are printed, the worst: a screen of them."""
VOID = 2
"""Exit status where nothing was judged: what was asked for cannot be judged, which is neither a
pass nor a failure.
"""


def exit_status(sheets: Iterable[Sheet]) -> int:
    """1 if a check failed or a deviation is stale, else 3 if an engine broke, else 2 if nothing was
    judged, else 0.
    """
    outcomes = {finding.outcome for _, finding in worst_first(sheets)}
    if outcomes & set(FAILING):
        return 1
    if "error" in outcomes:
        return 3
    if outcomes & set(DECIDED):
        return 0
    return VOID


def lines(sheets: list[Sheet]) -> list[str]:
    """The summary, line by line: errors first, then what failed, then engines that judged nothing,
    with their reasons.
    """
    every = worst_first(sheets)
    worst = [(record, finding) for record, finding in every if finding.outcome in BROKEN]
    # Records may come from a file: each of the two is a line of its own again.
    shown = [
        f"{finding.outcome.upper():6} {one_line(record.id(finding))}\n      "
        f" {one_line(finding.sentence)}"
        for record, finding in worst[:MAX_FINDINGS]
    ]
    if len(worst) > MAX_FINDINGS:
        shown.append(f"       ... and {len(worst) - MAX_FINDINGS} more; the report has them all")
    shown += unjudged(sheets)
    counts = Counter[str](finding.outcome for _, finding in every)
    shown.append(
        ", ".join(f"{counts[name]} {name}" for name in WORST_FIRST if counts[name])
        or "nothing was found"
    )
    for sheet in sheets:
        if isinstance(sheet, CampaignSheet):
            shown.append(
                f"{sheet.runs_made} runs made, {sheet.runs_read} read from the store,"
                f" {sheet.seconds:.1f} s"
            )
    if exit_status(sheets) == VOID:
        shown.append(
            "nothing was judged: `refdem explain CASE --engine ENGINE` says what would run, and"
            " what is left out and why"
        )
    return shown


def unjudged(sheets: Iterable[Sheet]) -> list[str]:
    """Every engine of which nothing was judged, with the reason for each case and method, equal
    ones together.
    """
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    judged = {
        record.engine
        for record, finding in findings_of(records)
        if finding.outcome in (*DECIDED, *BROKEN)
    }
    reasons: dict[tuple[str, str, str], list[str]] = {}
    for record in records:
        if record.engine in judged:
            continue
        for finding in record.findings:
            reasons.setdefault((record.label, record.engine, finding.sentence), []).append(
                record.method
            )
    told = [
        one_line(f"{label}/{engine} ({', '.join(methods)}): {says}")
        for (label, engine, says), methods in reasons.items()
    ]
    if len(told) > MAX_FINDINGS:
        more = [f"... and {len(told) - MAX_FINDINGS} more reasons; the report has them all"]
    else:
        more = []
    return told[:MAX_FINDINGS] + more
