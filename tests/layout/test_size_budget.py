"""The size budget: a function fits on a screen, a file in a head. Exceptions are in one table, each with its reason."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FUNCTION, FILE, CASE, ADAPTER = 40, 300, 80, 120
FOLDERS = ("refdem", "validation", "tests", "ci")

EXCEPTIONS: dict[str, tuple[int, str]] = {
    "refdem/kernels/kernels.h": (480, "declarations alone, a section a family: the glue of all families is generated from it"),
}
"""`path` or `path::function` -> lines allowed, and why."""


def python_files() -> list[Path]:
    """Every Python file of the project."""
    return sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py") if "__pycache__" not in path.parts)


def budget(name: str) -> int:
    """Lines that a file may have."""
    return CASE if name.startswith("refdem/cases/") else ADAPTER if name.startswith("refdem/engines/") else FILE


def functions(text: str) -> dict[str, int]:
    """Lines of every function, by dotted name, decorators not counted."""
    found: dict[str, int] = {}

    def visit(node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            name = f"{prefix}.{child.name}".lstrip(".") if isinstance(child, ast.FunctionDef | ast.ClassDef) else prefix
            if isinstance(child, ast.FunctionDef):
                found[name] = (child.end_lineno or child.lineno) - child.lineno + 1
            visit(child, name)

    visit(ast.parse(text), "")
    return found


def sizes() -> dict[str, tuple[int, int]]:
    """Lines and budget of every file and of every Python function."""
    found = {}
    for path in python_files():
        name, text = path.relative_to(ROOT).as_posix(), path.read_text()
        found[name] = (text.count("\n"), budget(name))
        found |= {f"{name}::{function}": (lines, FUNCTION) for function, lines in functions(text).items()}
    for path in sorted((ROOT / "refdem" / "kernels").glob("*.[ch]")):
        found[path.relative_to(ROOT).as_posix()] = (path.read_text().count("\n"), FILE)
    return found


def test_every_file_and_function_is_within_its_budget() -> None:
    beyond = [
        f"{name}: {lines} lines, budget {EXCEPTIONS.get(name, (allowed,))[0]}"
        for name, (lines, allowed) in sizes().items()
        if lines > EXCEPTIONS.get(name, (allowed,))[0]
    ]
    assert not beyond, "\n".join(beyond)


def test_every_exception_is_needed_and_says_why() -> None:
    measured = sizes()
    for name, (allowed, reason) in EXCEPTIONS.items():
        assert name in measured, f"{name} is gone: remove its exception"
        assert measured[name][0] > measured[name][1], f"{name} is within the ordinary budget: remove its exception"
        assert allowed > measured[name][1]
        assert len(reason.split()) >= 3


@pytest.mark.parametrize(("lines", "within"), [(FUNCTION, True), (FUNCTION + 1, False)])
def test_a_function_is_measured_from_def_to_its_last_line(lines: int, within: bool) -> None:
    text = "class A:\n    @property\n    def f(self):\n" + "        x = 1\n" * (lines - 1)
    assert (functions(text)["A.f"] <= FUNCTION) is within
