"""A package of one's own with a case, a check and an engine: installed by pip, it is listed, run,
gated and reported like refdem's own.

Its three modules are the examples of CONTRIBUTING.md; a program under a gate answers its case as
well.
"""

import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from refdem.core.finding import Record
from refdem.report import read_records

TEXT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text()
INFO = "stones-1.0.dist-info"
ENTRY_POINTS = """
[refdem.cases]
throw = stones.throw:CASE
[refdem.checks]
straight-line = stones.straight_line:CHECK
[refdem.engines]
hop = stones.hop:ENGINE
"""
PROGRAM = """
import json, sys
request = json.load(open(sys.argv[1]))
(body,), times, h = request["scene"]["bodies"], request["times"], request["step"]
g = [0.0, 0.0, 0.0]
for element in request["scene"]["elements"]:
    g = [a + b for a, b in zip(g, element["g"])]
stride = round((times[1] - times[0]) / h)
r, v = list(body["position"]), list(body["velocity"])
with open(sys.argv[2], "w") as out:
    print("t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz", file=out)
    for n in range(len(times)):
        for _ in range(stride if n else 0):
            v = [a + h * b for a, b in zip(v, g)]
            r = [a + h * b for a, b in zip(r, v)]
        print(",".join(map(repr, [times[0] + n * stride * h, 0, *r, *v])) + "," * 7, file=out)
"""
TOML = f"""
[engine]
name = "thrower"
command = ["{sys.executable}", "thrower.py", "{{request}}", "{{trajectory}}"]
supports = ["uniform_gravity"]
timeout = 30
[[engine.methods]]
name = "kick-drift"
order = 1
symplectic = true
[gate]
cases = ["throw", "throw[speed=3]"]
levels = 3
"""

Command = Callable[..., "subprocess.CompletedProcess[str]"]


def wheel(folder: Path, *, change: tuple[str, str] = ("", "")) -> Path:
    """A wheel of the package; `change` replaces text in its case."""
    throw, straight_line, hop = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    contents = {
        "stones/__init__.py": "",
        "stones/throw.py": throw.replace(*change),
        "stones/straight_line.py": straight_line,
        "stones/hop.py": hop,
        f"{INFO}/METADATA": "Metadata-Version: 2.1\nName: stones\nVersion: 1.0\n",
        f"{INFO}/WHEEL": (
            "Wheel-Version: 1.0\nGenerator: hand\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        ),
        f"{INFO}/entry_points.txt": ENTRY_POINTS,
    }
    contents[f"{INFO}/RECORD"] = "".join(f"{name},,\n" for name in [*contents, f"{INFO}/RECORD"])
    folder.mkdir(exist_ok=True)
    path = folder / "stones-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return path


def installed(path: Path, site: Path) -> None:
    """The wheel installed by pip into a folder."""
    quiet = [
        "--quiet",
        "--disable-pip-version-check",
        "--no-deps",
        "--no-index",
        "--upgrade",
        "--target",
        str(site),
    ]
    subprocess.run(
        [sys.executable, "-m", "pip", "install", *quiet, str(path)], check=True, timeout=120
    )


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package in site/, a program and its refdem.toml."""
    folder = tmp_path_factory.mktemp("stones")
    installed(wheel(folder / "dist"), folder / "site")
    (folder / "thrower.py").write_text(PROGRAM)
    (folder / "refdem.toml").write_text(TOML)
    return folder


@pytest.fixture(scope="module")
def refdem(home: Path) -> Command:
    """The command in processes of its own that see the package."""

    def called(*arguments: str, site: Path | None = None) -> "subprocess.CompletedProcess[str]":
        path = [str(site or home / "site"), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(filter(None, path)),
            "REFDEM_STORE": str(home / "store.sqlite"),
        }
        command = [sys.executable, "-c", "from refdem.cli import main; main()", *arguments]
        return subprocess.run(
            command, cwd=home, env=environment, capture_output=True, text=True, timeout=300
        )

    return called


def test_what_the_package_brings_is_listed(refdem: Command) -> None:
    for what, name in (("cases", "throw"), ("checks", "straight-line"), ("engines", "hop")):
        done = refdem("list", what)
        assert done.returncode == 0, done.stderr
        assert any(line.startswith(f"{name} ") for line in done.stdout.splitlines())


def test_its_case_runs_in_every_engine_and_is_reported(refdem: Command, home: Path) -> None:
    done = refdem("run", "throw", "--engine", "hop", "--engine", "reference", "--out", "report")
    assert done.returncode == 0, done.stdout + done.stderr
    records = [sheet for sheet in read_records(home / "report") if isinstance(sheet, Record)]
    passed = {
        record.engine
        for record in records
        for finding in record.findings
        if finding.outcome == "pass"
    }
    assert passed == {"hop", "reference"}
    (home / "report" / "index.html").unlink()
    done = refdem("report", "report")
    assert done.returncode == 0, done.stderr
    assert "throw" in (home / "report" / "index.html").read_text()


def test_its_check_judges_cases_of_refdem(refdem: Command, home: Path) -> None:
    done = refdem(
        "run",
        "two-spheres",
        "--engine",
        "reference",
        "--method",
        "velocity-verlet",
        "--out",
        "spheres",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "velocity-verlet/straight-line/centre" in (home / "spheres" / "junit.xml").read_text()


def test_its_engine_is_smoked(refdem: Command) -> None:
    done = refdem("smoke", "hop")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "pass" in done.stdout


def test_its_case_is_explained_and_has_certified_values(refdem: Command) -> None:
    assert "hop/kick-drift" in refdem("explain", "throw").stdout
    assert "exact rationals" in refdem("truth", "throw", "--at", "1").stdout


def test_a_program_is_gated_on_its_case(refdem: Command) -> None:
    done = refdem("gate", "--bless", "--why", "it was looked at")
    assert done.returncode == 0, done.stdout + done.stderr
    done = refdem("gate")
    assert done.stdout.splitlines()[-1] == "the gate of thrower is open", done.stdout


def test_another_truth_of_its_case_is_not_taken_for_the_one_that_was_proved(
    refdem: Command, home: Path
) -> None:
    assert refdem("run", "throw", "--engine", "hop", "--out", "first").returncode == 0
    changed = wheel(
        home / "other",
        change=("self.v * t - self.g * t * t / 2", "self.v * t - self.g * t * t / 3"),
    )
    installed(changed, home / "other-site")
    done = refdem("run", "throw", "--engine", "hop", "--out", "second", site=home / "other-site")
    assert done.returncode == 1, done.stdout + done.stderr
    assert "throw/hop/kick-drift/error/y" in done.stdout
