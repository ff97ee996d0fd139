"""A gate's outcome as Markdown for a pull request: under 60 lines, worst first, with how to reproduce."""

from collections import Counter

from refdem.core.finding import FAILING, WORST_FIRST, CaseSheet, Finding, Record, Sheet

SHOWN = 20
LONGEST = 300


def markdown(engine: str, sheets: list[Sheet]) -> str:
    """The text; everything that comes from records is escaped."""
    pairs = [(sheet, finding) for sheet in sheets if isinstance(sheet, Record) for finding in sheet.findings]
    pairs.sort(key=lambda pair: (WORST_FIRST.index(pair[1].outcome), pair[1].margin or 0.0))
    counts = Counter[str](finding.outcome for _, finding in pairs)
    broken = [(record, finding) for record, finding in pairs if finding.outcome in (*FAILING, "error")]
    verdict = "closed" if broken else "open"
    lines = [f"## refdem: the gate of {escaped(engine)} is {verdict}", ""]
    lines += [", ".join(f"{counts[name]} {name}" for name in WORST_FIRST if counts[name]) or "nothing was found", ""]
    if broken:
        lines += ["| outcome | finding | why |", "|---|---|---|", *(_row(*pair) for pair in broken[:SHOWN])]
        if len(broken) > SHOWN:
            lines.append(f"| | ... and {len(broken) - SHOWN} more | |")
        lines += ["", "To reproduce, beside `refdem.toml`:", "", "```"]
        lines += [*_commands(sheets, [record for record, _ in broken]), "```"]
    return "\n".join(lines) + "\n"


def _row(record: Record, finding: Finding) -> str:
    name = escaped(record.id(finding))
    return f"| {finding.outcome} | {name} | {escaped(finding.sentence[:LONGEST])} |"


def _commands(sheets: list[Sheet], broken: list[Record]) -> list[str]:
    """A command for each case that is broken, at most ten."""
    how = {sheet.label: sheet.reproduce for sheet in sheets if isinstance(sheet, CaseSheet)}
    labels = list(dict.fromkeys(record.label for record in broken))
    return [f"{how[label]} --engine refdem.toml" for label in labels if label in how][:10]


def escaped(text: str) -> str:
    """Text that stays text in a Markdown table."""
    for character in "\\`*_[]<>|#~":
        text = text.replace(character, "&#" + str(ord(character)) + ";")
    return " ".join(text.split())


def annotations(sheets: list[Sheet]) -> list[str]:
    """Workflow commands that make GitHub show the worst ten findings beside the change."""
    pairs = [(s, f) for s in sheets if isinstance(s, Record) for f in s.findings if f.outcome in (*FAILING, "error")]
    pairs.sort(key=lambda pair: (WORST_FIRST.index(pair[1].outcome), pair[1].margin or 0.0))
    return [f"::error title={_data(record.id(finding), ',:')}::{_data(finding.sentence)}" for record, finding in pairs[:10]]


def _data(text: str, more: str = "") -> str:
    """Text as a workflow command takes it."""
    for character in "%\r\n" + more:
        text = text.replace(character, f"%{ord(character):02X}")
    return text
