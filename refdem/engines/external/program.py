"""A program run as a process: argv and never a shell, an empty folder, a time limit that ends its whole process group."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from time import perf_counter

from refdem.core.problem import Request
from refdem.core.request_text import request_text
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.trajectory_csv import read_trajectory
from refdem.engines.external.description import EngineTable
from refdem.errors import EngineError, UnsupportedError

NOT_SUPPORTED = 77
FILES = {"request": "request.json", "request_txt": "request.txt", "trajectory": "trajectory.csv", "events": "events.csv"}
SHOWN = 300


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
        matched = [path for pattern in self.table.inputs for path in self.home.glob(pattern)]
        return sorted({path.resolve() for path in [*named, *matched] if path.is_file()})

    def version(self) -> str:
        """First line of what the version command prints; empty if there is none or it fails."""
        if not self.table.version_command:
            return ""
        command = [self._placed(word) for word in self.table.version_command]
        with contextlib.suppress(OSError, subprocess.SubprocessError):
            done = subprocess.run(command, cwd=self.home, capture_output=True, text=True, timeout=10, errors="replace")
            return (done.stdout or done.stderr).strip().splitlines()[0][:80] if (done.stdout or done.stderr).strip() else ""
        return ""

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """One run; its folder is kept where something went wrong, and the error names it."""
        folder = Path(tempfile.mkdtemp(prefix="refdem-run-"))
        try:
            found = self._run(request, folder)
        except UnsupportedError:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        except EngineError as error:
            raise EngineError(f"{error} (request and output are kept in {folder})") from None
        shutil.rmtree(folder, ignore_errors=True)
        return found

    def _run(self, request: Request, folder: Path) -> tuple[Trajectory, Cost]:
        paths = {name: folder / file for name, file in FILES.items()}
        paths["request"].write_bytes(request.to_json())
        paths["request_txt"].write_text(request_text(request))
        began = perf_counter()
        status = self._ended([self._filled(word, paths) for word in self.table.command], folder)
        seconds = perf_counter() - began
        says = _last_lines(folder / "stderr.txt")
        if status == NOT_SUPPORTED:
            raise UnsupportedError(says.splitlines()[-1] if says else "the program says it cannot (exit 77)")
        if status != 0:
            how = f"signal {-status}" if status < 0 else f"exit status {status}"
            raise EngineError(f"{self.table.name} ended with {how}: {says or 'it said nothing on stderr'}")
        bodies = len(request.problem.scene.bodies)
        trajectory = read_trajectory(paths["trajectory"], len(request.problem.times), bodies, paths["events"])
        steps = request.stride * (len(request.problem.times) - 1) if request.step else 0
        return trajectory, Cost(seconds=seconds, steps=steps)

    def _ended(self, command: list[str], folder: Path) -> int:
        """Runs the command in `folder`, its output kept beside; raises EngineError if it cannot start or does not end."""
        with (folder / "stdout.txt").open("wb") as out, (folder / "stderr.txt").open("wb") as err:
            try:
                process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True)
            except OSError as error:
                raise EngineError(f"{command[0]} cannot be started: {error.strerror}") from None
            try:
                return process.wait(self.table.timeout)
            except subprocess.TimeoutExpired:
                raise EngineError(f"{self.table.name} was still running after {self.table.timeout:g} s and was ended") from None
            finally:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()

    def _filled(self, word: str, paths: dict[str, Path]) -> str:
        """A word of the command with its placeholders filled in and its relative path resolved."""
        for name, path in paths.items():
            word = word.replace("{" + name + "}", str(path))
        return self._placed(word)

    def _placed(self, word: str) -> str:
        """A word that names a file below `home` as a full path, any other as it is."""
        path = self.home / word
        return str(path) if not Path(word).is_absolute() and path.is_file() else word


def _last_lines(path: Path) -> str:
    """The end of what the program said, printable."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4 * SHOWN))
        text = file.read().decode(errors="replace").strip()
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in text)[-SHOWN:]
