"""What a certified value was proved with: the digest of every file of this package that its truth can reach.

Read from the import statements (those inside functions too), not by importing: a value is stale once one of these files changes.
"""

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLLOWED = ("refdem.truth", "refdem.cases")
"""Packages whose files decide a value; the rest of a case's imports makes its scene."""
ALWAYS = ("core/truth.py",)


def digest_of(case: str) -> str:
    """sha256 of the names and contents of the files behind the truth of a case of refdem's own; empty if it is not one."""
    home = case_files(case)
    return digest_of_files({*closure(home), *(ROOT / name for name in ALWAYS)}) if home else ""


def digest_of_files(paths: Iterable[Path]) -> str:
    """sha256 of names and contents of files of refdem."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(f"{path.relative_to(ROOT).as_posix()}\0{_content(path)}\n".encode())
    return digest.hexdigest()


def case_files(case: str) -> tuple[Path, ...]:
    """The file of a case, or those of its folder."""
    name = case.replace("-", "_")
    single, folder = ROOT / "cases" / f"{name}.py", ROOT / "cases" / name
    return (single,) if single.is_file() else tuple(sorted(folder.rglob("*.py")))


def closure(start: tuple[Path, ...]) -> set[Path]:
    """The files given and all that they import, directly or through others, of the packages followed."""
    found: set[Path] = set()
    waiting = list(start)
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += imports(path)
    return found


@cache
def imports(path: Path) -> tuple[Path, ...]:
    """The files of the followed packages that a file imports."""
    names: set[str] = set()
    for node in statements(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return tuple(sorted({found for name in names if name.startswith(FOLLOWED) and (found := _file(name)) is not None}))


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Every statement below a node, at any depth; no expression holds an import."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield child
            yield from statements(child)


def _file(module: str) -> Path | None:
    """The file of a module; None for a name inside one, or for a package, whose __init__ says nothing but what it is."""
    path = ROOT.joinpath(*module.split(".")[1:]).with_suffix(".py")
    package = path.with_suffix("") / "__init__.py"
    return path if path.is_file() else package if package.is_file() and module not in FOLLOWED else None


@cache
def _content(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
