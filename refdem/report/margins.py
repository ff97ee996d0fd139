"""Margins of a campaign's findings, log10 of bound over value, by check, case and engine.

A bound three decades above all values that were measured against it detects little.
`python -m refdem.report.margins FOLDER` prints the groups of findings all of whose margins are that
wide, and the distribution of margins for each check.
"""

import math
import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from statistics import median

from refdem.core.finding import DECIDED, Finding, Record
from refdem.errors import RefdemError
from refdem.report.jsonl import sheets_in

LOOSE = 3.0
"""Decades: a group all of whose margins are at least this wide is loose."""
AT_ROUND_OFF = 1e-9
"""A bound below this fraction of a scale is one of round-off. It leaves two decades of room for
other processors.
"""


@dataclass(frozen=True)
class Group:
    """The decided findings with a finite margin of one check on one instance in one engine, over
    all methods and quantities.
    """

    check: str
    label: str
    engine: str
    findings: tuple[Finding, ...]

    @property
    def margins(self) -> list[float]:
        """Decades between value and bound."""
        return [finding.margin for finding in self.findings if finding.margin is not None]

    @property
    def is_loose(self) -> bool:
        """True if no value came near its bound."""
        return min(self.margins) >= LOOSE

    @property
    def nearest(self) -> Finding:
        """The finding that came nearest to its bound."""
        return min(self.findings, key=lambda finding: finding.margin or 0.0)

    @property
    def is_at_round_off(self) -> bool:
        """True if the finding that came nearest to its bound has a bound at round-off."""
        return self.nearest.bound is not None and self.nearest.bound < AT_ROUND_OFF

    @property
    def line(self) -> str:
        """The finding that came nearest to its bound, in one line."""
        nearest = self.nearest
        sharpness = "-"
        if nearest.sharpness is not None:
            sharpness = f"{nearest.sharpness:.1e}"
        text = f"value {nearest.value:.1e}, bound {nearest.bound:.1e}, sharpness {sharpness}"
        return (
            f"{self.check}  {self.label}  {self.engine}: {nearest.quantity} has"
            f" {nearest.margin:.1f} decades ({text})"
        )


def groups(records: Iterable[Record]) -> list[Group]:
    """The groups, sorted by name; undecided findings and values of exactly 0 have no margin."""
    by_group: dict[tuple[str, str, str], list[Finding]] = defaultdict(list)
    for record in records:
        for finding in record.findings:
            margin = finding.margin
            if finding.outcome in DECIDED and margin is not None and math.isfinite(margin):
                by_group[finding.check, record.label, record.engine].append(finding)
    return [Group(*names, tuple(findings)) for names, findings in sorted(by_group.items())]


def margins_by_check(groups: Iterable[Group], *, at_round_off: bool) -> dict[str, list[float]]:
    """Margins by check, of bounds at round-off or of all others."""
    margins: dict[str, list[float]] = defaultdict(list)
    for group in groups:
        for finding in group.findings:
            small = finding.bound is not None and finding.bound < AT_ROUND_OFF
            if small == at_round_off and finding.margin is not None:
                margins[group.check].append(finding.margin)
    return dict(margins)


def summary(groups: list[Group]) -> list[str]:
    """Lines for people: loose groups, then medians."""
    loose = [group for group in groups if group.is_loose]
    lines = [
        f"{len(loose)} of {len(groups)} groups are {LOOSE:g} decades or more above what is measured"
        " throughout."
    ]
    lines += [f"  {group.line}" for group in loose]
    for at_round_off, words in ((True, "at round-off"), (False, "above round-off")):
        by_check = margins_by_check(groups, at_round_off=at_round_off)
        every = list(chain.from_iterable(by_check.values()))
        if every:
            middle = median(every)
            lines.append(f"{len(every)} bounds {words}: the median margin is {middle:.2f} decades.")
        for check, margins in sorted(by_check.items()):
            lines.append(f"  {check}: {median(margins):.2f} of {len(margins)}")
    return lines


def main(arguments: list[str]) -> int:
    """Prints the summary of the records in a folder; 2 for bad input."""
    if len(arguments) != 1:
        print(
            "usage: python -m refdem.report.margins FOLDER (of a report with records.jsonl)",
            file=sys.stderr,
        )
        return 2
    try:
        records = [sheet for sheet in sheets_in(Path(arguments[0])) if isinstance(sheet, Record)]
    except RefdemError as error:
        print(error, file=sys.stderr)
        return 2
    print("\n".join(summary(groups(records))))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
