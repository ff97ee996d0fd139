"""The floors of the design: a planted import that a contract forbids breaks that contract, also
inside a function.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLANTED = [
    ("core/quantity.py", "refdem.planning", "Imports point down the floors"),
    ("truth/balls.py", "refdem.mechanics.quaternion", "Truth shares no code with what it judges"),
    ("truth/balls.py", "refdem.core.case", "Truth shares no code with what it judges"),
    ("cases/pendulum.py", "refdem.kernels", "Cases know no engine and no check"),
    ("checks/error.py", "refdem.truth.balls", "Checks know neither answers nor who gave them"),
    (
        "engines/mujoco/__init__.py",
        "refdem.cases.pendulum",
        "Engines get the question and never the answer",
    ),
    (
        "engines/pymunk/__init__.py",
        "refdem.solvers.solver",
        "Solvers are reached through engines.reference alone",
    ),
    ("report/__init__.py", "refdem.truth.balls", "A report is a function of records"),
]


def broken(tree: Path) -> set[str]:
    """Names of the contracts that a tree breaks."""
    linter = Path(sys.executable).with_name("lint-imports")
    printed = subprocess.run(
        [linter, "--no-cache"], cwd=tree, capture_output=True, text=True
    ).stdout
    assert "Contracts:" in printed
    return {
        line.removesuffix(" BROKEN").strip()
        for line in printed.splitlines()
        if line.endswith(" BROKEN")
    }


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package and its contracts."""
    folder = tmp_path_factory.mktemp("tree")
    shutil.copytree(
        ROOT / "refdem", folder / "refdem", ignore=shutil.ignore_patterns("__pycache__", "*.so")
    )
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def test_no_contract_is_broken(tree: Path) -> None:
    assert broken(tree) == set()


@pytest.mark.parametrize(("place", "imported", "contract"), PLANTED)
def test_a_forbidden_import_inside_a_function_breaks_its_contract(
    tree: Path, place: str, imported: str, contract: str
) -> None:
    path = tree / "refdem" / place
    original = path.read_text()
    try:
        path.write_text(f"{original}\n\ndef _planted() -> None:\n    import {imported}\n")
        assert contract in broken(tree)
    finally:
        path.write_text(original)
