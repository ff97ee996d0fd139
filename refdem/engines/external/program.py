"""The program of a refdem.toml: where it is, what belongs to it, and one run of it in an empty
folder.

One that stays alive is in served_program.py.
"""

import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import BinaryIO

from refdem.core.answer_csv import most_rows, read_answer
from refdem.core.engine import Stages
from refdem.core.outside import one_line, put_new
from refdem.core.problem import Request
from refdem.core.request_text import request_text
from refdem.core.sensitivities_csv import with_sensitivities
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external.description import EngineTable
from refdem.engines.external.folders import MOST_TRIES, run_folder
from refdem.engines.external.kept import kept
from refdem.engines.external.process import GIGABYTE, Limits, ended, most_memory, run
from refdem.errors import EngineError, UsageError
from refdem.scene import bodies_file

FILES = {
    "request": "request.json",
    "request_txt": "request.txt",
    "trajectory": "trajectory.csv",
    "trajectory_npy": "trajectory.npy",
    "events": "events.csv",
    "sensitivities": "sensitivities.csv",
}
KEPT = " (request and output are kept in"
"""The end of an error's message, which names the folder with the files of the failed run."""
ROW = 1024
"""Bytes that a row of the CSV file may take; 15 numbers and 5 channels of 17 digits take 500."""
SPARE = 2**26
"""Bytes that a program may always write into one file, for messages, however few rows are needed.
"""
VERSION_LIMITS = Limits(timeout=10.0, file_bytes=2**26, memory=2**32)
"""Limits of a version command; an MPI program maps files of several megabytes when it starts."""


class Program:
    """The command of an engine table, whose relative paths are meant from `home`."""

    def __init__(self, table: EngineTable, description: Path) -> None:
        self.table = table
        self.description = description
        self.home = description.parent

    def missing(self) -> str | None:
        """None if the first words of the command and of the version command can be run.

        A command that is an interpreter with a driver is there without the program that it drives.
        """
        programs = [self.table.command[0], *self.table.version_command[:1]]
        word = next((word for word in programs if not shutil.which(self.placed(word))), None)
        if word is None:
            return None
        advice = one_line(self.table.install) or "build it, or correct engine.command"
        return f"{word} does not exist or is not executable (from {self.home}); {advice}"

    def files(self) -> list[Path]:
        """Every file that the command names, and every file that `inputs` matches."""
        named = [Path(self.placed(word)) for word in self.table.command]
        named += [Path(found) for word in self.table.command[:1] if (found := shutil.which(word))]
        matched = [path for pattern in self.table.inputs for path in self._matched(pattern)]
        return sorted({path.resolve() for path in [*named, *matched] if path.is_file()})

    def _matched(self, pattern: str) -> list[Path]:
        """The files that a pattern in `inputs` matches; they are part of the fingerprint, so that a
        changed file counts as a changed program.
        """
        matches = [path for path in self.home.glob(pattern) if path.is_file()]
        if not matches:
            raise UsageError(
                f"{self.description}: engine.inputs has {pattern!r}, which matches no file;"
                " correct or remove it"
            )
        return matches

    def version(self) -> str:
        """First line of what the version command prints; empty if there is none or it fails."""
        if not self.table.version_command:
            return ""
        command = [self.placed(word) for word in self.table.version_command]
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            try:
                status = run(command, self.home, out, err, VERSION_LIMITS).status
            except EngineError:
                return ""
            outputs = [_beginning(file) for file in (out, err)]
        lines = (outputs[0] or outputs[1]).splitlines()
        if lines and status == 0:
            return one_line(lines[0], 80)
        return ""

    def stages(self, request: Request) -> Stages[tuple[Trajectory, Cost]]:
        """One run, which is repeated if the files of its request were deleted meanwhile.

        Another program may have deleted them.
        """
        failure = EngineError(f"{self.table.name} was not run")
        for _ in range(MOST_TRIES):
            with run_folder(self.table.name) as folder:
                try:
                    return (yield from self._kept(request, folder))
                except EngineError as error:
                    failure = error
                if (folder / FILES["request"]).is_file():
                    break
        raise failure

    def _kept(self, request: Request, folder: Path) -> Stages[tuple[Trajectory, Cost]]:
        """One run in its folder; what it wrote is kept where something went wrong, and the error
        says where.
        """
        try:
            return (yield from self._stages(request, folder))
        except EngineError as error:
            place = kept(folder, self.table.name)
            sentence = str(error)
            if place:
                sentence += f"{KEPT} {place})"
            raise type(error)(sentence) from None

    def _stages(self, request: Request, folder: Path) -> Stages[tuple[Trajectory, Cost]]:
        """Writes the request into the folder, yields the command to be run there, and reads its
        answer.
        """
        paths = written(request, folder)
        command = [self._filled(word, paths) for word in self.table.command]
        limits = Limits(
            timeout=self.table.timeout, file_bytes=most_bytes(request), memory=self.memory()
        )
        result = yield partial(ended, command, folder, name=self.table.name, limits=limits)
        seconds = result()
        trajectory = read_answer(request.problem, paths["trajectory"], paths["events"])
        trajectory = with_sensitivities(trajectory, paths["sensitivities"], request.sensitivities)
        return trajectory, Cost(seconds=seconds, steps=steps_of(request))

    def memory(self) -> int:
        """The memory limit [bytes] of each process of a run: that of the refdem.toml if it states
        one, else most of the machine's memory.
        """
        if self.table.memory is None:
            return most_memory()
        return int(self.table.memory * GIGABYTE)

    def _filled(self, word: str, paths: dict[str, Path]) -> str:
        """The word of the command, each `{name}` in it replaced by the path of that file, and a
        relative path made a full one.
        """
        for name, path in paths.items():
            word = word.replace("{" + name + "}", str(path))
        return self.placed(word)

    def placed(self, word: str) -> str:
        """The word as a full path if it names a file below `home`, else the word as it is."""
        path = self.home / word
        if not Path(word).is_absolute() and path.is_file():
            return str(path)
        return word


def written(request: Request, folder: Path) -> dict[str, Path]:
    """The files of a run by name, of which those of the request are written."""
    paths = {name: folder / file for name, file in FILES.items()}
    put_new(paths["request"], request.to_json())
    put_new(paths["request_txt"], request_text(request).encode())
    if (file := request.bodies_file) is not None:
        put_new(folder / bodies_file.NAME, file)
    return paths


def most_bytes(request: Request) -> int:
    """Bytes of each file that a program may write for a request."""
    files = 1 + len(request.sensitivities)
    return SPARE + ROW * files * most_rows(request.problem)


def steps_of(request: Request) -> int:
    """Steps that a request asks for; 0 of a method without them."""
    if request.step:
        return request.stride * (len(request.problem.times) - 1)
    return 0


def _beginning(file: BinaryIO) -> str:
    """The beginning of a command's output."""
    file.seek(0)
    return file.read(4096).decode(errors="replace").strip()
