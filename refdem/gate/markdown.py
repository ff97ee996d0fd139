"""A gate's outcome as Markdown for a pull request: under 60 lines, worst first, with how to
reproduce.
"""

from collections import Counter

from refdem.core.finding import BROKEN, WORST_FIRST, CaseSheet, Finding, Record, Sheet, worst_first
from refdem.core.outside import markdown_text, one_line
from refdem.gate.probing import LABEL

MAX_FINDINGS = 20
"""Most rows of the table, so that a comment on a pull request stays readable."""
MAX_SENTENCE = 300
"""Most characters of a finding's sentence in the table."""


def markdown(engine: str, sheets: list[Sheet]) -> str:
    """The outcome of a gate as Markdown; everything that comes from records is escaped."""
    pairs = worst_first(sheets)
    counts = Counter[str](finding.outcome for _, finding in pairs)
    broken = [(record, finding) for record, finding in pairs if finding.outcome in BROKEN]
    verdict = "open"
    if broken:
        verdict = "closed"
    totals = ", ".join(f"{counts[name]} {name}" for name in WORST_FIRST if counts[name])
    lines = [f"## refdem: the gate of {markdown_text(engine)} is {verdict}", ""]
    lines += [totals or "nothing was found", ""]
    if broken:
        lines += [
            "| outcome | finding | why |",
            "|---|---|---|",
            *(_row(*pair) for pair in broken[:MAX_FINDINGS]),
        ]
        if len(broken) > MAX_FINDINGS:
            lines.append(f"| | ... and {len(broken) - MAX_FINDINGS} more | |")
        lines += ["", "To reproduce, beside `refdem.toml`:", "", "```"]
        lines += [*_commands(sheets, [record for record, _ in broken]), "```"]
    return "\n".join(lines) + "\n"


def _row(record: Record, finding: Finding) -> str:
    """The row of a finding in the table, its sentence cut after MAX_SENTENCE characters."""
    name = markdown_text(record.id(finding))
    sentence = finding.sentence
    if len(sentence) > MAX_SENTENCE:
        sentence = f"{sentence[:MAX_SENTENCE]} ..."
    return f"| {finding.outcome} | {name} | {markdown_text(sentence)} |"


def _commands(sheets: list[Sheet], broken: list[Record]) -> list[str]:
    """A command that repeats each case of the broken records, at most ten."""
    reproduce = {sheet.label: sheet.reproduce for sheet in sheets if isinstance(sheet, CaseSheet)}
    labels = dict.fromkeys(record.label for record in broken)
    commands = [
        f"{reproduce[label]} --engine refdem.toml" for label in labels if label in reproduce
    ]
    if LABEL in labels:
        commands.insert(0, "refdem smoke refdem.toml")
    return commands[:10]


def annotations(sheets: list[Sheet]) -> list[str]:
    """Workflow commands that make GitHub show the worst ten findings beside the change."""
    broken = [pair for pair in worst_first(sheets) if pair[1].outcome in BROKEN]
    return [
        f"::error title={_data(record.id(finding), ',:')}::{_data(finding.sentence)}"
        for record, finding in broken[:10]
    ]


def _data(text: str, also_escaped: str = "") -> str:
    """Text, escaped as a workflow command needs it."""
    text = one_line(text)
    for character in "%" + also_escaped:
        text = text.replace(character, f"%{ord(character):02X}")
    return text
