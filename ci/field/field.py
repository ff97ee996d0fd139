"""Installs widely used codes, runs the gate of each, and writes reports/field/index.md: a matrix of
cases and codes, with digits and the time to accuracy, and the deviations with their scripts.
Codes that are not run now keep the results of their last run, with version and date.

usage: ci/field/field.py [--no-install] [NAME...]; without names all folders of validation/codes
that have requirements of their own, of Python (requirements.in), of Node.js (package.json) or of
Debian (debian.txt, with a Makefile). A code whose packages cannot be installed is told of, and the
others run.
"""

import argparse
import hashlib
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from refdem.core.deviation import Deviation
from refdem.core.finding import Outcome, Record
from refdem.engines.external.sense import read
from refdem.report.jsonl import RECORDS, sheets_in

ROOT = Path(__file__).resolve().parents[2]
CODES = ROOT / "validation" / "codes"
ENVIRONMENTS = ROOT / ".venv-field"
OUT = ROOT / "reports" / "field"
ACCURACY = 1e-3
"""The error, in units of a quantity's scale, at which times are told: what a picture needs."""
REFDEM = "from refdem.cli import main; main()"
"""The command line, of the refdem that this Python imports."""
NOT_INSTALLED = "not installed"
ENDED = "ended.json"
"""The file beside the report of a code that keeps how its last run ended."""
TOLD: dict[Outcome, str] = {"expected": "deviations", "fail": "failed", "error": "errors"}
"""Outcomes of findings that a cell counts, and the words for them."""


LOCKS = {
    "requirements.in": "requirements.txt",
    "package.json": "package-lock.json",
    "debian.txt": "debian.txt",
}
"""What a code asks for, of Python, Node.js or Debian, and the lock that pins it with digests."""


def known() -> list[str]:
    """The codes that have an environment of their own."""
    return sorted(path.parent.name for asked in LOCKS for path in CODES.glob(f"*/{asked}"))


def lock_of(name: str) -> Path:
    """The lock of a code: every package that is installed, with its version and digest."""
    folder = CODES / name
    return next(folder / lock for asked, lock in LOCKS.items() if (folder / asked).is_file())


def is_installed(name: str) -> bool:
    """True if the environment of a code was made of the requirements that are there now."""
    stamp = ENVIRONMENTS / name / "made"
    return stamp.is_file() and stamp.read_text() == lock_of(name).read_text()


def install(name: str) -> bool:
    """Makes the environment of a code, of files that its lock has the digests of; False if it
    fails.
    """
    home = ENVIRONMENTS / name
    lock = lock_of(name)
    installed = {
        "requirements.txt": installed_by_pip,
        "package-lock.json": installed_by_npm,
        "debian.txt": installed_from_debian,
    }
    if not installed[lock.name](home, lock):
        return False
    (home / "made").write_text(lock.read_text())
    return True


def installed_by_pip(home: Path, lock: Path) -> bool:
    """Whether a virtual environment with the packages of a lock could be made."""
    pip = [str(home / "bin" / "pip"), "install", "--require-hashes", "--only-binary", ":all:"]
    commands = [
        [sys.executable, "-m", "venv", "--clear", str(home)],
        [*pip, "--disable-pip-version-check", "--quiet", "--requirement", str(lock)],
    ]
    return all(subprocess.run(command, check=False).returncode == 0 for command in commands)


def installed_by_npm(home: Path, lock: Path) -> bool:
    """Whether the packages of a lock could be put beside a `bin/node` that finds them.

    `npm ci` takes no file whose digest differs from that of the lock; no script of a package runs.
    """
    node = shutil.which("node")
    npm = shutil.which("npm")
    if node is None or npm is None:
        print(f"{home.name}: node and npm are not on PATH; install Node.js", file=sys.stderr)
        return False
    shutil.rmtree(home, ignore_errors=True)
    (home / "bin").mkdir(parents=True)
    shutil.copy(lock, home)
    shutil.copy(lock.with_name("package.json"), home)
    command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
    if subprocess.run(command, check=False, cwd=home).returncode != 0:
        return False
    started = home / "bin" / "node"
    modules = shlex.quote(str(home / "node_modules"))
    started.write_text(f'#!/bin/sh\nNODE_PATH={modules} exec {shlex.quote(node)} "$@"\n')
    started.chmod(0o755)
    return True


