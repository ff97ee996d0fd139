"""What a certified value was proved with: the digest of every file of this package that its truth
can reach.

Read from the import statements (those inside functions too), not by importing. A value is stale
once the code of one of these files changes: the syntax tree counts, without docstrings, comments
and layout, so that a sentence or a formatter makes nothing stale.
"""

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from refdem.truth.certified.parsed import Parsed, parsed

ROOT = Path(__file__).parents[2]
FOLLOWED = ("refdem.truth", "refdem.cases")
"""Packages whose files decide a value; the rest of a case's imports makes its scene."""
ALWAYS = ("core/truth.py",)


def digest_of(case: str) -> str:
    """sha256 of the names and the code of the files behind the truth of a case of refdem's own;
    empty if it is not one.
    """
    home = case_files(case)
    if home:
        return digest_of_files({*closure(home), *(ROOT / name for name in ALWAYS)})
    return ""


def digest_of_files(paths: Iterable[Path]) -> str:
    """sha256 of names and code of files of refdem."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(f"{path.relative_to(ROOT).as_posix()}\0{_content(path)}\n".encode())
    return digest.hexdigest()


def case_files(case: str) -> tuple[Path, ...]:
    """The file of a case, or those of its folder."""
    name = case.replace("-", "_")
    single = ROOT / "cases" / f"{name}.py"
    folder = ROOT / "cases" / name
    if single.is_file():
        return (single,)
    return tuple(sorted(folder.rglob("*.py")))


def closure(start: tuple[Path, ...]) -> set[Path]:
    """The files given and all that they import, directly or through others, of the packages
    followed.
    """
    closed: set[Path] = set()
    waiting = list(start)
    while waiting:
        path = waiting.pop()
        if path not in closed:
            closed.add(path)
            waiting += imports(path)
    return closed


@cache
def imports(path: Path) -> tuple[Path, ...]:
    """The files of the followed packages that a file imports."""
    _, names = _read(path)
    return tuple(
        sorted(
            {
                imported
                for name in names
                if name.startswith(FOLLOWED) and (imported := _file(name)) is not None
            }
        )
    )


def imported_names(tree: ast.Module) -> set[str]:
    """The modules that a file imports, and the names that it imports from them: those may be
    modules too.
    """
    names: set[str] = set()
    for node in statements(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Every statement below a node, at any depth; no expression holds an import."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield child
            yield from statements(child)


def _file(module: str) -> Path | None:
    """The path of the file of a module.

    None for a name inside one, or for a package, whose __init__ has a docstring only.
    """
    path = ROOT.joinpath(*module.split(".")[1:]).with_suffix(".py")
    package = path.with_suffix("") / "__init__.py"
    if path.is_file():
        return path
    if package.is_file() and module not in FOLLOWED:
        return package
    return None


def _content(path: Path) -> str:
    code, _ = _read(path)
    return code


@cache
def _read(path: Path) -> Parsed:
    """What is read from a file, or was before from the same content."""
    return parsed(path.read_bytes(), _reader(), digest_and_imports)


@cache
def _reader() -> str:
    """Everything except the content on which the result for a file depends: this code and Python's
    parser.
    """
    code = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return f"{code} {sys.implementation.name} {sys.version}"


def digest_and_imports(source: bytes) -> Parsed:
    """The digest of a file's code, and the names that it imports."""
    tree = ast.parse(source)
    code = hashlib.sha256(_tree(tree).encode()).hexdigest()
    return code, tuple(sorted(imported_names(tree)))


def code_of(source: bytes) -> str:
    """What a file of Python does, as text: its syntax tree without positions, comments, docstrings
    and other sentences on their own.

    Empty fields are left out, so that the text is the same in a version of Python that adds a field
    which the file does not use.
    """
    return _tree(ast.parse(source))


def _tree(node: object) -> str:
    if isinstance(node, list):
        return "[" + ",".join(_tree(item) for item in node if not _is_sentence(item)) + "]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = [
        (name, value) for name, value in ast.iter_fields(node) if value is not None and value != []
    ]
    return (
        type(node).__name__
        + "("
        + ",".join(f"{name}={_tree(value)}" for name, value in fields)
        + ")"
    )


def _is_sentence(node: object) -> bool:
    """A statement that is a text and nothing else."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
