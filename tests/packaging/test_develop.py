"""What CONTRIBUTING says of `make develop`: a `refdem` that runs from the tree, workers included,
and the way back to the wheel.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STAMPS = ("made", "for-runs", "for-tests", "for-all")
"""What `make` would install first; here the packages of the running interpreter stand for them."""


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tracked tree with an environment of its own, whose dependencies are those of
    the running interpreter.
    """
    place = tmp_path_factory.mktemp("clone")
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    for name in listed.stdout.split():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    venv.create(place / ".venv", with_pip=True)
    # A path file later in the alphabet than refdem's own: the tree is found before whatever refdem
    # is installed over there.
    lent = packages(place) / "zz-lent.pth"
    lent.write_text(f"{sysconfig.get_path('purelib')}\n")
    for tool in ("meson", "ninja"):
        (place / ".venv" / "bin" / tool).symlink_to(Path(sys.executable).parent / tool)
    for stamp in STAMPS:
        (place / ".venv" / stamp).touch()
    return place


def packages(place: Path) -> Path:
    """The folder of installed packages of the clone's environment."""
    (found,) = (place / ".venv" / "lib").glob("python*/site-packages")
    return found


def done(place: Path, *command: str, cwd: Path | None = None) -> str:
    """What a command prints that must end well."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "MAKEFLAGS", "MAKELEVEL")
    }
    environment |= {"REFDEM_STORE": str(place / "store.sqlite")}
    ended = subprocess.run(
        command, cwd=cwd or place, env=environment, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def origin(place: Path, elsewhere: Path) -> Path:
    """The folder from which the clone's environment imports refdem."""
    code = "import refdem; print(refdem.__path__[0])"
    return Path(done(place, str(place / ".venv/bin/python"), "-c", code, cwd=elsewhere).strip())


def test_a_contributor_runs_from_the_tree_and_goes_back_to_the_wheel(
    clone: Path, tmp_path: Path
) -> None:
    refdem = str(clone / ".venv/bin/refdem")
    asked = (
        "run",
        "harmonic-oscillator",
        "--engine",
        "reference",
        "--jobs",
        "2",
        "--no-cache",
        "--out",
        str(tmp_path / "report"),
    )

    done(clone, "make", "develop")
    assert origin(clone, tmp_path) == clone / "refdem"
    assert "pass" in done(clone, refdem, *asked, cwd=tmp_path)

    done(clone, "make", ".venv/refdem")
    assert origin(clone, tmp_path) == packages(clone) / "refdem"
    assert not (packages(clone) / "refdem-tree.pth").exists()
    assert "pass" in done(clone, refdem, *asked, cwd=tmp_path)
