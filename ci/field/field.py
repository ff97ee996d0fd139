"""Installs widely used codes, runs the gate of each, and writes what it found into
reports/field/NAME.jsonl, and from that the page reports/field/index.md and the badges.
Codes that are not run now keep the results of their last run, with version and date.

usage: ci/field/field.py [--no-install] [--page] [NAME...]; without names all folders of
validation/codes that have requirements of their own, of Python (requirements.in), of Node.js
(package.json) or of Debian (debian.txt, with a Makefile), and the others that are there. A code
whose packages cannot be installed is reported, and the others run. With --page nothing runs.
"""

import argparse
import hashlib
import shlex
import shutil
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import field_page
import field_results

from refdem.core.finding import Record
from refdem.engines.external import External
from refdem.report.jsonl import RECORDS, sheets_in

ROOT = Path(__file__).resolve().parents[2]
CODES = ROOT / "validation" / "codes"
ENVIRONMENTS = ROOT / ".venv-field"
OUT = ROOT / "reports" / "field"
REFDEM = "from refdem.cli import main; main()"
"""The command line, of the refdem that this Python imports."""
NOT_INSTALLED = "not installed"
LOCKS = {
    "requirements.in": "requirements.txt",
    "package.json": "package-lock.json",
    "debian.txt": "debian.txt",
}
"""What a code asks for, of Python, Node.js or Debian, and the lock that pins it with digests."""


def known() -> list[str]:
    """The codes that have a description."""
    return sorted(path.parent.name for path in CODES.glob("*/refdem.toml"))


def lock_of(name: str) -> Path | None:
    """The lock of a code: every package that is installed, with its version and digest; None for a
    code without an environment of its own.
    """
    folder = CODES / name
    locks = [folder / lock for asked, lock in LOCKS.items() if (folder / asked).is_file()]
    return next(iter(locks), None)


def is_installed(name: str) -> bool:
    """True if the environment of a code was made of the requirements that are there now, or if a
    code that has none is there.
    """
    lock = lock_of(name)
    if lock is None:
        return External(CODES / name / "refdem.toml").missing() is None
    stamp = ENVIRONMENTS / name / "made"
    return stamp.is_file() and stamp.read_text() == lock.read_text()


def install(name: str) -> bool:
    """Makes the environment of a code, of files that its lock has the digests of; False if it
    fails.
    """
    home = ENVIRONMENTS / name
    lock = lock_of(name)
    if lock is None:
        print(f"{name}: {External(CODES / name / 'refdem.toml').missing()}", file=sys.stderr)
        return False
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


def keep(name: str, state: str) -> None:
    """Writes what the last run of a code found, and its badge."""
    records = records_of(name)
    engine = External(CODES / name / "refdem.toml")
    run = field_results.Run(
        code=name,
        version=next((record.version for record in records), ""),
        state=state,
        date=f"{datetime.now(UTC):%Y-%m-%d}",
        methods={method.name: method.summary for method in engine.methods},
    )
    kept = field_results.Kept(run, field_results.results(records))
    field_results.write(OUT / f"{name}.jsonl", kept)


def write_page() -> None:
    """Writes the page and the badges from the results of all codes that ever ran."""
    for code in field_page.codes_in(CODES, OUT):
        if code.kept is not None:
            (OUT / f"{code.name}.svg").write_text(field_page.badge(code.kept))
    (OUT / "index.md").write_text(field_page.page(CODES, OUT))
    print(f"page: {OUT / 'index.md'}")


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


def there() -> list[str]:
    """The codes that can be installed, and those without an environment that are there."""
    return [name for name in known() if lock_of(name) is not None or is_installed(name)]


def run(names: list[str], *, may_install: bool) -> dict[str, str]:
    """How the gate of each code ended; one that is not installed keeps what its last run found."""
    statuses = {}
    for name in names:
        statuses[name] = state(name, may_install=may_install)
        if statuses[name] != NOT_INSTALLED:
            keep(name, statuses[name])
        print(f"{name}: {statuses[name]}", flush=True)
    return statuses


def main() -> int:
    """Exit status: 1 if a gate is closed, 2 if a code that was named is not there, else 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--no-install", action="store_true")
    parser.add_argument("--page", action="store_true", help="make the page from what is kept")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(known()))
    if unknown:
        parser.error(f"no code {', '.join(unknown)}; known are {', '.join(known())}")
    OUT.mkdir(parents=True, exist_ok=True)
    statuses = {}
    if not arguments.page:
        statuses = run(arguments.names or there(), may_install=not arguments.no_install)
    write_page()
    if any(status.startswith("closed") for status in statuses.values()):
        return 1
    if NOT_INSTALLED in statuses.values():
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
