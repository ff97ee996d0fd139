"""No file of refdem needs itself through others: imports inside functions and imports for types
count as well.
"""

import ast
from collections.abc import Collection
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def module_of(path: Path, root: Path) -> str:
    """The name under which a file is imported."""
    parts = path.relative_to(root).with_suffix("").parts
    if parts[-1] == "__init__":
        parts = parts[:-1]
    return ".".join(parts)


def imported(tree: ast.AST, files: Collection[str]) -> set[str]:
    """The modules among `files` that a file imports, wherever it does: `from a import b` means the
    file a.b if there is one, else the file a.
    """
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import is not followed here"
            for alias in node.names:
                below = f"{node.module}.{alias.name}"
                names.add(below if below in files else str(node.module))
    return names & set(files)


def graph_of(root: Path, package: str) -> dict[str, set[str]]:
    """The modules of a package, each with those that it imports."""
    files = {module_of(path, root): path for path in (root / package).rglob("*.py")}
    graph = {}
    for name, path in files.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        graph[name] = imported(tree, files) - {name}
    return graph


def circle(graph: dict[str, set[str]]) -> list[str]:
    """The modules of one circle, the first of them again at the end; none if there is no circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_file_of_refdem_needs_itself() -> None:
    graph = graph_of(ROOT, "refdem")
    assert len(graph) > 500
    assert circle(graph) == []


@pytest.mark.parametrize(
    "back",
    [
        "from package.one import first",
        "def f():\n    from package import one\n    return one",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import package.one",
    ],
)
def test_a_circle_is_found_wherever_it_is_closed(tmp_path: Path, back: str) -> None:
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "__init__.py").write_text("")
    (tmp_path / "package" / "one.py").write_text("from package.two import second\n")
    (tmp_path / "package" / "two.py").write_text(back)
    (tmp_path / "package" / "three.py").write_text("from package import one, two\n")
    found = circle(graph_of(tmp_path, "package"))
    assert set(found) == {"package.one", "package.two"}