def installed_from_debian(home: Path, lock: Path) -> bool:
    """Whether the packages of a lock could be unpacked into `root`; nothing of the system changes.

    `apt-get download` takes them from where the machine has its packages from.
    """
    asked = [line.split(" --hash=sha256:") for line in lock.read_text().splitlines()[1:]]
    missing = [tool for tool in ("apt-get", "dpkg-deb", "make", "g++") if not shutil.which(tool)]
    if missing:
        print(f"{home.name}: {', '.join(missing)} not on PATH; it needs Debian", file=sys.stderr)
        return False
    shutil.rmtree(home, ignore_errors=True)
    (home / "root").mkdir(parents=True)
    download = ["apt-get", "download", "-qq", *(package for package, _ in asked)]
    if subprocess.run(download, check=False, cwd=home).returncode != 0:
        return False
    archives = sorted(home.glob("*.deb"))
    digests = {hashlib.sha256(archive.read_bytes()).hexdigest() for archive in archives}
    if digests != {digest for _, digest in asked}:
        print(f"{home.name}: a package has another digest than {lock.name} says", file=sys.stderr)
        return False
    commands = [["dpkg-deb", "--extract", str(archive), str(home / "root")] for archive in archives]
    return all(subprocess.run(command, check=False).returncode == 0 for command in commands)


def is_built(name: str) -> bool:
    """Whether what a code has to build, by its Makefile, is there and new."""
    if not (CODES / name / "Makefile").is_file():
        return True
    command = ["make", "--silent", f"HOME={ENVIRONMENTS / name}"]
    return subprocess.run(command, check=False, cwd=CODES / name).returncode == 0


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
    for script in sorted((folder / "deviations").glob("*.*")):
        path = os.path.relpath(script, OUT)
        lines.append(f"- [{script.name}]({path}): {title_of(script)}")
    return lines


def title_of(script: Path) -> str:
    """The first line of what a script, in Python, JavaScript or C++, says of itself."""
    said = re.match(r'("""|// )(.+)', script.read_text())
    if said is None:
        raise ValueError(f"{script} has no title: expected a docstring or a comment at its start")
    return said[2].removesuffix('"""')


class Ended(msgspec.Struct, frozen=True):
    """How the last run of a code ended: the state of its gate, its version, and the day (UTC)."""

    state: str
    version: str
    date: str


def keep(name: str, state: str) -> None:
    """Writes how the run of a code ended beside its report."""
    version = next((record.version for record in records_of(name)), "")
    ended = Ended(state=state, version=version, date=f"{datetime.now(UTC):%Y-%m-%d}")
    home = OUT / name
    home.mkdir(parents=True, exist_ok=True)
    (home / ENDED).write_bytes(msgspec.json.encode(ended))


def kept() -> dict[str, Ended]:
    """How the last run of each code ended, of all that were ever run and are still known."""
    paths = {name: OUT / name / ENDED for name in known()}
    return {
        name: msgspec.json.decode(path.read_bytes(), type=Ended)
        for name, path in paths.items()
        if path.is_file()
    }


def page(found: dict[str, list[Record]], ended: dict[str, Ended]) -> str:
    """The page: states, the matrix of cases and codes, deviations."""
    codes = list(ended)
    cases = list(dict.fromkeys(record.label for records in found.values() for record in records))
    lines = [
        "# Widely used codes under the gate",
        "",
        f"Digits are those of the best run; times are the least to an error of {ACCURACY:g}, in",
        "units of each quantity's scale, in the loop of the code's driver.",
        "",
        row(["code", "version", "gate", "run on"]),
        row(["---"] * 4),
        *(row([name, last.version, last.state, last.date]) for name, last in ended.items()),
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
    """The records of the last gate of a code; none if it made no report."""
    if not (OUT / name / RECORDS).is_file():
        return []
    return [sheet for sheet in sheets_in(OUT / name) if isinstance(sheet, Record)]


def state(name: str, *, may_install: bool) -> str:
    """Installs a code if it is not there, runs its gate, and says how that ended.

    The report of an earlier run goes first: it is not what this run finds.
    """
    shutil.rmtree(OUT / name, ignore_errors=True)
    if not is_installed(name) and not (may_install and install(name)):
        return NOT_INSTALLED
    if not is_built(name):
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
    for name in arguments.names or known():
        statuses[name] = state(name, may_install=not arguments.no_install)
        keep(name, statuses[name])
        print(f"{name}: {statuses[name]}", flush=True)
    ended = kept()
    found = {name: records_of(name) for name in ended}
    (OUT / "index.md").write_text(page(found, ended))
    print(f"page: {OUT / 'index.md'}")
    if any(status.startswith("closed") for status in statuses.values()):
        return 1
    if NOT_INSTALLED in statuses.values():
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
