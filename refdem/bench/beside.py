"""Another installation that runs the same levels interleaved with this one: the varying load of
the machine affects both alike.
"""

import subprocess
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec

from refdem.bench.interleaving import Place
from refdem.errors import UsageError


class Beside:
    """A process of another Python that serves `refdem.bench.interleaving`; a context manager."""

    def __init__(self, python: Path) -> None:
        self._python = python
        self.reasons: list[str | None] = []

    def __enter__(self) -> "Beside":
        # -P: the installed refdem, not a checkout in the current folder.
        command = [str(self._python), "-P", "-m", "refdem.bench.interleaving"]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        return self

    def __exit__(self, *_: object) -> None:
        for end in (self._process.stdin, self._process.stdout):
            if end:
                with suppress(BrokenPipeError):
                    end.close()
        self._process.wait()

    def begin(self, places: Sequence[Place]) -> None:
        """Loads every place there and runs it once; `reasons` states why some cannot run."""
        self.reasons = self._reply(msgspec.json.encode(places).decode())

    def seconds(self, number: int) -> float:
        """Seconds that the other installation takes for a place now, by its number."""
        return float(self._reply(str(number)))

    def _reply(self, line: str) -> Any:
        assert self._process.stdin
        assert self._process.stdout
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            raise UsageError(
                f"{self._python} does not run refdem.bench.interleaving; expected the Python of an"
                " installation of refdem that has it"
            )
        return msgspec.json.decode(answer)
