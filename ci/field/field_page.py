"""The page of the field, reports/field/index.md, and a badge for each code, from the results that
are kept there and the descriptions in validation/codes; nothing runs.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from field_results import ACCURACY, Kept, Law, Result, read

from refdem.core import discovery
from refdem.core.deviation import Deviation
from refdem.core.finding import BROKEN, Finding, Record
from refdem.core.outside import markdown_text
from refdem.core.parameters import labelled
from refdem.core.problem import Problem
from refdem.engines.external import External
from refdem.report.invariants import KEPT
from refdem.report.markdown import table
from refdem.report.numbers import two
from refdem.report.overview import shown_digits
from refdem.report.tolerance import digits

SYMBOLS = {
    "momentum": "p",
    "angular-momentum": "L",
    "energy": "E",
    "constraint": "rod",
    "quaternion-norm": "|q|",
    "reversal": "back",
}
"""How a cell names what is conserved, by check."""
EMPTY = "Why cells are empty"
LISTED = " (not in `supports` of refdem.toml)"
"""How a refusal by `supports` ends."""
INTRODUCTION = f"""# Widely used codes under the gate

A line a case, a column a code, each with the version that ran and the day. Codes for rigid bodies
and for discrete elements stand side by side: a case asks the same of both.

- **Digits** are the decimal logarithm of 1/error at the finest step, in the worst quantity, in
  units of its scale.
- **What is conserved**: momentum p, angular momentum L, energy E with the work that a run reports,
  the length of a rod, the norm |q| of attitudes, and the way back to the start in reversed time.
  "Keeps" is to round-off ({KEPT:g}), "to" has the largest change, and "loses" is more than the
  method claims.
- **Derivatives** of what a code reports by the numbers of a case, where it computes them, are right
  if they converge to the certified ones with the order of its method, and else wrong.
- **Time** is that of the code's own loop, on one machine, at the largest step from which on all
  errors are at most {ACCURACY:g}.
- **Deviations** are findings beyond a bound that the gate expects, each with its reason, a script
  that shows it without refdem, and the place in the code or its documents.
- **Worse** and **lost** compare with what the gate accepted before, and say nothing of a bound;
  **undecided** is what no bound could tell.
- **Steps** that DEM codes choose or recommend for contacts, judged: [steps.md](../steps.md).
- **Empty cells** say why in a word, and as a title in full.

`make field CODES=NAME` runs a code again; `ci/field/field.py --page` makes this page anew from the
results beside it. A badge is `reports/field/NAME.svg`.
"""
BADGE = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="20" role="img" aria-label="{words}">
<title>{words}</title>
<rect width="{width}" height="20" rx="3" fill="#24292f"/>
<path d="M58 0h{span}a3 3 0 0 1 3 3v14a3 3 0 0 1-3 3H58z" fill="{colour}"/>
<g fill="#fff" font-family="DejaVu Sans,Verdana,sans-serif" font-size="11">
<text x="8" y="14">refdem</text>
<text x="66" y="14" textLength="{length}">{message}</text>
</g>
</svg>
"""


