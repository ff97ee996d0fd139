"""`refdem new` writes well-formed files under any name that it takes, and refuses other names."""

import ast
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from refdem.cli import skeleton

Run = Callable[..., "subprocess.CompletedProcess[str]"]
KINDS = sorted(skeleton.SKELETONS)
LONG = "abcdefg-hijk-1mno-pqrstu"
NAMES = ["ab", "bouncing-ball", LONG]


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """What a tree of refdem is known by, and the folders that get files."""
    for mark in skeleton.MARKS:
        if Path(mark).suffix:
            (tmp_path / mark).touch()
        else:
            (tmp_path / mark).mkdir(parents=True)
    for kind in skeleton.SKELETONS.values():
        for place in kind.files.values():
            (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
    return tmp_path


def files(tree: Path) -> set[Path]:
    return {path for path in tree.rglob("*") if path.is_file()}


def test_the_longest_name_is_among_those_that_are_tried() -> None:
    assert len(LONG) == skeleton.LONGEST


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_is_told_and_is_well_formed(
    kind: str, name: str, tree: Path, command_line: Run
) -> None:
    before = files(tree)
    done = command_line("new", kind, name, "--package", str(tree))
    assert done.returncode == 0, done.stderr
    new = files(tree) - before
    assert {Path(line) for line in re.findall(r"^wrote (.*)$", done.stdout, re.MULTILINE)} == new
    assert len(new) == len(skeleton.SKELETONS[kind].files)
    for path in new:
        text = path.read_text()
        assert max(map(len, text.splitlines())) <= skeleton.COLUMNS, path
        assert "$" not in text
        if path.suffix == ".py":
            ast.parse(text)
    folder = {"kernel": "solvers", "element": "scene/elements"}.get(kind, f"{kind}s")
    next_one = f"pytest tests/{folder}/test_"
    assert next_one + name.replace("-", "_") in done.stdout


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_written_twice_or_over_anything(
    kind: str, tree: Path, command_line: Run
) -> None:
    assert command_line("new", kind, "one", "--package", str(tree)).returncode == 0
    for path in files(tree):
        path.write_text("mine")
    before = files(tree)
    done = command_line("new", kind, "one", "--package", str(tree))
    assert done.returncode == 2
    assert f"there is a {kind} 'one' already" in done.stderr
    assert files(tree) == before
    assert all(path.read_text() == "mine" for path in before)


@pytest.mark.parametrize("kind", KINDS)
def test_one_file_in_the_way_keeps_all_from_being_written(
    kind: str, tree: Path, command_line: Run
) -> None:
    *_, last = skeleton.SKELETONS[kind].files.values()
    (tree / last.format(name="one", module="one")).write_text("mine")
    before = files(tree)
    done = command_line("new", kind, "one", "--package", str(tree))
    assert done.returncode == 2
    assert "exists already" in done.stderr
    assert files(tree) == before


@pytest.mark.parametrize(
    "name",
    [
        *("", "a", "1st", "Ball", "two balls", "two_balls", "-x", "x-", "x--y", "../x", "x.py"),
        *("é1", "class", "external", LONG + "x"),
    ],
)
def test_a_name_that_cannot_be_one_is_refused(name: str, tree: Path, command_line: Run) -> None:
    before = files(tree)
    done = command_line("new", "case", "--package", str(tree), "--", name)
    assert done.returncode == 2
    assert re.search(r"the name '.*' (cannot be used|is reserved)", done.stderr)
    assert files(tree) == before


def test_a_kind_that_there_is_not_is_refused(tree: Path, command_line: Run) -> None:
    done = command_line("new", "solver", "one", "--package", str(tree))
    assert done.returncode == 2
    assert "'solver'; expected one of case, check, element, engine, kernel" in done.stderr


def test_a_folder_that_is_no_tree_is_refused(tmp_path: Path, command_line: Run) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        done = command_line("new", "case", "one", "--package", str(folder))
        assert done.returncode == 2
        assert f"{folder} is not a source tree of refdem" in done.stderr
    assert files(tmp_path) == set()


def test_a_folder_that_no_system_can_have_is_refused(command_line: Run) -> None:
    done = command_line("new", "case", "one", "--package", "x" * 5000)
    assert done.returncode == 2
    assert "--package 'xxx" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_case_in_a_folder_of_its_own_and_a_method_in_another_file_are_taken(
    tree: Path, command_line: Run
) -> None:
    (tree / "refdem/cases/many").mkdir()
    (tree / "refdem/solvers/other.py").write_text('claims = Method(name="one")')
    for kind, name in (("case", "many"), ("kernel", "one")):
        done = command_line("new", kind, name, "--package", str(tree))
        assert done.returncode == 2
        assert "choose another" in done.stderr
