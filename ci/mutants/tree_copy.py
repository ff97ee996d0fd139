"""A copy of the tree in which files are spoiled and kernels built, one at a time; the tree itself
is never touched.

A copy is kept in build/ from run to run. `refreshed` makes it equal to the tree again, whatever a
run that was killed left there, and meson builds only the kernels whose sources changed.
"""

import contextlib
import fcntl
import json
import os
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parents[2]
KERNELS = Path("refdem/kernels")
COMMAND = (
    "-P",
    "-m",
    "pytest",
    "-q",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:xdist",
    "--no-header",
    "--tb=line",
)
MEMORY = 16 * 2**30
"""[bytes] that a process of tests may ask for: a planted error may ask for all there is."""
LAST = 12
"""Number of lines of a process's output that are kept."""
NOT_FOUND = 4
"""Exit status of pytest if a requested test does not exist."""
MOMENT = 0.01
"""Time [s] within which a killed process ends."""
NEW_SECOND = 1_000_000_000
"""[s since 1970] of the first file written: Python tells versions of a file by whole seconds and
size.
"""


@dataclass(frozen=True)
class Ended:
    """How a process of tests ended: its status, None if it ran out of time, the tests that failed
    or crashed, its last words.
    """

    status: int | None
    failed: tuple[str, ...]
    said: str = ""

    @property
    def is_red(self) -> bool:
        """True unless every test passed or was skipped."""
        return self.status != 0


