"""The index of ci names every file of its folders, and what the Makefile has."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CI = ROOT / "ci"
INDEX = CI / "README.md"
CELL = r"[^ |][^|]*"
ROW = re.compile(rf"^\| `([^`]+)` \| {CELL} \| {CELL} \|$", flags=re.MULTILINE)
"""A file, what it does, and who runs it."""


def indexed(text: str) -> list[str]:
    """Files of the tables, each below the folder of its section, in the order of the index."""
    found = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        folder = section.splitlines()[0]
        names = ROW.findall(section)
        found += [f"{folder}/{name}" for name in names]
    return found


def files(folder: Path) -> list[str]:
    """Files below a folder but the index itself and what Python and tools leave there, sorted."""
    return sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file()
        and path != folder / "README.md"
        and not re.search(r"/(__pycache__|\.)", path.relative_to(folder.parent).as_posix())
    )


def test_the_index_names_every_file_once_in_order_and_nothing_else() -> None:
    assert indexed(INDEX.read_text()) == files(CI)


def test_every_target_of_make_that_the_index_names_is_there() -> None:
    asked = set(re.findall(r"`make ([\w-]+)`", INDEX.read_text()))
    there = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    assert "mutants" in asked
    assert asked <= set(there)


def test_every_tool_that_the_makefile_calls_is_said_to_be_called_by_make() -> None:
    """Environments are described in words."""
    recipes = re.findall(r"^\t.*", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    called = set(re.findall(r"\bci/([\w./-]+)", "\n".join(recipes)))
    text = INDEX.read_text()
    assert len(called) > 10
    for tool in called:
        name = tool.partition("/")[2]
        (row,) = re.findall(rf"^\| `{re.escape(name)}` \|.*", text, flags=re.MULTILINE)
        assert "`make " in row or "the Makefile's" in row, tool


@pytest.mark.parametrize(
    "row",
    [
        "",
        "| `tool` | works | `make tool` |\n| `gone` | worked | by hand |\n",
        "| `tool` | works |   |\n",
    ],
)
def test_a_row_that_lacks_something_is_seen(tmp_path: Path, row: str) -> None:
    (tmp_path / "part" / "__pycache__").mkdir(parents=True)
    (tmp_path / "part" / "__pycache__" / "tool.pyc").touch()
    (tmp_path / "part" / "tool").touch()
    (tmp_path / "README.md").touch()
    head = "# Tools\n\n## part\n\n| file | what it does | who runs it |\n|---|---|---|\n"
    assert files(tmp_path) == ["part/tool"]
    assert indexed(head + "| `tool` | works | `make tool` |\n") == ["part/tool"]
    assert indexed(head + row) != ["part/tool"]
