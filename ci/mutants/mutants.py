"""Plants small errors in refdem, one at a time, and counts those that no test sees.

Each mutant is planted in a copy of the tree, and the one kernel that it is in is built there. Of
all tests, those that run its line (executed_lines.py knows them) are shown to it, the fastest
first, until one fails. It has killed the mutant if it fails once more, and passes without the
mutant. Mutants that change nothing are listed, each with its reason, in equivalent_mutants.toml.

What was found is kept in reports/mutants.jsonl: the same command goes on where it was killed, and
reports/mutants.md is the table of all that is kept. A verdict holds while the function around its
mutant stays as it was. The seed is that of the day unless it is given: the same seed draws the same
mutants of the same tree.

usage: ci/mutants/mutants.py [OPTIONS]

  (no option)                          600 mutants of all parts, and the report
  --part kernels --count 40 --seed 7   40 mutants of one part
  --look --part gas.c:120              all mutants of a file or a line, kept out of the report
  --survivors                          what no test saw, shown to the tests again
"""

import argparse
import contextlib
import datetime
import json
import platform
import random
import signal
import sys
import threading
import time
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from queue import Queue

import executed_lines
from executed_lines import UNKNOWN, Executed
from mutant_sites import ROOM, Site, sites
from tree_copy import NOT_FOUND, ROOT, TreeCopy

EQUIVALENT = ROOT / "ci" / "mutants" / "equivalent_mutants.toml"
KEPT = ROOT / "reports" / "mutants.jsonl"
REPORT = ROOT / "reports" / "mutants.md"
MOST = 300.0
"""[s] that the tests of one mutant take when nothing is planted; what would take longer is not
shown to it.
"""
FIRST = 8.0
"""[s] of the tests that a mutant is shown at once before the others are collected."""
SLOWER = 10.0
"""How much longer than alone a test may take on a busy machine."""
START = 60.0
"""[s] to start a process of tests and to collect them, on a busy machine."""
SANITIZED = ("tests/kernels", "tests/solvers", "tests/engines")
"""What ci/testing/sanitized runs."""
UNUSED_ROOM = "An array with room for one number more than is ever written or read."
STARTED = {"refdem/engines/external/supervisor.py": "refdem/engines/external/process.py"}
"""Files whose functions run in a process of their own, where no lines are followed, each with the
file that starts it: a test that runs that one may run any line of theirs.
"""
MOST_COPIES = 64
"""Copies of the tree that may be in use at once: more than any machine runs jobs here. Where none
is free, copies of runs that were killed have piled up.
"""
WHOLE = 60.0
"""[s] of a file of tests that is shown whole, because its tests may share what the first of them
made.
"""


def quick_flags() -> tuple[str, ...]:
    """Options that build a kernel in a moment: one version of it, for this processor, to the same
    bits as all of them.
    """
    info = Path("/proc/cpuinfo")
    if info.exists():
        words = set(info.read_text().split())
    else:
        words = set()
    if {"avx2", "fma"} <= words:
        level = "x86-64-v3"
    else:
        level = "x86-64"
    if platform.machine() != "x86_64":
        return ("-O1",)
    return ("-O1", f"-DREFDEM_ONE_CPU={level}")


