"""Installs widely used codes, runs the gate of each, and writes reports/field/index.md: a matrix of
cases and codes, with digits and the time to accuracy, and the deviations with their scripts.

usage: ci/field.py [--no-install] [NAME...]; without names all folders of validation/codes that have
requirements of their own. A code whose packages cannot be installed is told of, and the others run.
"""

import argparse
import math
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from refdem.core.deviation import Deviation
from refdem.core.finding import Outcome, Record
from refdem.engines.external.sense import read
from refdem.report.jsonl import sheets_in

ROOT = Path(__file__).resolve().parents[1]
CODES = ROOT / "validation" / "codes"
ENVIRONMENTS = ROOT / ".venv-field"
OUT = ROOT / "reports" / "field"
ACCURACY = 1e-3
"""The error, in units of a quantity's scale, at which times are told: what a picture needs."""
REFDEM = "from refdem.cli import main; main()"
"""The command line, of the refdem that this Python imports."""
NOT_INSTALLED = "not installed"
TOLD: dict[Outcome, str] = {"expected": "deviations", "fail": "failed", "error": "errors"}
"""Outcomes of findings that a cell counts, and the words for them."""


def known() -> list[str]:
    """The codes that have an environment of their own."""
    return sorted(path.parent.name for path in CODES.glob("*/requirements.in"))


def is_installed(name: str) -> bool:
    """True if the environment of a code was made of the requirements that are there now."""
    stamp = ENVIRONMENTS / name / "made"
    wanted = (CODES / name / "requirements.txt").read_text()
    return stamp.is_file() and stamp.read_text() == wanted


def install(name: str) -> bool:
    """Makes the environment of a code, of files that its lock has the digests of; False if it
    fails.
    """
    home = ENVIRONMENTS / name
    lock = CODES / name / "requirements.txt"
    pip = [str(home / "bin" / "pip"), "install", "--require-hashes", "--only-binary", ":all:"]
    commands = [
        [sys.executable, "-m", "venv", "--clear", str(home)],
        [*pip, "--disable-pip-version-check", "--quiet", "--requirement", str(lock)],
    ]
    for command in commands:
        if subprocess.run(command, check=False).returncode != 0:
            return False
    (home / "made").write_text(lock.read_text())
    return True


def gated(name: str) -> int:
    """The exit status of the gate of a code, whose report goes into reports/field/NAME."""
    toml = str(CODES / name / "refdem.toml")
    command = [sys.executable, "-c", REFDEM, "gate", toml, "--out", str(OUT / name)]
    return subprocess.run(command, check=False, cwd=ROOT).returncode


def errors(records: Iterable[Record]) -> list[tuple[float, float]]:
    """The largest error of all quantities, and the seconds, of each level of each method."""
    found = []
    for record in records:
        worst: dict[float, tuple[float, float]] = {}
        levels = [
            level
            for finding in record.findings
            if finding.check == "error"
            for level in finding.levels
        ]
        for level in levels:
            error, seconds = worst.get(level.level, (0.0, 0.0))
            worst[level.level] = (max(error, level.error), max(seconds, level.seconds))
        found += list(worst.values())
    return [(error, seconds) for error, seconds in found if math.isfinite(error)]


def cell(records: list[Record]) -> str:
    """What a code did on a case: digits of its best run, the least time to the accuracy, and how
    many findings failed or deviate as expected.
    """
    if not records:
        return ""
    words = []
    levels = errors(records)
    best = min((error for error, _ in levels), default=math.inf)
    if 0 < best < 1:
        words.append(f"{-math.log10(best):.1f} digits")
    if best == 0:
        words.append("exact")
    in_time = [seconds for error, seconds in levels if error <= ACCURACY]
    if in_time:
        words.append(f"{1e3 * min(in_time):.2g} ms")
    outcomes = [finding.outcome for record in records for finding in record.findings]
    for outcome, word in TOLD.items():
        count = outcomes.count(outcome)
        if count:
            words.append(f"{count} {word}")
    return ", ".join(words) or "held"


def row(cells: Iterable[str]) -> str:
    """A line of a table in Markdown."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def deviations(name: str) -> list[str]:
    """Lines about the deviations of a code: its scripts, and what its gate expects."""
    folder = CODES / name
    expected: list[Deviation] = read(folder / "refdem.toml").expected
    lines = [
        f"- {deviation.case}, {deviation.check}/{deviation.quantity}: {deviation.reason}"
        for deviation in expected
    ]
    for script in sorted((folder / "deviations").glob("*.py")):
        title = script.read_text().split('"""')[1].strip().splitlines()[0]
        path = os.path.relpath(script, OUT)
        lines.append(f"- [{script.name}]({path}): {title}")
    return lines


def page(found: dict[str, list[Record]], statuses: dict[str, str]) -> str:
    """The page: states, the matrix of cases and codes, deviations."""
    codes = list(statuses)
    cases = list(dict.fromkeys(record.label for records in found.values() for record in records))
    lines = [
        "# Widely used codes under the gate",
        "",
        f"Digits are those of the best run; times are the least to an error of {ACCURACY:g}, in",
        "units of each quantity's scale, in the loop of the code's driver.",
        "",
        row(["code", "gate"]),
        row(["---", "---"]),
        *(row([name, statuses[name]]) for name in codes),
        "",
        row(["case", *codes]),
        row(["---"] * (len(codes) + 1)),
    ]
    for label in cases:
        cells = []
        for name in codes:
            of_case = [record for record in found.get(name, []) if record.label == label]
            cells.append(cell(of_case))
        lines.append(row([label, *cells]))
    for name in codes:
        lines += ["", f"## {name}", "", *deviations(name)]
    return "\n".join(lines) + "\n"


def records_of(name: str) -> list[Record]:
    """The records of the last gate of a code."""
    return [sheet for sheet in sheets_in(OUT / name) if isinstance(sheet, Record)]


def state(name: str, *, may_install: bool) -> str:
    """Installs a code if it is not there, runs its gate, and says how that ended."""
    if not is_installed(name) and not (may_install and install(name)):
        return NOT_INSTALLED
    status = gated(name)
    if status == 0:
        return "open"
    return f"closed, exit status {status}"


def main() -> int:
    """Exit status: 1 if a gate is closed, 2 if a code that was named is not there, else 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--no-install", action="store_true")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(known()))
    if unknown:
        parser.error(f"no code {', '.join(unknown)}; known are {', '.join(known())}")
    OUT.mkdir(parents=True, exist_ok=True)
    statuses = {}
    found = {}
    for name in arguments.names or known():
        statuses[name] = state(name, may_install=not arguments.no_install)
        if statuses[name] != NOT_INSTALLED:
            found[name] = records_of(name)
        print(f"{name}: {statuses[name]}", flush=True)
    (OUT / "index.md").write_text(page(found, statuses))
    print(f"page: {OUT / 'index.md'}")
    if any(status.startswith("closed") for status in statuses.values()):
        return 1
    if NOT_INSTALLED in statuses.values():
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