@dataclass(frozen=True)
class Code:
    """A code: its folder, its description, and what its last run found, None if it never ran."""

    folder: Path
    kept: Kept | None

    @property
    def name(self) -> str:
        """The name of the code, that of its folder."""
        return self.folder.name

    @property
    def version(self) -> str:
        """The version that ran; empty if none did."""
        if self.kept is None:
            return ""
        return self.kept.run.version

    @cached_property
    def engine(self) -> External:
        """The engine that its refdem.toml describes."""
        return External(self.folder / "refdem.toml")

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The deviations that it expects, by their reason, counted from 1."""
        reasons = dict.fromkeys(deviation.reason for deviation in self.engine.expected)
        return {reason: number for number, reason in enumerate(reasons, 1)}

    def of(self, label: str) -> list[Result]:
        """The results on a case."""
        if self.kept is None:
            return []
        return [result for result in self.kept.results if result.label == label]


def codes_in(codes: Path, out: Path) -> list[Code]:
    """Every code that has a description, by name."""
    found = []
    for description in sorted(codes.glob("*/refdem.toml")):
        path = out / f"{description.parent.name}.jsonl"
        kept = None
        if path.is_file():
            kept = read(path)
        found.append(Code(description.parent, kept))
    return found


def page(codes: Path, out: Path) -> str:
    """The text of the page, which lies in `out`, of the codes in the folder `codes`."""
    every = codes_in(codes, out)
    shown = [code for code in every if code.kept is not None]
    never = [code.name for code in every if code.kept is None]
    parts = [INTRODUCTION.rstrip(), codes_table(shown)]
    if never:
        parts.append(f"Never run here: {', '.join(never)}.")
    parts += ["## Cases and codes", matrix(shown, out), f"## {EMPTY}", empty(shown)]
    for code in every:
        parts += section(code, out)
    return "\n\n".join(parts) + "\n"


def codes_table(codes: Sequence[Code]) -> str:
    """A line a code: version, day, how its gate ended, and what its methods are."""
    lines = []
    for code in codes:
        assert code.kept is not None
        run = code.kept.run
        methods = [
            f"{markdown_text(name)}: {markdown_text(summary)}"
            for name, summary in run.methods.items()
        ]
        name = f"[{code.name}](#{code.name})"
        version = markdown_text(run.version)
        lines.append([name, version, run.date, run.state, "<br>".join(methods)])
    return table(["code", "version", "run on", "gate", "methods"], lines)


def labels_of(codes: Sequence[Code]) -> list[str]:
    """Every case that some code was asked, sorted."""
    kept = [code.kept for code in codes if code.kept is not None]
    return sorted({result.label for one in kept for result in one.results})


def matrix(codes: Sequence[Code], out: Path) -> str:
    """The table of cases and codes."""
    lines = []
    for label in labels_of(codes):
        case, _ = labelled(label)
        shown = markdown_text(label)
        if (out.parent / "manual" / f"{case}.md").is_file():
            shown = f"[{shown}](../manual/{case}.md)"
        lines.append([shown, *(cell(code, label) for code in codes)])
    heads = [f"[{code.name}](#{code.name})<br>{markdown_text(code.version)}" for code in codes]
    return table(["case", *heads], lines)


def cell(code: Code, label: str) -> str:
    """What a code did on a case, a line a fact; of several methods each by its name."""
    found = code.of(label)
    if all(result.refused for result in found):
        return link(*why_empty(code, label))
    lines = []
    for result in found:
        if len(code.engine.methods) > 1:
            lines.append(f"**{markdown_text(result.method)}**")
        lines += facts(code, result)
    return "<br>".join(lines)


def facts(code: Code, result: Result) -> list[str]:
    """What one method did on a case: digits, what is conserved, time, and what is out of bounds."""
    if result.refused:
        return [link(*refusal(result))]
    lines = []
    if result.error is not None:
        title = f"error {two(result.error)} in {result.quantity}"
        lines.append(link(f"{shown_digits(digits(result.error))} digits", title, code.name))
    lines += conserved(result.laws)
    if result.derivatives in ("right", "wrong"):
        lines.append(f"{result.derivatives} derivatives")
    if result.seconds is not None:
        lines.append(f"{two(1e3 * result.seconds)} ms")
    for outcome in (*BROKEN, "undecided"):
        if outcome in result.counts:
            lines.append(f"{result.counts[outcome]} {outcome}")
    numbers = sorted({code.numbers[reason] for reason in reasons(code, result)})
    if numbers:
        links = [f"[{number}](#{code.name}-{number})" for number in numbers]
        lines.append(f"deviates: {', '.join(links)}")
    return lines or ["held"]


def conserved(laws: dict[str, Law]) -> list[str]:
    """The laws that are kept to round-off, those to an error of the step, and those that are
    lost.
    """
    kept = [SYMBOLS[check] for check in SYMBOLS if has(laws, check, "kept")]
    lost = [SYMBOLS[check] for check in SYMBOLS if has(laws, check, "lost")]
    near = [
        f"{SYMBOLS[check]} to {two(laws[check].change)}"
        for check in SYMBOLS
        if has(laws, check, "approximate")
    ]
    words = []
    if kept:
        words.append(f"keeps {', '.join(kept)}")
    words += near
    if lost:
        words.append(f"loses {', '.join(lost)}")
    return [markdown_text(line) for line in words]


def has(laws: dict[str, Law], check: str, verdict: str) -> bool:
    """True if a law was judged so."""
    return check in laws and laws[check].verdict == verdict


def reasons(code: Code, result: Result) -> list[str]:
    """The reasons of what deviates as expected."""
    assert code.kept is not None
    record = Record(
        case=labelled(result.label)[0],
        label=result.label,
        parameters={},
        engine=code.name,
        version=code.version,
        method=result.method,
        is_reference=False,
        runs=(),
        findings=(),
    )
    found = []
    for deviation in result.deviations:
        check, _, quantity = deviation.partition("/")
        finding = Finding(check=check, quantity=quantity, outcome="expected", sentence="")
        covering = [one for one in code.engine.expected if one.covers(record, finding)]
        found += [one.reason for one in covering[:1]]
    return found


@cache
def problem_of(label: str) -> Problem:
    """The question that a case asks."""
    case, given = labelled(label)
    return discovery.case(case).at(**given).problem


def refusal(result: Result) -> tuple[str, str]:
    """Why a method ran nothing of a case, in a word and in full."""
    return result.refused, f"The driver refuses: {result.refused}."


def why_empty(code: Code, label: str) -> tuple[str, str]:
    """Why a code has no result on a case, in a word and in full."""
    for result in code.of(label):
        return refusal(result)
    problem = problem_of(label)
    lacking = [code.engine.unsupported(problem, method) for method in code.engine.methods]
    if None in lacking:
        return "not asked", "The gate did not ask for this case when it last ran."
    reason = str(lacking[0])
    if not reason.endswith(LISTED):
        return reason, f"The adapter refuses: {reason}."
    features = reason.removesuffix(LISTED)
    return f"no {features}", f"The scene has {features}, which the adapter does not support."


def link(words: str, title: str, place: str = "") -> str:
    """Words with a title, which lead to a place of this page: that of the reasons by default."""
    slug = place or EMPTY.lower().replace(" ", "-")
    shown = markdown_text(title).replace('"', "&quot;")
    return f'[{markdown_text(words)}](#{slug} "{shown}")'


def empty(codes: Sequence[Code]) -> str:
    """Every reason of an empty cell, in full, with the codes that gave it."""
    found: dict[tuple[str, str], list[str]] = {}
    for label in labels_of(codes):
        for code in codes:
            results = code.of(label)
            told = {refusal(one) for one in results if one.refused}
            if not results:
                told = {why_empty(code, label)}
            for reason in told:
                names = found.setdefault(reason, [])
                if code.name not in names:
                    names.append(code.name)
    lines = [
        f"- **{markdown_text(short)}**: {markdown_text(full)} ({', '.join(sorted(names))})"
        for (short, full), names in sorted(found.items())
    ]
    return "\n".join(lines)


def section(code: Code, out: Path) -> list[str]:
    """The section of one code: its badge, its scripts, and a part for each reason of a deviation;
    empty if it has none of these.
    """
    parts = [f"## {code.name}"]
    if code.kept is not None:
        parts.append(f"![{message(code.kept)}]({code.name}.svg)")
    scripts = [
        f"- {script_link(script, out)}: {markdown_text(title_of(script))}"
        for script in sorted((code.folder / "deviations").glob("*.*"))
    ]
    if scripts:
        parts.append("\n".join(scripts))
    for reason, number in code.numbers.items():
        parts += [f"### {code.name} {number}", deviation_text(code, reason, out)]
    if len(parts) == 1:
        return []
    return parts


def deviation_text(code: Code, reason: str, out: Path) -> str:
    """A reason to deviate: its scripts, its quotation, and the findings that it excuses."""
    own = [one for one in code.engine.expected if one.reason == reason]
    names = dict.fromkeys(re.findall(r"deviations/[\w.]+\.(?:py|js|cpp)", reason))
    evidence = [script_link(code.folder / name, out) for name in names]
    sources = dict.fromkeys(one.link for one in own if one.link)
    evidence += [f"[source]({source})" for source in sources]
    findings = [f"- {markdown_text(excused(one))}" for one in own]
    head = f"{markdown_text(reason)}\n\nShown by {', '.join(evidence)}; it excuses"
    return "\n".join([f"{head}\n", *findings])


def excused(one: Deviation) -> str:
    """The findings that a deviation is about, and the range of their values."""
    place = f"{one.case}, {one.method}, {one.check}/{one.quantity}"
    return f"{place}: {two(one.low)} to {two(one.high)}, version {one.versions}"


def script_link(script: Path, out: Path) -> str:
    """A link from the page to a script."""
    return f"[{script.name}]({os.path.relpath(script, out)})"


def title_of(script: Path) -> str:
    """The first line of what a script, in Python, JavaScript or C++, says of itself."""
    said = re.match(r'("""|// )(.+)', script.read_text())
    if said is None:
        raise ValueError(f"{script} has no title: expected a docstring or a comment at its start")
    return said[2].removesuffix('"""')


def message(kept: Kept) -> str:
    """What a badge says: in how many cases every bound held, some deviate as expected, and some
    are wrong. What is worse than a baseline, within its bound, is for the gate.
    """
    ran = [result for result in kept.results if not result.refused]
    cases = {result.label for result in ran}
    wrong = {result.label for result in ran if {"fail", "error"} & result.counts.keys()}
    deviating = {result.label for result in ran if result.deviations} - wrong
    words = [f"{len(cases - wrong - deviating)} of {len(cases)} cases hold"]
    if deviating:
        words.append(f"{len(deviating)} deviate")
    if wrong:
        words.append(f"{len(wrong)} fail")
    return ", ".join(words)


def badge(kept: Kept) -> str:
    """The badge of a code: green where its gate is open, amber if something deviates, else red."""
    colour = "#1a7f37"
    if any(result.deviations for result in kept.results):
        colour = "#9a6700"
    if kept.run.state != "open":
        colour = "#cf222e"
    words = message(kept)
    # Letters of 11 pixels are 6.2 wide on average; textLength makes every font agree.
    length = round(6.2 * len(words))
    return BADGE.format(
        width=length + 74,
        span=length + 13,
        length=length,
        colour=colour,
        message=words,
        words=f"refdem: {words}",
    )