def sanitized(copy: TreeCopy) -> TreeCopy:
    """The same copy, its kernels built as ci/testing/sanitized builds them."""
    return replace(
        copy,
        flags=("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
        scratch="sanitized",
    )


@dataclass(frozen=True)
class Group:
    """A part of refdem: its files, and the share of their mutants that the tests should kill."""

    name: str
    files: str
    goal: float


GROUPS = (
    Group("kernels", "refdem/kernels/*.[ch]", 0.95),
    Group("solvers", "refdem/solvers/*.py", 0.85),
    Group("adapters", "refdem/engines/*/*.py", 0.95),
    Group("checks", "refdem/checks/*.py", 0.90),
    Group("judgement", "refdem/core/[jrsf]*.py", 0.90),
)


Key = tuple[str, str, int, str]
"""Path, scope, number and replacement: the name of a mutant while the code around it stays."""


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant: killed, equivalent, not executed, survived, or not compiled;

    `note` has the test or the line.
    """

    seed: int
    group: str
    path: str
    line: int
    kind: str
    scope: str
    number: int
    instead: str
    shown: str
    outcome: str
    note: str

    @property
    def key(self) -> Key:
        """The mutant, as long as the function around it is what it was."""
        return self.path, self.scope, self.number, self.instead

    @property
    def row(self) -> str:
        """Its line in the report."""
        change = self.shown.replace("|", "\\|")
        note = self.note.replace("|", "\\|")
        return f"| {self.path}:{self.line} | {self.kind} | `{change}` | {note} |"


@dataclass
class Judge:
    """Plants mutants and shows them to tests;

    `green` are tests seen to pass with nothing planted, `spoiled` those that do not; `fickle` have
    failed with a mutant and then passed with it.
    """

    tests: list[Executed]
    reasons: dict[tuple[str, str, str], str]
    seed: int
    green: set[tuple[str, tuple[str, ...]]] = field(default_factory=set)
    spoiled: set[str] = field(default_factory=set)
    fickle: set[str] = field(default_factory=set)

    def verdict(self, copy: TreeCopy, site: Site, group: str) -> Verdict:
        """Plants one mutant in a copy, and puts the file and its kernels back."""
        text = text_of(site.path)
        line = site.line(text)
        shown = site.shown(text)
        whole = text.split(b"\n")[line - 1].decode().strip()
        reason = self.reasons.get((site.path, whole, shown))
        if site.kind == ROOM:
            reason = UNUSED_ROOM
        outcome = "equivalent"
        note = reason or ""
        if reason is None:
            outcome, note = self._tried(copy, site, text)
            if outcome != "killed":
                note = f"`{whole}`"
        return Verdict(
            seed=self.seed,
            group=group,
            path=site.path,
            line=line,
            kind=site.kind,
            scope=site.scope,
            number=site.number,
            instead=site.instead.decode(),
            shown=shown,
            outcome=outcome,
            note=note,
        )

    def _tried(self, copy: TreeCopy, site: Site, text: bytes) -> tuple[str, str]:
        """The outcome of a mutant that is not known to be equivalent, and the test that killed
        it.
        """
        lots = self.lots(site, text)
        with planted(copy, site.path, site.planted(text)) as is_sound:
            if not is_sound:
                self._check_builds(copy, site, text)
                return "not compiled", ""
            if not lots:
                return "not executed", ""
            for lot in lots:
                killer = self._killer(copy, site, text, lot)
                if killer:
                    return "killed", killer
        if site.path.endswith(".py"):
            return "survived", ""
        return self._tried_sanitized(sanitized(copy), site, text, lots)

    def _tried_sanitized(
        self, copy: TreeCopy, site: Site, text: bytes, lots: list[list[Executed]]
    ) -> tuple[str, str]:
        """The outcome with the sanitizers, under which CI runs the tests of kernels, solvers and
        engines too.
        """
        covered = [test for lot in lots for test in lot if test.file.startswith(SANITIZED)]
        shown, _ = _split(covered)
        if not shown:
            return "survived", ""
        with planted(copy, site.path, site.planted(text)) as is_sound:
            if is_sound:
                killer = self._killer(copy, site, text, shown)
            else:
                killer = ""
        if killer:
            return ("killed", f"{killer} (sanitizers)")
        return ("survived", "")

    def _check_builds(self, copy: TreeCopy, site: Site, text: bytes) -> None:
        """Raises RuntimeError if the file does not compile without the mutant either."""
        with planted(copy, site.path, text) as is_sound:
            if not is_sound:
                raise RuntimeError(
                    f"{site.path} does not compile in {copy.place} with nothing planted"
                )

    def _killer(self, copy: TreeCopy, site: Site, text: bytes, lot: list[Executed]) -> str:
        """The first test of a lot that fails with the mutant, fails again, and passes without it;
        empty if there is none.
        """
        seconds = {test.test: test.seconds for test in lot}
        while names := [name for name in seconds if name not in self.spoiled]:
            ended = copy.tested(names, START + SLOWER * sum(seconds.values()), seconds=seconds)
            if not ended.is_red:
                return ""
            if ended.status == NOT_FOUND:
                # Tests of all that an engine can do are fewer if the mutant takes some of it away.
                # Those that are gone cannot fail; the others are asked again.
                there = copy.collected(sorted({test.file for test in lot}), START)
                left = {name: time for name, time in seconds.items() if name in there}
                if there and len(left) < len(seconds):
                    seconds = left
                    continue
            if not ended.failed:
                raise RuntimeError(
                    f"tests of {site.path} ended with status {ended.status} and name no test that"
                    f" failed:\n{ended.said}"
                )
            name = ended.failed[0]
            if ended.status is None:
                return f"{name} (time)"
            own = {name: seconds.get(name, FIRST)}
            is_red_again = copy.tested([name], START + SLOWER * own[name], seconds=own).is_red
            if is_red_again and self._is_green(copy, site, text, own):
                return name
            # A test that fails only sometimes may do so because of the mutant, which reads
            # uninitialised memory. It is then not counted for this mutant. If it recurs with the
            # next mutant, the test itself may be flaky.
            if is_red_again or name in self.fickle:
                self.spoiled.add(name)
            self.fickle.add(name)
            seconds.pop(name, None)
            print(
                f"{name} fails without any error planted, or only sometimes: it kills"
                f" nothing\n{ended.said}",
                flush=True,
            )
        return ""

    def _is_green(self, copy: TreeCopy, site: Site, text: bytes, own: dict[str, float]) -> bool:
        """True if a test, here with its seconds, passes with nothing planted; where it does not,
        the mutant is planted again afterwards, for the other tests.
        """
        ((name, seconds),) = own.items()
        if (name, copy.flags) in self.green:
            return True
        if copy.is_sanitized:
            _plant(copy, site.path, text)
        else:
            # The kernels that meson built have the bits of a quick build, and need none.
            _restore(copy, site.path)
        is_green = not copy.tested([name], START + SLOWER * seconds, seconds=own).is_red
        if is_green:
            self.green.add((name, copy.flags))
        else:
            _plant(copy, site.path, site.planted(text))
        return is_green

    def lots(self, site: Site, text: bytes) -> list[list[Executed]]:
        """Tests that run the line of a site, in lots that are shown one after the other, the
        fastest first.

        What a test runs may have been kept from an earlier one of its file: small files are shown
        whole at the end.
        """
        first = text[: site.statement].count(b"\n") + 1
        starter = STARTED.get(site.path, "")
        if site.is_inside:
            telling = self._running(site.path, {*range(first, site.line(text) + 1)}, starter)
        else:
            telling = [test for test in self.tests if test.lines.get(site.path)]
        if not telling and site.until:
            # A declaration makes no code of its own: what follows it in its function does.
            last = text[: site.until].count(b"\n") + 1
            telling = self._running(site.path, {*range(first, last + 1)}, starter)
        ordered = sorted(telling, key=lambda test: test.seconds)
        files = {test.file for test in telling}
        others = [
            test
            for test in self.tests
            if test.file in files and test not in telling and self._seconds(test.file) < WHOLE
        ]
        return [lot for lot in (*_split(ordered), others) if lot]

    def _running(self, path: str, lines: set[int], starter: str) -> list[Executed]:
        """The tests that run any of these lines of a file, or the file that starts it."""
        span = lines | {UNKNOWN}
        return [
            test
            for test in self.tests
            if not span.isdisjoint(test.lines.get(path, ())) or test.lines.get(starter)
        ]

    def _seconds(self, file: str) -> float:
        """How long a file of tests takes."""
        return sum(test.seconds for test in self.tests if test.file == file)


def _split(ordered: Sequence[Executed]) -> tuple[list[Executed], list[Executed]]:
    """The tests that take FIRST seconds together, at least one, and the others up to MOST."""
    begin: list[Executed] = []
    rest: list[Executed] = []
    spent = 0.0
    for test in ordered:
        spent += test.seconds
        if spent <= FIRST or not begin:
            begin.append(test)
        elif spent <= MOST:
            rest.append(test)
    return begin, rest


@cache
def text_of(path: str) -> bytes:
    """The content of a file of the tree at the first call; later changes belong to the next run."""
    return (ROOT / path).read_bytes()


@contextlib.contextmanager
def planted(copy: TreeCopy, path: str, text: bytes) -> Iterator[bool]:
    """A file of the copy as `text`, its kernels built; True if it compiles.

    Afterwards it is what the tree says.
    """
    try:
        yield _plant(copy, path, text)
    finally:
        _restore(copy, path)


def _plant(copy: TreeCopy, path: str, text: bytes) -> bool:
    """Writes a file of the copy and builds its kernels; True if it compiles."""
    copy.written(path, text)
    return _is_sound(copy, path, text, _families(copy, path))


def _restore(copy: TreeCopy, path: str) -> None:
    """Puts back a file of the copy, and its kernels."""
    copy.written(path, text_of(path))
    for family in _families(copy, path):
        copy.pristine_kernel(family)


def _families(copy: TreeCopy, path: str) -> list[str]:
    """The kernels that a file is part of; none for a module."""
    if path.endswith(".py"):
        return []
    return copy.families_of(path)


def _is_sound(copy: TreeCopy, path: str, text: bytes, families: list[str]) -> bool:
    """True if a file compiles: the kernels that hold it, or the module itself."""
    if families:
        return all(copy.built_kernel(family) for family in families)
    try:
        compile(text, path, "exec")
    except (SyntaxError, ValueError):
        return False
    return True


def known_equivalent() -> dict[tuple[str, str, str], str]:
    """Reasons by file, line of text and change."""
    if not EQUIVALENT.exists():
        return {}
    listed = tomllib.loads(EQUIVALENT.read_text()).get("mutant", [])
    return {(one["file"], one["line"], one["change"]): one["reason"] for one in listed}


def drawn(only: Sequence[str], seed: int) -> list[tuple[Site, Group]]:
    """All sites in a random order, every group in its turn;

    `only` has groups, files or file:line.
    """
    pools: list[list[tuple[Site, Group]]] = []
    for group in GROUPS:
        files = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(group.files))
        wanted = [file for file in files if is_wanted(only, group, file)]
        pool = [
            (site, group) for file in wanted for site in sites(ROOT, file) if on_line(only, site)
        ]
        random.Random(f"{seed} {group.name}").shuffle(pool)
        pools.append(pool)
    longest = max(map(len, pools))
    return [pool[number] for number in range(longest) for pool in pools if number < len(pool)]


def is_wanted(only: Sequence[str], group: Group, file: str) -> bool:
    """True if nothing was selected, or if the group or the file was."""
    return not only or any(
        group.name == word or file.endswith(word.partition(":")[0]) for word in only
    )


def on_line(only: Sequence[str], site: Site) -> bool:
    """True unless other lines of its file were selected."""
    lines = [
        int(word.partition(":")[2])
        for word in only
        if ":" in word and site.path.endswith(word.partition(":")[0])
    ]
    return not lines or site.line(text_of(site.path)) in lines


def read_kept() -> dict[Key, Verdict]:
    """The last verdict on every mutant that is kept."""
    if not KEPT.exists():
        return {}
    verdicts = [Verdict(**json.loads(line)) for line in KEPT.read_text().splitlines()]
    return {verdict.key: verdict for verdict in verdicts}


def of_now(kept: dict[Key, Verdict]) -> list[Verdict]:
    """The verdicts on mutants of functions that are what they were, each with its line of today."""
    paths = sorted({verdict.path for verdict in kept.values() if (ROOT / verdict.path).exists()})
    standing = {key_of(site): site for path in paths for site in sites(ROOT, path)}
    return [
        replace(verdict, line=standing[key].line(text_of(verdict.path)))
        for key, verdict in kept.items()
        if key in standing
    ]


def key_of(site: Site) -> Key:
    """The name of a mutant of the tree as it is now."""
    return site.path, site.scope, site.number, site.instead.decode()


def run(wanted: Sequence[tuple[Site, Group]], count: int, given: argparse.Namespace) -> None:
    """Keeps verdicts on mutants until `count` of them compiled or the time [s since 1970] is over,
    some copies at a time.
    """
    judge = Judge(executed_lines.executed(), known_equivalent(), given.seed)
    until = time.time() + 60 * given.minutes
    keeps = not given.look
    all_copies = [copy_of_its_own().refreshed() for _ in range(given.jobs)]
    copies: Queue[TreeCopy] = Queue()
    for copy in all_copies:
        copies.put(copy)
    done = 0
    is_over = threading.Event()

    def one(pair: tuple[Site, Group]) -> None:
        nonlocal done
        if done >= count or time.time() > until or is_over.is_set():
            return
        site, group = pair
        copy = copies.get()
        try:
            verdict = judge.verdict(copy, site, group.name)
        finally:
            copies.put(copy)
        if is_over.is_set():
            return
        done += verdict.outcome != "not compiled"
        if keeps:
            with KEPT.open("a") as kept:
                kept.write(json.dumps(asdict(verdict)) + "\n")
        print(
            f"{verdict.outcome:13}{verdict.path}:{verdict.line}  {verdict.shown}  {verdict.note}",
            flush=True,
        )

    with ThreadPoolExecutor(given.jobs) as threads:
        try:
            list(threads.map(one, wanted))
        finally:
            # Of a run that was interrupted nothing goes on, and no verdict is kept of what it was
            # at.
            is_over.set()
            for copy in all_copies:
                copy.stop()


def copy_of_its_own() -> TreeCopy:
    """The first copy in build/ that no other run has."""
    for number in range(MOST_COPIES):
        copy = TreeCopy(ROOT / "build" / f"planted-{number}", quick_flags())
        if copy.locked():
            return copy
    raise RuntimeError(f"{MOST_COPIES} copies in {ROOT / 'build'} are in use")


def report(found: Sequence[Verdict]) -> str:
    """The page: a row a group, and what no test saw."""
    planted_ones = [verdict for verdict in found if verdict.outcome != "not compiled"]
    seeds = ", ".join(str(seed) for seed in sorted({verdict.seed for verdict in planted_ones}))
    total = len(planted_ones)
    head = (
        "part",
        "planted",
        "killed",
        "equivalent",
        "not executed",
        "survived",
        "killed of what is not equivalent",
        "goal",
    )
    lines = [
        "# Mutants",
        "",
        (
            f"Made by `make mutants`: {total} small errors, planted one at a time in a copy of the"
            f" tree; seeds: {seeds}."
        ),
        "",
        (
            "An error is another operator, comparison, sign or constant, or a statement that is"
            " gone, drawn at random from all places of"
        ),
        (
            "a part. It is shown to the tests that run its line, and to the rows of campaign"
            " `main`, the fastest first. It counts as"
        ),
        (
            "killed if a test fails, fails again, and passes without it. *Not executed*: no test"
            " runs its line."
        ),
        (
            "*Equivalent*: it changes nothing that anyone can see, for the reason given in"
            " `ci/mutants/equivalent_mutants.toml`."
        ),
        (
            "Errors that survived are shown to the tests again after the tests were mended"
            " (`ci/mutants/mutants.py --survivors`)."
        ),
        "Errors of a function that changed since are left out.",
        "",
        f"| {' | '.join(head)} |",
        f"|{' --- |' * len(head)}",
    ]
    for group in GROUPS:
        outcomes = [verdict.outcome for verdict in planted_ones if verdict.group == group.name]
        counts = [
            outcomes.count(name) for name in ("killed", "equivalent", "not executed", "survived")
        ]
        able = len(outcomes) - counts[1]
        if able:
            share = f"{counts[0] / able:.0%}"
        else:
            share = "none"
        lines.append(
            f"| {group.name} | {len(outcomes)} | {' | '.join(map(str, counts))} | {share} |"
            f" {group.goal:.0%} |"
        )
    for outcome, title in (
        ("survived", "Survived"),
        ("not executed", "Not executed"),
        ("equivalent", "Equivalent"),
    ):
        rows = sorted(verdict.row for verdict in planted_ones if verdict.outcome == outcome)
        if rows:
            lines += [
                "",
                f"## {title}",
                "",
                "| place | kind | change | line, or reason |",
                "| --- | --- | --- | --- |",
                *rows,
            ]
    return "\n".join(lines) + "\n"


def options() -> argparse.Namespace:
    """The options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--count",
        type=int,
        default=600,
        help="mutants that compile, those that are kept already counted",
    )
    parser.add_argument("--part", nargs="*", default=[], help="groups, files, or file:line")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=datetime.date.today().toordinal())
    parser.add_argument(
        "--minutes", type=float, default=float("inf"), help="no mutant is begun after so many"
    )
    parser.add_argument(
        "--known",
        action="store_true",
        help="show mutants only to tests whose lines are known already",
    )
    parser.add_argument(
        "--survivors",
        action="store_true",
        help="judge again what is kept as survived or not executed",
    )
    parser.add_argument(
        "--look",
        action="store_true",
        help="keep no verdict: what was not drawn at random is no sample",
    )
    parser.add_argument(
        "--report",
        action="store_true",
        help="write reports/mutants.md of all that is kept, and plant nothing",
    )
    return parser.parse_args()


