"""Tests mirror the code, or lie in a home that CONTRIBUTING.md describes."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TESTS = ROOT / "tests"
BESIDE = ("ci", "validation")
"""What tests mirror beside refdem, each in a folder of its own name."""


def homes(text: str) -> set[str]:
    """Folders of tests/ in the table of CONTRIBUTING.md, for tests of more than one package."""
    return set(re.findall(r"^\| `tests/(\w+)` \| .", text, flags=re.MULTILINE))


def mirrored(folder: str, root: Path = ROOT) -> Path:
    """The folder that a folder below tests/ stands for."""
    if folder.split("/")[0] in BESIDE:
        return root / folder
    return root / "refdem" / folder


def names(folder: Path) -> set[str]:
    """Modules, kernels and packages there, and the folder itself, without a leading `_`."""
    if not folder.is_dir():
        return set()
    inside = {
        path.stem
        for path in folder.iterdir()
        if path.suffix in (".py", ".c") or (path.is_dir() and any(path.iterdir()))
    }
    found = {name.lstrip("_") for name in inside | {folder.name}}
    return found - {"", "init__", "pycache__"}


def stands_for(test: str, root: Path = ROOT) -> str | None:
    """The module, kernel or package that a file of tests is named for, or None.

    tests/core/test_store.py and tests/core/test_store_of_strangers.py stand for
    refdem/core/store.py, tests/core/test_core_names.py for the package refdem/core.
    """
    folder, _, file = test.rpartition("/")
    subject = file.removeprefix("test_").removesuffix(".py")
    fitting = [
        name
        for name in names(mirrored(folder, root))
        if subject == name or subject.startswith(f"{name}_")
    ]
    return max(fitting, key=len, default=None)


HOMES = homes((ROOT / "CONTRIBUTING.md").read_text())


def test_every_file_of_tests_mirrors_a_module_or_lies_in_a_described_home() -> None:
    files = {path.relative_to(TESTS).as_posix() for path in TESTS.rglob("test_*.py")}
    lost = {test for test in files if test.split("/")[0] not in HOMES and stands_for(test) is None}
    assert lost == set()


def test_every_described_home_is_there_and_mirrors_nothing() -> None:
    assert "properties" in HOMES
    for home in HOMES:
        assert (TESTS / home).is_dir()
        assert not mirrored(home).exists()


@pytest.mark.parametrize(
    ("test", "subject"),
    [
        ("core/test_store.py", "store"),
        ("core/test_store_of_strangers.py", "store"),
        ("core/test_core_names.py", "core"),
        ("core/test_stores.py", None),
        ("core/test_lost.py", None),
        ("core/test_hidden.py", "hidden"),
        ("core/parts/test_wheel.py", "wheel"),
        ("core/test_parts.py", "parts"),
        ("core/gone/test_store.py", None),
        ("ci/test_lines.py", "lines"),
        ("test_core.py", "core"),
    ],
)
def test_a_test_is_named_for_its_module(tmp_path: Path, test: str, subject: str | None) -> None:
    for file in ("core/store.py", "core/_hidden.py", "core/parts/wheel.c", "core/__init__.py"):
        path = tmp_path / "refdem" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    (tmp_path / "ci").mkdir()
    (tmp_path / "ci" / "lines.py").touch()
    assert stands_for(test, tmp_path) == subject


def test_helpers_are_imported_like_other_modules() -> None:
    """Not run by their path, nor found through sys.path."""
    by_path = re.compile(r"(import|from) runpy|spec_from_file_location|sys\.path.*__file__")
    files = [
        path
        for path in TESTS.rglob("*.py")
        if path != Path(__file__) and by_path.search(path.read_text())
    ]
    assert [path.relative_to(TESTS).as_posix() for path in files] == []
