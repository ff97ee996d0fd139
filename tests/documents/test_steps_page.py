"""reports/steps.md: made by the command that it names, each number still what it says."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from refdem.cli.app import app

PAGE = Path("reports/steps.md")


def cells(text: str) -> list[list[str]]:
    """The rows of the first table."""
    lines = text.partition("\n## ")[0].splitlines()
    return [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")][2:]


def test_the_page_is_what_its_command_makes(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / PAGE).read_text()
    command = re.search(r"`refdem (advise [^`]+) --out reports`", page)
    assert command is not None
    done = CliRunner().invoke(app, [*shlex.split(command[1]), "--out", str(tmp_path)])
    assert done.exit_code == 0
    made = (tmp_path / "steps.md").read_text()
    assert page.partition("\n## ")[2] == made.partition("\n## ")[2]
    old, new = cells(page), cells(made)
    assert [row[:5] for row in old] == [row[:5] for row in new]
    for was, now in zip(old, new, strict=True):
        # One digit is shown, and another processor may round it to the next.
        assert float(now[5]) == pytest.approx(float(was[5]), rel=0.5)
