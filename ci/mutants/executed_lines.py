"""Which lines of refdem each test runs, and how long it takes.

usage: ci/mutants/executed_lines.py [FILE...]

Every file of tests runs once in a copy of the tree whose kernels count their lines (gcov) and whose
Python is followed (coverage.py). What a file runs is kept in build/executed/ until the file
changes.
"""

import argparse
import gzip
import hashlib
import json
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from tree_copy import KERNELS, ROOT, TreeCopy

PLACE = ROOT / "build/executed"
LONGEST = 1500.0
"""[s] of one file of tests."""
PARTS = (
    "kernels",
    "solvers",
    "engines",
    "checks",
    "core",
    "execution",
    "planning",
    "smoke",
    "certification",
    "faults",
    "mechanics",
    "cases",
    "gate",
    "stress",
    "cli",
    "properties",
    "attacks",
    "by_hand",
)
ROWS = "ci/mutants/campaign_rows.py"
UNKNOWN = -1
"""Stands for all lines of a source."""
KEPT_LINES = ROOT / "ci/mutants/kept_lines.h"
FLAGS = ("-O0", "--coverage", "-DREFDEM_ONE_CPU=x86-64", "-include", str(KEPT_LINES))
"""Counted lines have one version for all processors: each of its clones would be a function of its
own.
"""


class KeptTest(TypedDict):
    """What is kept of one test that passed."""

    name: str
    seconds: float
    lines: dict[str, list[int]]


class Kept(TypedDict):
    """What is kept of a file of tests: its digest, that of every source it runs, and its tests."""

    digest: str
    sources: dict[str, str]
    tests: list[KeptTest]


@dataclass(frozen=True)
class Executed:
    """What one test runs: line numbers by file, and how long it takes [s]."""

    test: str
    seconds: float
    lines: dict[str, set[int]]

    @property
    def file(self) -> str:
        """The file that it is in."""
        return self.test.partition("::")[0]


def files_of_tests() -> list[str]:
    """Every file of tests that is asked what it runs, the campaign's rows first."""
    found = [path for part in PARTS for path in sorted((ROOT / "tests" / part).rglob("test_*.py"))]
    return [ROWS, *(str(path.relative_to(ROOT)) for path in found)]


def kept(file: str) -> Path:
    """Where it is kept what a file of tests runs."""
    return PLACE / f"{file.replace('/', '.')}.json.gz"


def digest(file: str, tree: Path = ROOT) -> str:
    """sha256 of a file of a tree, as it is now; empty if it is gone."""
    path = tree / file
    if path.exists():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    return ""


def is_fresh(file: str) -> bool:
    """True if a file of tests is the one that was asked."""
    path = kept(file)
    return path.exists() and read_kept(path)["digest"] == digest(file)


def read_kept(path: Path) -> Kept:
    """What is kept of one file of tests."""
    with gzip.open(path, "rt") as text:
        entry: Kept = json.load(text)
    return entry


def executed() -> list[Executed]:
    """All tests that are known, without those whose file changed or is gone, and those that failed.

    Of a source that changed since, any line may be one that they run: UNKNOWN.
    """
    found: list[Executed] = []
    sources: dict[str, str] = {}
    for file in files_of_tests():
        if not is_fresh(file):
            continue
        entry = read_kept(kept(file))
        for test in entry["tests"]:
            known = {}
            for name, lines in test["lines"].items():
                sources.setdefault(name, digest(name))
                is_same = sources[name] == entry["sources"][name]
                known[name] = set(lines) if is_same else {UNKNOWN}
            found.append(Executed(test["name"], test["seconds"], known))
    return found


def counting_copy() -> TreeCopy:
    """A copy of the tree whose kernels count their lines."""
    copy = TreeCopy(ROOT / "build/counting", flags=FLAGS)
    if not copy.locked():
        raise SystemExit(f"another run asks the tests in {copy.place}; wait for it, or end it")
    copy.refreshed()
    for source in sorted((ROOT / KERNELS).glob("*.c")):
        if not copy.built_kernel(source.stem):
            raise RuntimeError(f"{source.name} does not build with {' '.join(FLAGS)}")
    return copy


