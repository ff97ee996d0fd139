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
from functools import partial
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


def turned(cosine: float, sine: float, vector: list[float]) -> list[float]:
    """A vector (x, y, z) turned about y."""
    x, y, z = vector
    return [cosine * x + sine * z, y, cosine * z - sine * x]


@dataclass(frozen=True)
class Bounce:
    """A sphere that spins and strikes a wall, turned about y from the normal z, in a code."""

    command: tuple[str, ...]
    law: dict[str, object]
    size: float = 1.0

    def after(self, folder: Path, cosine: float, sine: float) -> list[list[float]]:
        """Velocity [m/s] and omega [rad/s] afterwards, turned back; lengths are times `size`."""
        to = partial(turned, cosine, sine)

        def lengths(vector: list[float]) -> list[float]:
            return [self.size * x for x in to(vector)]

        body = {
            "mass": 1.0,
            "inertia": [0.1 * self.size**2] * 3,
            "shape": {"kind": "sphere", "radius": 0.5 * self.size},
            "position": lengths([0.3, 0.2, 0.60305]),  # touches amid a step
            "velocity": lengths([0.5, 0.2, -1.0]),
            "attitude": [1.0, 0.0, 0.0, 0.0],
            "omega": to([1.0, 3.0, 2.0]),
            "fixed": False,
        }
        plane = {"kind": "plane", "point": [0.0, 0.0, 0.0], "normal": to([0.0, 0.0, 1.0])}
        scene = {"bodies": [body], "elements": [plane, {"kind": "contact", **self.law}]}
        numbers = {"method": "", "step": 1e-4, "stride": 10000, "times": [0, 1], "scene": scene}
        (folder / "request.json").write_text(json.dumps(numbers))
        subprocess.run(
            [*self.command, "request.json", "trajectory.csv"],
            cwd=folder,
            check=True,
            capture_output=True,
            timeout=60,
        )
        last = (folder / "trajectory.csv").read_text().splitlines()[-1].split(",")
        velocity, omega = ([float(word) for word in last[k : k + 3]] for k in (5, 12))
        back = partial(turned, cosine, -sine)
        return [[v / self.size for v in back(velocity)], back(omega)]

    def assert_as_upright(self, folder: Path, cosine: float, sine: float) -> None:
        """The turned wall acts as the upright one of lengths as they are, which does act."""
        velocity, omega = Bounce(self.command, self.law).after(folder, 1.0, 0.0)
        assert velocity[2] > 0.8
        assert omega[1] < 2.0
        velocity_turned, omega_turned = self.after(folder, cosine, sine)
        # 1e4 steps, each with a few roundings of numbers of size 1.
        assert velocity_turned == pytest.approx(velocity, abs=1e-11)
        assert omega_turned == pytest.approx(omega, abs=1e-11)


@pytest.fixture(scope="session")
def bounce() -> type[Bounce]:
    """The class, for a test to give it a code's command and a law."""
    return Bounce


@pytest.fixture(scope="session")
def gates(
    tmp_path_factory: pytest.TempPathFactory,
    command_line: "Callable[..., subprocess.CompletedProcess[str]]",
) -> Gates:
    """One for the session."""
    return Gates(tmp_path_factory.mktemp("codes"), command_line)
