"""What a run prints at its end: counts, the worst findings in full sentences, and the exit status."""

from collections import Counter
from collections.abc import Iterable

from refdem.core.finding import BROKEN, FAILING, WORST_FIRST, CampaignSheet, Sheet, worst_first

SHOWN = 20


def exit_status(sheets: Iterable[Sheet]) -> int:
    """1 if a check failed or a deviation is stale, else 3 if an engine broke, else 0."""
    outcomes = {finding.outcome for _, finding in worst_first(sheets)}
    return 1 if outcomes & set(FAILING) else 3 if "error" in outcomes else 0


def lines(sheets: list[Sheet]) -> list[str]:
    """The summary, line by line."""
    every = worst_first(sheets)
    worst = [(record, finding) for record, finding in every if finding.outcome in BROKEN]
    shown = [f"{finding.outcome.upper():6} {record.id(finding)}\n       {finding.sentence}" for record, finding in worst[:SHOWN]]
    if len(worst) > SHOWN:
        shown.append(f"       ... and {len(worst) - SHOWN} more; the report has them all")
    counts = Counter[str](finding.outcome for _, finding in every)
    shown.append(", ".join(f"{counts[name]} {name}" for name in WORST_FIRST if counts[name]) or "nothing was found")
    for sheet in sheets:
        if isinstance(sheet, CampaignSheet):
            shown.append(f"{sheet.runs_made} runs made, {sheet.runs_read} read from the store, {sheet.seconds:.1f} s")
    return shown
