"""Whatever process of a command is ended, by whatever signal, at whatever moment: nothing is left
running, no folder stays, nothing is told by a traceback, and the same command goes on where it was.
"""

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest

from refdem.engines.external import folders

Command = Callable[..., "subprocess.CompletedProcess[str]"]
ROOT = Path(__file__).parents[2]
ASSASSIN = Path(__file__).with_name("assassin.py")
PATIENCE = 120.0
"""Seconds within which processes end, on any machine."""
MOMENTS = {
    "before it has read anything": "refdem.planning.specification:named#1",
    "while it plans": "refdem.planning.plan:tasks_of#1",
    "while it keeps a truth": "refdem.core.store:Store.put_truth#1",
    "while it keeps a run": "refdem.core.store:Store.put#4",
    "while it judges": "refdem.planning.judging:record#1",
    "while it keeps the campaign": "refdem.planning.unchanged:keep#1",
    "when it begins its report": "refdem.report.writing:written#1",
    "between two files of its report": "refdem.report.writing:written#6",
    "as it puts a file there": "pathlib:Path.replace#3",
    "before it says anything": "refdem.cli.summary:lines#1",
}
"""Places in refdem, each with the number of the call that kills."""
PROGRAM_RUNS = "program"
RUN_KEPT = MOMENTS["while it keeps a run"]
BROKEN = 3
"""Exit status where a run is an error."""
STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129, signal.SIGKILL: -9}
"""Exit status of refdem by the signal that ended it."""
TOML = """
[engine]
name = "spring"
command = {command}
supports = ["spring", "dimension:1"]
timeout = 300
{more}
[[engine.methods]]
name = "leapfrog"
order = 2
symplectic = true
reversible = true
"""
CAMPAIGN = """
engines = {engines}
checks = ["error", "determinism"]
levels = 3
[[case]]
id = "harmonic-oscillator"
set = {{samples = "8", duration = "2"}}
"""


@dataclass(frozen=True, kw_only=True)
class Kill:
    """A signal to a process of a command, at a moment."""

    who: str
    by: signal.Signals
    at: str = PROGRAM_RUNS
    engine: str = "program"

    @property
    def name(self) -> str:
        """The name of the test."""
        return f"{self.who} {self.by.name} {self.at.rpartition(':')[2]} {self.engine}"


EARLY = tuple(MOMENTS.values())[:3]
LATE = tuple(MOMENTS.values())[-3:]
ENDS = [
    *(Kill(who="itself", by=signal.SIGKILL, at=at) for at in MOMENTS.values()),
    *(Kill(who="itself", by=signal.SIGINT, at=at) for at in (*EARLY, *LATE)),
    Kill(who="itself", by=signal.SIGTERM, at=MOMENTS["while it judges"]),
    Kill(who="itself", by=signal.SIGHUP, at=MOMENTS["as it puts a file there"]),
]
"""refdem itself is ended in the midst of its work."""
TOGETHER = [
    Kill(who="group", by=signal.SIGINT, at=RUN_KEPT, engine="reference"),
    Kill(who="group", by=signal.SIGHUP, at=RUN_KEPT),
    Kill(who="everything", by=signal.SIGKILL, at=RUN_KEPT, engine="served"),
    Kill(who="refdem", by=signal.SIGKILL),
    Kill(who="refdem", by=signal.SIGTERM, engine="served"),
]
"""refdem is ended with its workers and programs, as a terminal or a batch system does, or by a
process of its own while programs run.
"""
OTHERS = [
    Kill(who="tracker", by=signal.SIGKILL, at=RUN_KEPT, engine="reference"),
    Kill(who="supervisor", by=signal.SIGKILL),
    Kill(who="supervisor", by=signal.SIGTERM, engine="served"),
    Kill(who="supervisor", by=signal.SIGKILL, at=RUN_KEPT),
    Kill(who="guard", by=signal.SIGKILL),
    Kill(who="guard", by=signal.SIGKILL, engine="served"),
    Kill(who="itself", by=signal.SIGKILL),
    Kill(who="itself", by=signal.SIGTERM, engine="served"),
]
"""A process of refdem's is ended, and refdem goes on."""


