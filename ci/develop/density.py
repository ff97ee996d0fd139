"""Prints how densely the code is packed: ci/develop/density.py [FOLDER ...] [--worst N].

A mirror for the author of a change, never a limit: nothing fails by it. The first figure, nodes of
the syntax tree in a simple statement, does not depend on the layout; the others are counts in 1000
lines of code, without blank lines, comments and docstrings. The densest functions come last.
"""

import argparse
import ast
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean, quantiles
from typing import TypeGuard

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("refdem", "tests", "ci", "validation")
MADE = ("build", ".venv", ".venv-codes")
"""Folders that hold what tools wrote."""
SIMPLE = (ast.Assign, ast.AnnAssign, ast.AugAssign, ast.Expr, ast.Return)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
C_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
C_CHAIN = re.compile(r"[^=!<>]=[^=][^;(){}\n]*,\s*[^;(){}\n]*[^=!<>]=[^=]")
"""Two assignments of one statement, on one line or across its end."""


@dataclass
class Density:
    """What is counted over some files."""

    lines: int = 0
    sizes: list[int] = field(default_factory=list)
    """Nodes of each simple statement."""
    packed: int = 0
    """Assignments of a tuple to a tuple that swap nothing."""
    branches: int = 0
    """Conditional expressions."""
    nested: int = 0
    """Comprehensions of two loops, or with another inside."""
    comments: int = 0
    functions: list[tuple[int, str]] = field(default_factory=list)
    """The largest statement of each function, and where that function is."""

    def row(self, name: str) -> str:
        """One line of the table."""
        ninth = quantiles(self.sizes, n=10)[-1]
        counts = (self.packed, self.branches, self.nested, self.comments)
        cells = "".join(f"{1000 * count / self.lines:10.1f}" for count in counts)
        return f"{name:16}{self.lines:8}{mean(self.sizes):10.1f}{ninth:8.0f}{cells}"


def is_text(node: ast.AST) -> TypeGuard[ast.Expr]:
    """A docstring, or a string that documents what stands above it."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def is_packed(node: ast.AST) -> bool:
    """`a, b = x, y`, but no swap: there both sides have the same parts."""
    if not isinstance(node, ast.Assign) or not isinstance(node.value, ast.Tuple):
        return False
    sources = {ast.unparse(part) for part in node.value.elts}
    for target in node.targets:
        if isinstance(target, ast.Tuple):
            return {ast.unparse(part) for part in target.elts} != sources
    return False


def is_nested(node: ast.AST) -> bool:
    """A comprehension that a reader has to take apart."""
    if not isinstance(node, COMPREHENSIONS):
        return False
    below = [part for part in ast.walk(node) if isinstance(part, COMPREHENSIONS)]
    return len(node.generators) > 1 or len(below) > 1


def size(node: ast.AST) -> int:
    """Nodes of the syntax tree."""
    return sum(1 for _ in ast.walk(node))


def counted(path: Path, density: Density) -> None:
    """Adds the counts of one Python file."""
    text = path.read_text()
    tree = ast.parse(text)
    documented: set[int] = set()
    for node in ast.walk(tree):
        density.packed += is_packed(node)
        density.branches += isinstance(node, ast.IfExp)
        density.nested += is_nested(node)
        if is_text(node):
            documented.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        elif isinstance(node, SIMPLE):
            density.sizes.append(size(node))
        if isinstance(node, FUNCTIONS):
            density.functions.append((largest(node), f"{path}:{node.lineno} {node.name}"))
    with path.open("rb") as file:
        kinds = [token.type for token in tokenize.tokenize(file.readline)]
    density.comments += kinds.count(tokenize.COMMENT)
    for number, line in enumerate(text.splitlines(), 1):
        is_code = line.strip() and not line.lstrip().startswith("#")
        density.lines += bool(is_code and number not in documented)


def largest(function: ast.AST) -> int:
    """Nodes of the largest simple statement of a function."""
    inside = (node for node in ast.walk(function) if isinstance(node, SIMPLE))
    return max((size(node) for node in inside if not is_text(node)), default=0)


def files(folder: Path, *suffixes: str) -> Iterator[Path]:
    """Sources below a folder, without what tools wrote."""
    for path in sorted(folder.rglob("*")):
        if path.suffix in suffixes and not set(MADE) & set(path.parts):
            yield path


def c_row(folder: Path) -> str:
    """The line of the C code below a folder; empty where there is none."""
    texts = [C_COMMENT.sub("", path.read_text()) for path in files(folder, ".c", ".h")]
    text = "\n".join(texts)
    lines = sum(1 for line in text.splitlines() if line.strip())
    if lines == 0:
        return ""
    branches = 1000 * text.count("?") / lines
    chained = 1000 * len(C_CHAIN.findall(text)) / lines
    return f"{branches:.1f} conditional expressions, {chained:.1f} chained assignments"


def table(folders: list[Path], worst: int) -> str:
    """All folders, and the densest functions of all."""
    heads = ("packed", "branches", "nested", "comments")
    lines = [f"{'':16}{'code':>8}{'a stmt':>10}{'9/10':>8}" + "".join(f"{h:>10}" for h in heads)]
    functions: list[tuple[int, str]] = []
    for folder in folders:
        density = Density()
        for path in files(folder, ".py"):
            counted(path, density)
        if density.sizes:
            lines.append(density.row(folder.name))
        functions += density.functions
        in_c = c_row(folder)
        if in_c:
            lines.append(f"{folder.name} in C: {in_c}")
    functions.sort(reverse=True)
    lines += [f"{nodes:6} nodes in a statement: {where}" for nodes, where in functions[:worst]]
    return "\n".join(lines)


def main() -> None:
    """Prints the table of the requested folders."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path, default=[ROOT / name for name in FOLDERS])
    parser.add_argument("--worst", type=int, default=10, help="how many functions are named")
    asked = parser.parse_args()
    print(table(asked.folders, asked.worst))


if __name__ == "__main__":
    main()
