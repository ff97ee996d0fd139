"""Example programs compiled in a folder of the test's own, and campaigns of them through the
command line.
"""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

SOURCES = Path(__file__).parent


@dataclass(frozen=True)
class Judged:
    """What the command line said of a program: exit status, output, and its findings by
    `case/check/quantity`.
    """

    status: int
    said: str
    outcomes: dict[str, str]

    def failed(self) -> set[str]:
        """`check/quantity` of what failed."""
        return {
            name.partition("/")[2] for name, outcome in self.outcomes.items() if outcome == "fail"
        }


@dataclass(frozen=True)
class Workshop:
    """Copies of the example programs, with one store of truths for all of them."""

    home: Path
    command_line: "Callable[..., subprocess.CompletedProcess[str]]"

    def built(self, language: str, *faults: tuple[str, str, str], single: bool = False) -> Path:
        """The refdem.toml of a program built from a copy in which `(file, text, other)` was
        replaced, which must be there once.

        `single`: every double is a float, and the description says so.
        """
        folder = self.home / f"{len(list(self.home.iterdir()))}"
        shutil.copytree(
            SOURCES,
            folder,
            ignore=shutil.ignore_patterns("dem", "moments", "*.mod", "*.py", "__pycache__"),
        )
        for name, text, other in faults:
            path = folder / language / name
            assert path.read_text().count(text) == 1, (
                f"{name} has {text!r} {path.read_text().count(text)} times"
            )
            path.write_text(path.read_text().replace(text, other))
        for path in (folder / language).iterdir() if single else ():
            if path.suffix != ".toml":
                text = re.sub(r"\bdouble\b", "float", path.read_text())
            else:
                text = path.read_text()
            path.write_text(text.replace("[engine]\n", '[engine]\nprecision = "single"\n'))
        subprocess.run(["make", "-s", "-C", str(folder), language], check=True, capture_output=True)
        return folder / language / "refdem.toml"

    def refdem(
        self, *arguments: str, cwd: Path | None = None
    ) -> "subprocess.CompletedProcess[str]":
        """The command line with the store of this workshop."""
        environment = os.environ | {"REFDEM_STORE": str(self.home.parent / "store.sqlite")}
        return self.command_line(*arguments, env=environment, cwd=cwd or self.home)

    def judged(self, toml: Path, *cases: str) -> Judged:
        """A campaign of one program."""
        done = self.refdem(
            "run",
            *cases,
            "--engine",
            str(toml),
            "--out",
            str(toml.parent / "report"),
            "--jobs",
            "2",
        )
        outcomes = {}
        records = toml.parent / "report" / "records.jsonl"
        for line in records.read_text().splitlines() if records.exists() else ():
            sheet = json.loads(line)
            for finding in sheet.get("findings", ()):
                outcomes[f"{sheet['label']}/{finding['check']}/{finding['quantity']}"] = finding[
                    "outcome"
                ]
        return Judged(done.returncode, done.stdout + done.stderr, outcomes)


@pytest.fixture(scope="session")
def workshop(
    tmp_path_factory: pytest.TempPathFactory,
    command_line: "Callable[..., subprocess.CompletedProcess[str]]",
) -> Workshop:
    """One for the session."""
    home = tmp_path_factory.mktemp("foreign") / "programs"
    home.mkdir()
    return Workshop(home, command_line)