@dataclass
class TreeCopy:
    """The copy at `place`;

    `flags` are more options of the compiler, for kernels built by `built_kernel` in
    build/`scratch`.
    """

    place: Path
    flags: tuple[str, ...] = ()
    scratch: str = "planted"
    _written: int = NEW_SECOND
    _commands: dict[str, list[str]] = field(default_factory=dict)
    _includes: dict[str, set[str]] = field(default_factory=dict)
    _lock: IO[str] | None = None
    _process: "subprocess.Popen[bytes] | None" = None

    def refreshed(self) -> "TreeCopy":
        """Makes all files, and the kernels, what the tree's sources say; raises RuntimeError if
        they do not build.
        """
        self.place.mkdir(parents=True, exist_ok=True)
        wanted = _listed(ROOT)
        for name in sorted(_listed(self.place) - wanted if (self.place / ".git").exists() else ()):
            (self.place / name).unlink(missing_ok=True)
        for name in sorted(wanted):
            self._copied(name)
        if not (self.place / ".git").exists():
            subprocess.run(["git", "init", "--quiet"], cwd=self.place, check=True)
        command = [str(self.place / "ci/develop/build-in-place"), sys.executable]
        done = subprocess.run(command, cwd=self.place, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(
                f"the kernels of the tree do not build: {done.stdout[-2000:]}{done.stderr[-2000:]}"
            )
        shutil.rmtree(self.place / "build" / self.scratch, ignore_errors=True)
        listed = json.loads((self.place / "build/dev/compile_commands.json").read_text())
        commands = [shlex.split(entry["command"]) for entry in listed]
        self._commands = {Path(command[-1]).name: command for command in commands}
        return self

    def locked(self) -> bool:
        """True if the copy now belongs to this process, which keeps it to its end."""
        self.place.parent.mkdir(parents=True, exist_ok=True)
        lock = self.place.with_suffix(".lock").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            return False
        self._lock = lock
        return True

    def _copied(self, name: str) -> None:
        """Copies one file unless it is the same already; links and rights stay what they are."""
        source = ROOT / name
        target = self.place / name
        if target.exists() and target.read_bytes() == source.read_bytes():
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)

    def written(self, name: str, text: bytes) -> None:
        """Writes one file of the copy; no compiled Python of another version is taken for it."""
        path = self.place / name
        path.write_bytes(text)
        self._written += 1
        os.utime(path, (self._written, self._written))

    def families_of(self, name: str) -> list[str]:
        """The kernels that a source file of C is part of: its own, or all that include it."""
        header = Path(name).name
        families = sorted(path.stem for path in (ROOT / KERNELS).glob("*.c"))
        return [family for family in families if header in self._reached(f"{family}.c")]

    def _reached(self, file: str) -> set[str]:
        """A file of C and all that it includes."""
        if file not in self._includes:
            text = (ROOT / KERNELS / file).read_text()
            lines = [
                line.split('"')[1] for line in text.splitlines() if line.startswith('#include "')
            ]
            inside = [self._reached(line) for line in lines if (ROOT / KERNELS / line).exists()]
            self._includes[file] = {file}.union(*inside)
        return self._includes[file]

    def built_kernel(self, family: str) -> bool:
        """True if one kernel compiles as its source is now; it takes the place of the one that
        meson built.
        """
        scratch = self.place / "build" / self.scratch
        scratch.mkdir(parents=True, exist_ok=True)
        objects = [scratch / f"{family}.o", scratch / f"_{family}_glue.o"]
        for target in objects:
            if not self._compiled(family, target):
                return False
        made = scratch / f"_{family}.so"
        # The compiler may be called through another program, as ccache is.
        compiler = takewhile(lambda word: not word.startswith("-"), self._commands[f"{family}.c"])
        link = [
            *compiler,
            "-shared",
            "-fPIC",
            *self.flags,
            *map(str, objects),
            "-lm",
            "-pthread",
            "-o",
            str(made),
        ]
        if subprocess.run(link, capture_output=True).returncode:
            return False
        made.replace(self.place / KERNELS / self._extension(family).name)
        return True

    def _compiled(self, family: str, target: Path) -> bool:
        """True if one object is compiled; the glue, which has no mutants, is compiled once."""
        is_glue = target.stem.endswith("_glue")
        if is_glue and target.exists():
            return True
        command = self._commands[f"_{family}_glue.c" if is_glue else f"{family}.c"]
        given = command[: command.index("-MD")]
        line = [*given, *self.flags, "-o", str(target), "-c", command[-1]]
        return (
            subprocess.run(line, cwd=self.place / "build/dev", capture_output=True).returncode == 0
        )

    def _extension(self, family: str) -> Path:
        """The kernel that meson built."""
        (found,) = (self.place / "build/dev").glob(f"_{family}.*so")
        return found

    def pristine_kernel(self, family: str) -> None:
        """Puts back the kernel that meson built."""
        source = self._extension(family)
        new = self.place / KERNELS / ".new"
        shutil.copy(source, new)
        new.replace(self.place / KERNELS / source.name)

    def environment(self) -> dict[str, str]:
        """What tests see: the copy's sources and its own store; what they leave behind stays in the
        copy.
        """
        temporary = self.place / "build/tmp"
        temporary.mkdir(parents=True, exist_ok=True)
        paths = [str(self.place), str(self.place / "ci/mutants"), os.environ.get("PYTHONPATH", "")]
        more = {
            "PYTHONPATH": os.pathsep.join(filter(None, paths)),
            "REFDEM_STORE": str(self.place / "build/store.sqlite"),
            "TMPDIR": str(temporary),
        }
        return os.environ | more | (sanitizers() if self.is_sanitized else {})

    @property
    def is_sanitized(self) -> bool:
        """True if kernels are built with the address sanitizer."""
        return any(flag.startswith("-fsanitize=address") for flag in self.flags)

    def tested(
        self,
        tests: Sequence[str],
        limit: float,
        more: Sequence[str] = ("-x",),
        also: dict[str, str] | None = None,
        seconds: dict[str, float] | None = None,
    ) -> Ended:
        """Runs tests in this order until one fails; nothing that they started is left, and nothing
        that they wrote to TMPDIR.

        A test that takes ten times its `seconds` of the processor has crashed.
        """
        environment = self.environment() | (also or {})
        with tempfile.TemporaryDirectory(dir=environment["TMPDIR"]) as nest:
            environment["TMPDIR"] = nest
            environment["REFDEM_CURRENT_TEST"] = str(Path(nest) / "current")
            environment["REFDEM_SECONDS"] = str(Path(nest) / "seconds")
            Path(environment["REFDEM_SECONDS"]).write_text(json.dumps(seconds or {}))
            capture: tuple[str, ...] = ()
            if self.is_sanitized:
                capture = ("--capture=sys",)
            command = [
                sys.executable,
                *COMMAND,
                *capture,
                "-p",
                "current_test",
                "-rfE",
                *more,
                *tests,
            ]
            with tempfile.TemporaryFile("w+") as said:
                status = self._finished(command, environment, said, limit)
                said.seek(0)
                lines = said.readlines()
                failed = [
                    line.split(" ", 1)[1]
                    for line in lines
                    if line.startswith(("FAILED ", "ERROR "))
                ]
            current = Path(environment["REFDEM_CURRENT_TEST"])
            # A crash, a sanitizer's abort among them, or a hang that the limit ended names no test
            # itself.
            if status != 0 and not failed and current.exists():
                failed.append(current.read_text())
        names = [name.split(" - ")[0].strip() for name in failed]
        return Ended(status, tuple(filter(None, names)), "".join(lines[-LAST:]))

    def collected(self, files: Iterable[str], limit: float) -> set[str]:
        """The names of all tests that files have now; empty if they cannot be collected within
        `limit` [s].
        """
        command = [sys.executable, *COMMAND, "--collect-only", *files]
        with tempfile.TemporaryFile("w+") as said:
            status = self._finished(command, self.environment(), said, limit)
            said.seek(0)
            if status != 0:
                return set()
            return {line.strip() for line in said if "::" in line}

    def _finished(
        self, command: list[str], environment: dict[str, str], said: IO[str], limit: float
    ) -> int | None:
        """The status of a command, None if it ran longer than its limit [s]; its whole group of
        processes ends with it.
        """
        self._process = subprocess.Popen(
            command,
            cwd=self.place,
            env=environment,
            stdout=said,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=None if self.is_sanitized else _bounded,
        )
        try:
            return self._process.wait(limit)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.stop()

    def stop(self) -> None:
        """Ends what runs in this copy now, with all that it started."""
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        while left := _marked(self.place):
            for number in left:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(number, signal.SIGKILL)
            time.sleep(MOMENT)


def _marked(place: Path) -> list[int]:
    """Processes that were started with the environment of tests in a copy: those that left their
    group too.
    """
    found = []
    marker = f"REFDEM_CURRENT_TEST={place}/".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if marker in (folder / "environ").read_bytes():
                found.append(int(folder.name))
    return found


def sanitizers() -> dict[str, str]:
    """What Python needs to load kernels with sanitizers: as in ci/testing/sanitized."""
    names = ("libasan.so", "libubsan.so")
    found = [
        subprocess.run(
            ["gcc", f"-print-file-name={name}"], capture_output=True, text=True, check=True
        ).stdout
        for name in names
    ]
    return {
        "LD_PRELOAD": " ".join(path.strip() for path in found),
        "ASAN_OPTIONS": "detect_leaks=0",
        "PYTHONMALLOC": "malloc",
    }


def _bounded() -> None:
    """Bounds the memory of a process before it begins, and lets no crash leave a file of its
    memory.
    """
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _listed(tree: Path) -> set[str]:
    """Files of a tree that git tracks or could track, without ignored ones."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(command, cwd=tree, check=True, capture_output=True, text=True)
    return {name for name in done.stdout.split("\0") if name and (tree / name).is_file()}
