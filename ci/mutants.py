"""Plants small errors in refdem, one at a time, and counts those that no test sees: `make mutants`, or ci/mutants.py [OPTIONS].

Each mutant is planted in a copy of the tree, its kernel is built there, and the tests that are about its part run until one fails. What
survives is looked at again: with an abort before its statement, a mutant that is still unseen stands where no test comes. Those that
change nothing are listed, each with its reason, in ci/equivalent_mutants.toml. The seed is that of the day unless it is given, and is
printed: the same seed plants the same errors in the same tree. The table goes to reports/mutants.md.
"""

import argparse
import datetime
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

from mutant_sites import Site, sites

ROOT = Path(__file__).parents[1]
EQUIVALENT = ROOT / "ci" / "equivalent_mutants.toml"
LONGEST = 600.0
"""[s] of the tests of one mutant; a mutant that hangs is seen."""
SHARE = 3
"""Of a fixed seed's draw, at most so many times as many sites are tried as mutants are wanted: some do not compile."""


@dataclass(frozen=True)
class Group:
    """A part of refdem: its files, the share that its tests should see, and these tests, the most telling first."""

    name: str
    files: str
    goal: float
    tests: tuple[str, ...]


GROUPS = (
    Group("kernels", "refdem/kernels/*.[ch]", 0.95, ("tests/kernels", "tests/solvers", "tests/engines/test_reference.py", "tests/checks")),
    Group("solvers", "refdem/solvers/*.py", 0.85, ("tests/solvers", "tests/kernels", "tests/engines/test_reference.py")),
    Group("adapters", "refdem/engines/*/*.py", 0.95, ("tests/engines", "tests/campaign/test_smoke.py")),
    Group("checks", "refdem/checks/*.py", 0.90, ("tests/checks", "tests/faults/test_kill_matrix.py", "tests/core")),
    Group("judgement", "refdem/core/[jrsf]*.py", 0.90, ("tests/core", "tests/checks", "tests/gate", "tests/campaign/test_campaign.py")),
)


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant: killed, timed out, equivalent, not executed, survived, or not compiled."""

    site: Site
    group: str
    line: int
    shown: str
    outcome: str
    note: str = ""

    @property
    def row(self) -> str:
        """Its line in the report."""
        change = self.shown.replace("|", "\\|")
        return f"| {self.site.path}:{self.line} | {self.site.kind} | `{change}` | {self.note} |"


def copied(place: Path) -> Path:
    """A copy of what the tests need, with kernels; those that stand in place here are taken, and else they are built there."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    for name in listed:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    subprocess.run(["git", "init", "--quiet"], cwd=place, check=True)
    ready = list((ROOT / "refdem" / "kernels").glob("*.so"))
    for kernel in ready:
        shutil.copy(kernel, place / "refdem" / "kernels")
    if not ready:
        built(place)
    return place


def built(place: Path) -> bool:
    """True if the kernels of a copy are built; what has not changed is not built again."""
    done = subprocess.run([str(place / "ci/build-in-place"), sys.executable], cwd=place, capture_output=True)
    return done.returncode == 0


def tests_of(site: Site, group: Group) -> list[str]:
    """Files of tests: first those that speak of the file or of its method, then the others of the group."""
    stem = Path(site.path).stem.lstrip("_")
    words = {stem, stem.replace("_", "-")}
    listed: list[str] = []
    for place in group.tests:
        path = ROOT / place
        listed += [str(file.relative_to(ROOT)) for file in ([path] if path.suffix else sorted(path.rglob("test_*.py")))]
    near = [file for file in listed if any(word in (ROOT / file).read_text() or word in file for word in words)]
    return [*near, *(file for file in listed if file not in near)]


