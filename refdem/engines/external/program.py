"""The program of a refdem.toml: where it is, what belongs to it, and one run of it in an empty folder."""

import contextlib
import shutil
import subprocess
import tempfile
from functools import partial
from pathlib import Path
from time import time

from refdem.core.answer_csv import most_rows, read_answer
from refdem.core.engine import Stages
from refdem.core.problem import Request
from refdem.core.request_text import request_text
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external.description import EngineTable
from refdem.engines.external.kept import kept
from refdem.engines.external.process import ended, printable
from refdem.errors import EngineError, UsageError
from refdem.scene import bodies_file

FILES = {"request": "request.json", "request_txt": "request.txt", "trajectory": "trajectory.csv", "events": "events.csv"}
ROW = 1024
"""Bytes that a row of the CSV file may take; 15 numbers and 5 channels of 17 digits take 500."""
SPARE = 2**26
"""Bytes that a program may write into one file however few rows are asked for: it may talk."""

CLOCK_SLACK = 2.0
"""Seconds by which a file system's clock may be coarse."""


class Program:
    """The command of an engine table, whose relative paths are meant from `home`."""

    def __init__(self, table: EngineTable, home: Path) -> None:
        self.table = table
        self.home = home

    def missing(self) -> str | None:
        """None if the first word of the command can be run."""
        word = self.table.command[0]
        if shutil.which(self._placed(word)):
            return None
        return f"{word} is not there or cannot be run (from {self.home}); build it, or correct engine.command"

    def files(self) -> list[Path]:
        """Every file that the command names, and every file that `inputs` matches."""
        named = [Path(self._placed(word)) for word in self.table.command]
        named += [Path(found) for word in self.table.command[:1] if (found := shutil.which(word))]
        matched = [path for pattern in self.table.inputs for path in self._matched(pattern)]
        return sorted({path.resolve() for path in [*named, *matched] if path.is_file()})

    def _matched(self, pattern: str) -> list[Path]:
        """The files that one of `inputs` matches; a fingerprint without them would call a changed program unchanged."""
        found = [path for path in self.home.glob(pattern) if path.is_file()]
        if not found:
            raise UsageError(f"{self.home / 'refdem.toml'}: engine.inputs has {pattern!r}, which matches no file; correct or remove it")
        return found

    def version(self) -> str:
        """First line of what the version command prints; empty if there is none or it fails."""
        if not self.table.version_command:
            return ""
        command = [self._placed(word) for word in self.table.version_command]
        with contextlib.suppress(OSError, subprocess.SubprocessError):
            done = subprocess.run(command, cwd=self.home, capture_output=True, text=True, timeout=10, errors="replace")
            lines = (done.stdout or done.stderr).strip().splitlines()
            return printable(lines[0])[:80] if lines and done.returncode == 0 else ""
        return ""

    def stages(self, request: Request) -> Stages[tuple[Trajectory, Cost]]:
        """One run; what it wrote is kept where something went wrong, and the error says where."""
        with tempfile.TemporaryDirectory(prefix="refdem-run-", ignore_cleanup_errors=True) as name:
            folder = Path(name)
            try:
                return (yield from self._stages(request, folder))
            except EngineError as error:
                place = kept(folder, self.table.name)
                raise EngineError(f"{error} (request and output are kept in {place})" if place else str(error)) from None

    def _stages(self, request: Request, folder: Path) -> Stages[tuple[Trajectory, Cost]]:
        paths = {name: folder / file for name, file in FILES.items()}
        paths["request"].write_bytes(request.to_json())
        paths["request_txt"].write_text(request_text(request))
        if (file := request.bodies_file) is not None:
            (folder / bodies_file.NAME).write_bytes(file)
        began_at = time()
        command, most = [self._filled(word, paths) for word in self.table.command], SPARE + ROW * most_rows(request.problem)
        result = yield partial(ended, command, folder, name=self.table.name, timeout=self.table.timeout, most_bytes=most)
        seconds = result()
        _refuse_stale(paths["trajectory"], began_at)
        trajectory = read_answer(request.problem, paths["trajectory"], paths["events"])
        return trajectory, Cost(seconds=seconds, steps=request.stride * (len(request.problem.times) - 1) if request.step else 0)

    def _filled(self, word: str, paths: dict[str, Path]) -> str:
        """A word of the command with its placeholders filled in and its relative path resolved."""
        for name, path in paths.items():
            word = word.replace("{" + name + "}", str(path))
        return self._placed(word)

    def _placed(self, word: str) -> str:
        """A word that names a file below `home` as a full path, any other as it is."""
        path = self.home / word
        return str(path) if not Path(word).is_absolute() and path.is_file() else word


def _refuse_stale(path: Path, began: float) -> None:
    """Raises EngineError for a file that is older than the run: a link to, or a copy of, another run's."""
    if path.is_file() and path.stat().st_mtime < began - CLOCK_SLACK:
        raise EngineError(f"{path.name} is older than the run itself; expected a file that this run wrote")