@dataclass(frozen=True, kw_only=True)
class Place:
    """The folder of a test, with a campaign in it."""

    folder: Path
    engine: str

    @property
    def words(self) -> "list[str]":
        """The command."""
        return ["run", "--campaign", f"{self.engine}.toml", "--jobs", "2", "--out", "report"]

    @property
    def environment(self) -> "dict[str, str]":
        """With a store and a folder of temporary files of its own, and with tests to import.

        The folder of the tests alone is on the path: refdem is the one that is installed.
        """
        return os.environ | {
            "PYTHONPATH": str(self.folder / "imported"),
            "TMPDIR": str(self.folder / "temporary"),
            "REFDEM_STORE": str(self.folder / "store.sqlite"),
            "KILL_AT": PROGRAM_RUNS,
            "KILL_MARK": str(self.folder / "killed"),
        }

    def prepare(self) -> None:
        """Writes the campaign."""
        (self.folder / "temporary").mkdir()
        (self.folder / "imported").mkdir()
        (self.folder / "imported" / "tests").symlink_to(ROOT / "tests")
        engines = {"reference": "reference"}
        for name, files, more in (
            ("program", ["{request}", "{trajectory}"], ""),
            ("served", [], "serve = true"),
        ):
            place = self.folder / name
            place.mkdir()
            command = json.dumps([sys.executable, str(ASSASSIN), *files])
            (place / "refdem.toml").write_text(TOML.format(command=command, more=more))
            engines[name] = f"{name}/refdem.toml"
        text = CAMPAIGN.format(engines=json.dumps([engines[self.engine]]))
        (self.folder / f"{self.engine}.toml").write_text(text)

    def run(self, **kill: str) -> "subprocess.CompletedProcess[str]":
        """The command, during which something may be killed."""
        return subprocess.run(
            [sys.executable, str(ASSASSIN), "refdem", *self.words],
            cwd=self.folder,
            env=self.environment | kill,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            start_new_session=True,
        )

    def kept(self) -> int:
        """The number of runs in the store."""
        store = self.folder / "store.sqlite"
        if not store.exists():
            return 0
        with closing(sqlite3.connect(store)) as connection:
            (count,) = connection.execute(
                "SELECT count(*) FROM entries WHERE kind = 'run'"
            ).fetchone()
        return count

    def findings(self) -> "list[tuple[str, str, str, str]]":
        """Every verdict of the report."""
        found = []
        for line in (self.folder / "report" / "records.jsonl").read_text().splitlines():
            sheet = json.loads(line)
            for one in sheet.get("findings", []):
                found.append((one["check"], one["quantity"], one["outcome"], one["sentence"]))
        return found

    def files(self) -> "list[str]":
        """All files of the report."""
        report = self.folder / "report"
        return sorted(str(path.relative_to(report)) for path in report.rglob("*"))

    def running(self) -> "list[str]":
        """The processes of the command that have not ended."""
        store = f"REFDEM_STORE={self.environment['REFDEM_STORE']}\0".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            try:
                is_one = store in path.read_bytes()
            except OSError:
                # It has ended, or is another user's.
                continue
            if is_one:
                found.append((path.parent / "cmdline").read_text())
        return found


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> "Callable[[str], Place]":
    """A campaign of an engine in which nothing was killed."""
    places: dict[str, Place] = {}

    def place(engine: str) -> Place:
        if engine not in places:
            folder = tmp_path_factory.mktemp(engine)
            places[engine] = Place(folder=folder, engine=engine)
            places[engine].prepare()
            places[engine].run(KILL_AT="nowhere")
        return places[engine]

    return place


def name(kill: Kill) -> str:
    """The name of a test."""
    return kill.name


@pytest.fixture
def after(
    tmp_path: Path,
    quiet: "Callable[[str], Place]",
    command_line: Command,
    monkeypatch: pytest.MonkeyPatch,
) -> "Callable[[Kill], int]":
    """The exit status of a command in which something was killed, when it has been seen that
    nothing is left and that the next one completes.
    """

    def status_after(kill: Kill) -> int:
        place = Place(folder=tmp_path, engine=kill.engine)
        place.prepare()
        done = place.run(KILL_AT=kill.at, KILL_WHO=kill.who, KILL_BY=str(int(kill.by)))
        assert (tmp_path / "killed").exists(), done.stderr
        assert "Traceback" not in done.stdout + done.stderr
        wait_for_ends(place)
        kept = place.kept()
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
        # The next start of refdem begins with this.
        folders.sweep()
        assert list((tmp_path / "temporary").iterdir()) == []
        again = command_line(*place.words, cwd=tmp_path, env=place.environment)
        assert again.returncode == 0, again.stdout + again.stderr
        assert again.stderr.count("Traceback") == 0
        (read,) = re.findall(r"(\d+) read from the store", again.stdout)
        assert int(read) >= kept
        unharmed = quiet(kill.engine)
        assert place.findings() == unharmed.findings()
        assert place.files() == unharmed.files()
        return done.returncode

    return status_after


def wait_for_ends(place: Place) -> None:
    """Waits until no process of the command is there."""
    until = time.monotonic() + PATIENCE
    while running := place.running():
        assert time.monotonic() < until, running
        time.sleep(0.02)


@pytest.mark.parametrize("kill", [*ENDS, *TOGETHER], ids=name)
def test_a_command_that_is_ended_leaves_nothing_and_goes_on(after, kill: Kill) -> None:
    assert after(kill) == STATUS[kill.by]


@pytest.mark.parametrize("kill", OTHERS, ids=name)
def test_a_command_outlives_what_it_has_started(after, kill: Kill) -> None:
    assert after(kill) in (0, BROKEN)