def measure(copy: TreeCopy, file: str) -> None:
    """Runs one file of tests and keeps what its tests run."""
    with tempfile.TemporaryDirectory(dir=copy.environment()["TMPDIR"]) as nest:
        out = Path(nest)
        also = {"REFDEM_LINES": str(out), "REFDEM_LINES_OF": str(copy.place)}
        ended = copy.tested([file], LONGEST, more=("-p", "lines_plugin"), also=also)
        kept_tests = out / "tests.json"
        if not kept_tests.exists():
            answer = f"status {ended.status} {' '.join(ended.failed)}"
            print(f"  {file}: no answer, {answer}", flush=True)
            print(ended.said, flush=True)
            return
        tests = json.loads(kept_tests.read_text())
        for number, test in enumerate(tests):
            test["lines"] |= lines_of_kernels(copy, out / str(number))
    failed = [test["name"] for test in tests if test["failed"]]
    for name in failed:
        print(f"  fails without any error planted: {name}", flush=True)
    passed = [test for test in tests if not test["failed"]]
    named = {name for test in passed for name in test["lines"]}
    sources = {name: digest(name, copy.place) for name in sorted(named)}
    entry = {"digest": digest(file, copy.place), "sources": sources, "tests": passed}
    PLACE.mkdir(parents=True, exist_ok=True)
    with gzip.open(kept(file), "wt") as text:
        json.dump(entry, text)
    seconds = sum(test["seconds"] for test in tests)
    print(f"  {file}: {len(passed)} tests, {seconds:.0f} s", flush=True)


def lines_of_kernels(copy: TreeCopy, counters: Path) -> dict[str, list[int]]:
    """Lines of C that ran, by file, from the counters of one test."""
    if not counters.is_dir():
        return {}
    lines = counted(copy, counters)
    return {
        file: sorted(line for line, count in counts.items() if count)
        for file, counts in lines.items()
    }


def counted(copy: TreeCopy, counters: Path) -> dict[str, dict[int, int]]:
    """How often lines of C ran, by file, from a folder of gcov's counters; 0 is a line that could
    have.
    """
    found: dict[str, dict[int, int]] = {}
    for data in sorted(counters.glob("*.gcda")):
        if data.stem.endswith("_glue"):
            continue
        shutil.copy(copy.place / "build/planted" / f"{data.stem}.gcno", counters)
        _added(found, data)
    return found


def countable(copy: TreeCopy) -> dict[str, set[int]]:
    """Lines of C that can run, by file."""
    found: dict[str, dict[int, int]] = {}
    with tempfile.TemporaryDirectory() as nest:
        for notes in sorted((copy.place / "build/planted").glob("[a-z]*.gcno")):
            shutil.copy(notes, nest)
            _added(found, Path(nest) / f"{notes.stem}.gcda")
    return {file: set(lines) for file, lines in found.items()}


def _added(found: dict[str, dict[int, int]], data: Path) -> None:
    """Adds what gcov says of one kernel, with its counters or without."""
    command = ["gcov", "--json-format", "--stdout", str(data)]
    done = subprocess.run(command, cwd=data.parent, capture_output=True, text=True, check=True)
    for answer in done.stdout.splitlines():
        for file in json.loads(answer)["files"]:
            name = str(KERNELS / Path(file["file"]).name)
            if not (ROOT / name).exists():
                continue
            here = found.setdefault(name, {})
            for line in file["lines"]:
                number = line["line_number"]
                here[number] = here.get(number, 0) + line["count"]


def measure_all(files: Iterable[str]) -> None:
    """Asks every file of tests that is not known, or changed."""
    wanted = [file for file in files if not is_fresh(file)]
    if not wanted:
        return
    copy = counting_copy()
    for file in wanted:
        measure(copy, file)


def main(given: Sequence[str]) -> int:
    """Exit status 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "file", nargs="*", help="files of tests; none: all that the mutants are shown"
    )
    parser.add_argument("--again", action="store_true", help="also those that are known")
    chosen = parser.parse_args(given)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    files = chosen.file or files_of_tests()
    if chosen.again:
        for file in files:
            kept(file).unlink(missing_ok=True)
    measure_all(files)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
