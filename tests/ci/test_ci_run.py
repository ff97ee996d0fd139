"""What CI runs: every stage, in two lanes at once, with the time that each took; one that fails
fails CI.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STAGES = {
    "test",
    "test-elsewhere",
    "sanitized",
    "fuzz",
    "docs",
    "lint",
    "certify-sample",
    "test-touched",
}
MAKE = '#!/bin/sh\necho "made $*"\ncase " $BROKEN " in *" $* "*) exit 3 ;; esac\n'


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A tree in which make, and the packages of the system, are there in name only."""
    for name, text in {"bin/make": MAKE, "ci/packaging/system-packages": "#!/bin/sh\n"}.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
        path.chmod(0o755)
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci" / "run", tmp_path / ".ci" / "run")
    return tmp_path


def run(place: Path, broken: str = "") -> "subprocess.CompletedProcess[str]":
    """CI in that tree, in which some targets of make fail."""
    environment = os.environ | {
        "PATH": f"{place / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "TMPDIR": str(place),
        "BROKEN": broken,
    }
    return subprocess.run(
        ["bash", ".ci/run"],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def told(said: str) -> set[str]:
    """The targets whose time is in the table at the end."""
    _, _, table = said.partition("ci: where the time went")
    return set(re.findall(r"^ +\d+ s +\d+ s  make ([\w-]+)$", table, re.MULTILINE))


def test_every_stage_is_run_and_its_time_is_told(place: Path) -> None:
    done = run(place)
    assert done.returncode == 0, done.stdout + done.stderr
    assert set(re.findall(r"^made ([\w-]+)$", done.stdout, re.MULTILINE)) == STAGES
    assert told(done.stdout) == STAGES
    assert {path.name for path in place.iterdir()} == {".ci", "bin", "ci"}


def test_what_make_has_for_all_tests_is_in_ci() -> None:
    text = (ROOT / "Makefile").read_text()
    every = re.search(r"^test-all: (.*)$", text, re.MULTILINE)
    assert every is not None
    assert {*every[1].split(), "test", "fuzz"} == STAGES


@pytest.mark.parametrize("stage", sorted(STAGES))
def test_a_stage_that_fails_fails_ci_and_the_other_lane_is_told_nevertheless(
    place: Path, stage: str
) -> None:
    done = run(place, stage)
    assert done.returncode == 3, done.stdout + done.stderr
    assert stage in told(done.stdout)
    assert {"test", "test-elsewhere"} <= told(done.stdout)


def test_nothing_is_tested_where_refdem_cannot_be_built(place: Path) -> None:
    done = run(place, ".venv/refdem")
    assert done.returncode == 3
    assert told(done.stdout) == set()
    assert "made .venv/refdem" in done.stdout


BUSY = """
case " $* " in
  *" test-elsewhere "*) sh -c 'ulimit -c 0; ulimit -t 2; while :; do :; done' ;;
  *" test-touched "*) touch "$TMPDIR/ended" ;;
  *" test "*) while [ ! -e "$TMPDIR/ended" ]; do sleep 0.1; done; sleep 1 ;;
esac
exit 0
"""
"""What targets do at last: one is at work, and one waits until all of the other lane have ended."""


def test_work_of_one_lane_is_not_counted_for_the_other(place: Path) -> None:
    (place / "bin" / "make").write_text(MAKE + BUSY)
    done = run(place)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = re.findall(r"^ +\d+ s +(\d+) s  make ([\w-]+)$", done.stdout, re.MULTILINE)
    at_work = [target for seconds, target in rows if int(seconds) > 0]
    assert at_work == ["test-elsewhere"]
