"""Numbers of README and of the reports that a person wrote are those that a command finds."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def printed(*command: str) -> str:
    """What a script of ci prints."""
    done = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_errors_of_yades_algorithm_are_those_of_its_twin() -> None:
    findings = (ROOT / "reports" / "findings.md").read_text()
    rows = printed("ci/field/yade_twin.py").splitlines()
    assert len(rows) == 3
    for row in rows:
        assert row in findings


def test_goals_of_the_bench_are_read_from_its_tables() -> None:
    printed("ci/bench/bench_goals.py", "--check")


def test_what_is_said_of_gases_is_what_the_table_of_gases_has() -> None:
    """The change log has the cost of a body and step from 1e3 to 1e5 bodies."""
    smooth = re.search(
        r"^\| smooth \|(.*)", (ROOT / "reports" / "bench.md").read_text(), re.MULTILINE
    )
    assert smooth
    cells = [cell.strip() for cell in smooth[1].split("|")][:3]
    least, *_, most = sorted(float(cell.split(" ns")[0]) for cell in cells)
    assert (
        f"{least:.1f} to {most:.1f} ns a body and step from 1e3 to 1e5"
        in (ROOT / "CHANGELOG.md").read_text()
    )


def test_no_engine_is_said_to_run_what_it_refuses() -> None:
    """The report names what is missing; README and the Makefile promise no more than that."""
    for name in ("README.md", "Makefile"):
        text = " ".join((ROOT / name).read_text().split())
        assert not re.search(r"every case in[^.,;]*(engine|MuJoCo|pymunk|REBOUND)", text), name


def test_readme_counts_the_findings_of_its_own_gate() -> None:
    """tests/documents/test_readme.py runs the gate; the number that the page shows is the one that
    is looked for there.
    """
    readme = (ROOT / "README.md").read_text()
    (shown,) = re.findall(r"# (\d+) findings pass", readme)
    assert f'"{shown} pass" in' in (ROOT / "tests" / "documents" / "test_readme.py").read_text()