def asked(given: argparse.Namespace) -> tuple[list[tuple[Site, Group]], int]:
    """The mutants to plant, in order, and how many of them."""
    kept = read_kept()
    order = drawn(given.part, given.seed)
    if given.survivors:
        seen = [(site, group) for site, group in order if key_of(site) in kept]
        missed = [
            pair for pair in seen if kept[key_of(pair[0])].outcome in ("survived", "not executed")
        ]
        return missed, len(missed)
    begun = [
        verdict
        for verdict in kept.values()
        if verdict.seed == given.seed and verdict.outcome != "not compiled"
    ]
    chosen = {site.path for site, _ in order}
    had = sum(verdict.path in chosen for verdict in begun)
    return [pair for pair in order if key_of(pair[0]) not in kept], max(0, given.count - had)


def main() -> int:
    """Exit status 0: the table says how it went; the goals are for people."""
    given = options()
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    if not given.report:
        print(f"seed {given.seed}", flush=True)
        if not given.known:
            executed_lines.measure_all(executed_lines.files_of_tests())
        KEPT.parent.mkdir(exist_ok=True)
        wanted, count = asked(given)
        run(wanted, count, given)
    verdicts = of_now(read_kept())
    text = report(verdicts)
    if given.report or not given.part:
        REPORT.write_text(text)
        KEPT.write_text("".join(json.dumps(asdict(verdict)) + "\n" for verdict in verdicts))
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
