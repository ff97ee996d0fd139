"""ci/gate/install runs in the folder of another repository, whose files it takes for nothing."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
BACKEND = """
import zipfile


def build_wheel(folder, config_settings=None, metadata_directory=None):
    name = "thing-1.0-py3-none-any.whl"
    with zipfile.ZipFile(f"{folder}/{name}", "w") as archive:
        archive.writestr("thing.py", "")
        of = "thing-1.0.dist-info"
        archive.writestr(f"{of}/METADATA", "Metadata-Version: 2.1\\nName: thing\\nVersion: 1.0\\n")
        archive.writestr(f"{of}/WHEEL", "Wheel-Version: 1.0\\nTag: py3-none-any\\n")
        archive.writestr(f"{of}/RECORD", "thing.py,,\\n")
    return name
"""
SHADOWS = ("venv", "pip", "argparse", "subprocess", "zipfile", "tomllib", "ensurepip")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout of something that needs no other package, with the script that installs refdem."""
    home = tmp_path / "refdem"
    (home / "ci" / "gate").mkdir(parents=True)
    shutil.copy(ROOT / "ci" / "gate" / "install", home / "ci" / "gate" / "install")
    (home / "ci" / "packaging").mkdir()
    (home / "ci" / "packaging" / "dependencies.py").write_text("")
    (home / "backend.py").write_text(BACKEND)
    (home / "pyproject.toml").write_text(
        '[build-system]\nrequires = []\nbuild-backend = "backend"\nbackend-path = ["."]\n'
        '[project]\nname = "thing"\nversion = "1.0"\n'
    )
    return home


def test_the_modules_of_the_other_repository_are_not_run(checkout: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    for name in SHADOWS:
        (other / f"{name}.py").write_text(
            f"open({str(tmp_path / 'ran')!r}, 'a').write('{name}')\nraise SystemExit(0)\n"
        )
    environment = os.environ | {"PYTHON": sys.executable, "PYTHONPATH": str(other)}
    done = subprocess.run(
        ["bash", str(checkout / "ci" / "gate" / "install"), "installed"],
        cwd=other,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "ran").exists()
    asked = [str(other / "installed" / "bin" / "python"), "-I", "-c", "import thing"]
    assert subprocess.run(asked, timeout=60).returncode == 0


@pytest.mark.parametrize("template", ["action.yml", "ci/gate/gitlab.yml"])
def test_what_is_committed_as_the_outcome_of_a_gate_is_removed_before_it(template: str) -> None:
    """A job that ends before it has written anything would show it as its summary."""
    text = (ROOT / template).read_text()
    assert yaml.safe_load(text)
    lines = [line.strip() for line in text.splitlines() if not line.strip().startswith("#")]
    (gate,) = (k for k, line in enumerate(lines) if "refdem-gate.xml --markdown" in line)
    removed = lines[gate - 1].removeprefix("- ").split()
    written = set(re.findall(r"--\w+ (refdem-[\w.]+)", " ".join(lines[gate : gate + 2])))
    assert len(written) > 2
    assert removed[:2] == ["rm", "-rf"]
    assert set(removed[2:]) == written
