"""Released DEM codes under the gate: as they are, and with a fault planted in the driver, which is
run from a copy.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from refdem.gate import baseline

ROOT = Path(__file__).resolve().parents[3]
CODES = ROOT / "validation/codes"


@dataclass(frozen=True)
class Gates:
    """Gates with one store of truths;

    `make codes` and ci/packaging/system-packages install the codes, and tests fail where one is not
    there.
    """

    home: Path
    command_line: "Callable[..., subprocess.CompletedProcess[str]]"

    def gated(self, toml: Path) -> "subprocess.CompletedProcess[str]":
        """The gate's exit status and what it says."""
        environment = os.environ | {"REFDEM_STORE": str(self.home / "store.sqlite")}
        return self.command_line("gate", str(toml), env=environment, cwd=self.home)

    def assert_open(self, code: str) -> None:
        """As it is, against the baseline that is kept."""
        done = self.gated(CODES / code / "refdem.toml")
        assert done.returncode == 0, done.stdout + done.stderr

    def assert_closed(
        self, code: str, case: str, seen: str, file: str, text: str, other: str
    ) -> None:
        """With `text` replaced by `other` in a file below validation/codes: the gate of one case
        names the check `seen`.

        Its baseline is emptied: truth has to see the fault, and nothing is run again to tell what
        is worse from noise.
        """
        copy = Path(tempfile.mkdtemp(dir=self.home)) / "codes"
        shutil.copytree(CODES, copy)
        source = copy / file
        toml = copy / code / "refdem.toml"
        assert source.read_text().count(text) == 1
        source.write_text(source.read_text().replace(text, other))
        head = toml.read_text().replace("../../../", f"{ROOT}/").partition("[gate]")[0]
        toml.write_text(f"{head}[gate]\nlevels = 3\ncases = {json.dumps([case])}\n")
        accepted = toml.with_name("refdem-baseline.jsonl")
        header = json.loads(accepted.read_text().partition("\n")[0])
        empty = {"findings": 0, "sha256": baseline.digest([])}
        accepted.write_text(json.dumps(header | empty) + "\n")
        done = self.gated(toml)
        assert done.returncode == 1, done.stdout + done.stderr
        assert any(
            line.startswith("FAIL ") and line.endswith(seen) for line in done.stdout.splitlines()
        ), done.stdout

    def friction_by_unit_of_length(self, program: str) -> dict[str, list[tuple[str, str]]]:
        """By the words of a wall: what LAMMPS and the loop of its script say in each unit."""
        script = CODES / "lammps/deviations/wall_friction.py"
        # Runs of Open MPI disturb each other in one TMPDIR.
        environment = os.environ | {"TMPDIR": tempfile.mkdtemp(dir=self.home)}
        done = subprocess.run(
            [sys.executable, script, program],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
            timeout=100,
        )
        rows: dict[str, list[tuple[str, str]]] = {}
        for line in done.stdout.splitlines()[1:]:
            words, _, said = line.partition(" L = ")
            found, loop = said.partition(": ")[2].split(", ")
            rows.setdefault(words.strip(), []).append((found, loop))
        return rows


@pytest.fixture(scope="session")
def gates(
    tmp_path_factory: pytest.TempPathFactory,
    command_line: "Callable[..., subprocess.CompletedProcess[str]]",
) -> Gates:
    """One for the session."""
    return Gates(tmp_path_factory.mktemp("codes"), command_line)