def is_red(place: Path, tests: Sequence[str], spoiled: Sequence[str] = ()) -> tuple[bool, str]:
    """True if a test fails, crashes or hangs in the copy, and which; `spoiled` are left out."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")]),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    environment["REFDEM_STORE"] = str(place / "store.sqlite")
    command = [
        sys.executable,
        "-P",
        "-m",
        "pytest",
        "-q",
        "-x",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:xdist",
        "--no-header",
        "--tb=no",
        *tests,
    ]
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, cwd=place, env=environment, stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            status = process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            process.wait()
            return True, "time"
        said.seek(0)
        failed = [line.split(" - ")[0].removeprefix("FAILED ") for line in said if line.startswith(("FAILED", "ERROR"))]
    return status != 0, failed[0].strip() if failed else f"status {status}"


def judged(place: Path, site: Site, group: Group, reasons: dict[tuple[str, str, str], str]) -> Verdict:
    """Plants one mutant in a copy, and puts the file back."""
    path = place / site.path
    text = path.read_bytes()
    line, shown = site.line(text), site.shown(text)
    whole = text.split(b"\n")[line - 1].decode().strip()

    def verdict(outcome: str, note: str = "") -> Verdict:
        return Verdict(site, group.name, line, shown, outcome, note)

    reason = reasons.get((site.path, whole, shown))
    if reason:
        return verdict("equivalent", reason)
    tests = tests_of(site, group)
    try:
        path.write_bytes(site.planted(text))
        if not is_sound(place, path):
            return verdict("not compiled")
        red, by = is_red(place, tests, SPOILED)
        while red and not is_green(place, path, site.planted(text), text, by):
            SPOILED.append(by)
            red, by = is_red(place, tests, SPOILED)
        if red:
            return verdict("killed", by)
        path.write_bytes(aborting(site, text))
        if is_sound(place, path) and not is_red(place, tests, SPOILED)[0]:
            return verdict("not executed", f"`{whole}`")
        return verdict("survived", f"`{whole}`")
    finally:
        path.write_bytes(text)
        is_sound(place, path)


GREEN: set[str] = set()
SPOILED: list[str] = []
"""Tests that pass without any error planted, and those that do not: what fails anyway has killed nothing."""


def is_green(place: Path, path: Path, planted: bytes, text: bytes, test: str) -> bool:
    """True if a test that failed passes without the error, or is no single test: a crash, a hang."""
    if "::" not in test or test in GREEN:
        return True
    path.write_bytes(text)
    if is_sound(place, path) and is_red(place, [test])[0]:
        path.write_bytes(planted)
        is_sound(place, path)
        return False
    GREEN.add(test)
    return True


def is_sound(place: Path, path: Path) -> bool:
    """True if a file compiles: the kernels that hold it, or the module itself."""
    if path.suffix != ".py":
        return built(place)
    try:
        compile(path.read_bytes(), path.name, "exec")
    except (SyntaxError, ValueError):
        return False
    return True


def aborting(site: Site, text: bytes) -> bytes:
    """The file with an abort before the statement of a site."""
    begin = text.rfind(b"\n", 0, site.statement) + 1
    if site.path.endswith(".py"):
        indent = text[begin : len(text) - len(text[begin:].lstrip(b" "))]
        return text[:begin] + indent + b'__import__("os")._exit(86)\n' + text[begin:]
    return text[: site.statement] + b"__builtin_trap(); " + text[site.statement :]


def known_equivalent() -> dict[tuple[str, str, str], str]:
    """Reasons by file, line of text and change."""
    if not EQUIVALENT.exists():
        return {}
    listed = tomllib.loads(EQUIVALENT.read_text()).get("mutant", [])
    return {(one["file"], one["line"], one["change"]): one["reason"] for one in listed}


def drawn(only: Sequence[str], count: int, seed: int) -> list[tuple[Site, Group]]:
    """Sites in a random order, every group in its turn; `only` has groups, files or file:line."""
    pools: list[list[tuple[Site, Group]]] = []
    dice = random.Random(seed)
    for group in GROUPS:
        files = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(group.files))
        pool = [(site, group) for file in files if is_wanted(only, group, file) for site in sites(ROOT, file) if on_line(only, site)]
        dice.shuffle(pool)
        pools.append(pool)
    turns = [pool[number] for number in range(max(map(len, pools))) for pool in pools if number < len(pool)]
    return turns[: SHARE * count]


def is_wanted(only: Sequence[str], group: Group, file: str) -> bool:
    """True if nothing, the group or the file was asked for."""
    return not only or any(group.name == word or file.endswith(word.partition(":")[0]) for word in only)


def on_line(only: Sequence[str], site: Site) -> bool:
    """True unless other lines of its file were asked for."""
    lines = [int(word.partition(":")[2]) for word in only if ":" in word and site.path.endswith(word.partition(":")[0])]
    return not lines or site.line((ROOT / site.path).read_bytes()) in lines


def run(wanted: list[tuple[Site, Group]], count: int, jobs: int) -> list[Verdict]:
    """Verdicts on `count` mutants that compile, some copies at a time."""
    reasons = known_equivalent()
    found: list[Verdict] = []
    with tempfile.TemporaryDirectory(prefix="refdem-mutants-") as nest:
        copies: Queue[Path] = Queue()
        for number in range(jobs):
            copies.put(copied(Path(nest) / str(number)))

        def one(pair: tuple[Site, Group]) -> None:
            if sum(verdict.outcome != "not compiled" for verdict in found) >= count:
                return
            place = copies.get()
            try:
                verdict = judged(place, *pair, reasons)
            finally:
                copies.put(place)
            found.append(verdict)
            print(f"{verdict.outcome:13}{verdict.site.path}:{verdict.line}  {verdict.shown}  {verdict.note}", flush=True)

        with ThreadPoolExecutor(jobs) as threads:
            list(threads.map(one, wanted))
    return found


def report(found: Sequence[Verdict], seed: int) -> str:
    """The page: a row a group, and what no test saw."""
    planted = [verdict for verdict in found if verdict.outcome != "not compiled"]
    head = ("part", "planted", "killed", "equivalent", "not executed", "survived", "killed of what is not equivalent", "goal")
    lines = ["# Mutants", "", f"Made by `make mutants`: {len(planted)} small errors, drawn with seed {seed}, one at a time.", ""]
    lines += [f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}"]
    for group in GROUPS:
        outcomes = [verdict.outcome for verdict in planted if verdict.group == group.name]
        counts = [outcomes.count(name) for name in ("killed", "equivalent", "not executed", "survived")]
        able = len(outcomes) - counts[1]
        share = f"{counts[0] / able:.0%}" if able else "none"
        lines.append(f"| {group.name} | {len(outcomes)} | {' | '.join(map(str, counts))} | {share} | {group.goal:.0%} |")
    for outcome, title in (("survived", "Survived"), ("not executed", "Not executed"), ("equivalent", "Equivalent")):
        rows = sorted(verdict.row for verdict in planted if verdict.outcome == outcome)
        if rows:
            lines += ["", f"## {title}", "", "| place | kind | change | line, or reason |", "| --- | --- | --- | --- |", *rows]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Exit status 0: the table says how it went; the goals are for people."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=600)
    parser.add_argument("--only", nargs="*", default=[], help="groups, files, or file:line")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=datetime.date.today().toordinal())
    parser.add_argument("--out", type=Path, help="where the table goes; of all parts, reports/mutants.md")
    given = parser.parse_args()
    print(f"seed {given.seed}", flush=True)
    wanted = drawn(given.only, given.count, given.seed)
    if not wanted:
        parser.error(f"nothing to plant in {given.only}; expected {', '.join(group.name for group in GROUPS)}, or a file of theirs")
    text = report(run(wanted, given.count, given.jobs), given.seed)
    out = given.out or (None if given.only else ROOT / "reports" / "mutants.md")
    if out:
        out.write_text(text)
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
