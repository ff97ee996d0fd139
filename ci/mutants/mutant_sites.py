"""Where a small error can be planted: operators, comparisons, signs, constants, conditions and
statements of C and of Python.

A site is a span of bytes and what stands there instead. C is read by tree-sitter, Python by its own
parser; text, annotations, imports and preprocessor lines are left alone.

A site keeps its name while the code of the function around it stays: the name is made of the digest
of that code without comments and docstrings, and of the number of the site within the function.
"""

import ast
import copy
import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

SWAPPED = {
    "+": "-",
    "-": "+",
    "*": "/",
    "/": "*",
    "<": "<=",
    "<=": "<",
    ">": ">=",
    ">=": ">",
    "==": "!=",
    "!=": "==",
    "&&": "||",
    "||": "&&",
    "+=": "-=",
    "-=": "+=",
    "*=": "/=",
    "/=": "*=",
    "and": "or",
    "or": "and",
}
PYTHON = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.And: "and",
    ast.Or: "or",
}
ROOM = "room"
"""Kind of a mutant that gives an array room for one number more."""
KINDS = {
    "<": "comparison",
    ">": "comparison",
    "=": "comparison",
    "!": "comparison",
    "&": "condition",
    "|": "condition",
}


@dataclass(frozen=True)
class Site:
    """One possible mutant: bytes begin..end of a file become `instead`; `statement` is where the
    statement around it begins.

    `scope` is the digest of the outermost function around it, or, outside functions, of the
    statement; `number` counts the sites of that scope from 0. `is_inside` a function: what stands
    outside runs once, when its module is imported. `until` is the end of a function of C.
    """

    path: str
    kind: str
    begin: int
    end: int
    instead: bytes
    statement: int
    scope: str
    number: int = 0
    is_inside: bool = True
    until: int = 0

    def planted(self, text: bytes) -> bytes:
        """The file with the error."""
        return text[: self.begin] + self.instead + text[self.end :]

    def line(self, text: bytes) -> int:
        """The number of its line, from 1."""
        return text[: self.begin].count(b"\n") + 1

    def shown(self, text: bytes) -> str:
        """What becomes what, in words for a table."""
        before = " ".join(text[self.begin : self.end].decode().split())
        return f"{before} -> {self.instead.decode().strip() or 'nothing'}"


def sites(root: Path, path: str) -> list[Site]:
    """All sites of one file."""
    text = (root / path).read_bytes()
    if path.endswith(".py"):
        found = list(of_python(path, text))
    else:
        found = list(of_c(path, text))
    ordered = sorted(found, key=lambda site: (site.begin, site.end, site.instead))
    return numbered(ordered)


def numbered(ordered: list[Site]) -> list[Site]:
    """The sites of a file, each with its number among those of its scope.

    Scopes of equal text in one file are counted through, so that no two sites share a name.
    """
    counts: Counter[str] = Counter()
    named = []
    for site in ordered:
        named.append(replace(site, number=counts[site.scope]))
        counts[site.scope] += 1
    return named


def digest(code: str) -> str:
    """The first 16 digits of the SHA-256 of code."""
    return hashlib.sha256(code.encode()).hexdigest()[:16]


def kind_of(operator: str) -> str:
    """The kind of an operator's mutant."""
    if operator.endswith("=") and operator[0] in "+-*/":
        return "assignment"
    if operator in ("and", "or"):
        return "condition"
    return KINDS.get(operator[0], "operator")


def other_number(text: str) -> str | None:
    """Another number: 0 for 1, one more for an integer, half as much again for what has a point;

    None for what is not decimal.
    """
    try:
        value = float(text)
    except ValueError:
        return None
    if "." in text or "e" in text.lower():
        return repr(1.5 * value if value else 1.0)
    if value == 1:
        return "0"
    return str(int(value) + 1)


def of_c(path: str, text: bytes) -> Iterator[Site]:
    """Sites of a file in C."""
    import tree_sitter
    import tree_sitter_c

    tree = tree_sitter.Parser(tree_sitter.Language(tree_sitter_c.language())).parse(text)
    waiting = [(tree.root_node, -1, 0, "")]
    while waiting:
        node, statement, until, scope = waiting.pop()
        if node.type.startswith("preproc_") and node.type not in (
            "preproc_ifdef",
            "preproc_if",
            "preproc_else",
        ):
            continue
        if is_assertion(node):
            continue
        is_statement = node.type.endswith("_statement") and node.type not in (
            "compound_statement",
            "case_statement",
        )
        if is_statement or (node.type == "declaration" and until):
            statement = node.start_byte
        if statement >= 0:
            yield from of_node(path, node, statement, scope, until)
        if node.type == "function_definition" and not until:
            until = node.end_byte
            scope = digest(" ".join(tokens(node)))
        waiting += [(child, statement, until, scope) for child in node.children]


def is_assertion(node: "object") -> bool:
    """True for a call of assert: what it says holds for every call that is made, so that no test
    can see it loosened.
    """
    if node.type != "call_expression":  # type: ignore[attr-defined]
        return False
    return bool(node.children[0].text == b"assert")  # type: ignore[attr-defined]


def tokens(node: "object") -> Iterator[str]:
    """The words of C code without its comments."""
    if node.type == "comment":  # type: ignore[attr-defined]
        return
    children = node.children  # type: ignore[attr-defined]
    if not children:
        yield node.text.decode()  # type: ignore[attr-defined]
    for child in children:
        yield from tokens(child)


def of_node(path: str, node: "object", statement: int, scope: str, until: int) -> Iterator[Site]:
    """Sites of one node of C."""

    def site(kind: str, begin: int, end: int, instead: str) -> Site:
        return Site(path, kind, begin, end, instead.encode(), statement, scope, until=until)

    kind, children = node.type, node.children  # type: ignore[attr-defined]
    if kind in ("binary_expression", "assignment_expression"):
        sign = children[1]
        operator = sign.text.decode()
        if operator in SWAPPED:
            yield site(kind_of(operator), sign.start_byte, sign.end_byte, SWAPPED[operator])
    elif kind == "unary_expression" and children[0].text in (b"-", b"!"):
        yield site("sign", children[0].start_byte, children[0].end_byte, "")
    elif kind == "number_literal":
        instead = other_number(node.text.decode())  # type: ignore[attr-defined]
        is_size = node.parent.type == "array_declarator"  # type: ignore[attr-defined]
        if is_size and instead not in (None, "0"):
            yield site(ROOM, node.start_byte, node.end_byte, str(instead))  # type: ignore[attr-defined]
        elif instead is not None:
            yield site("constant", node.start_byte, node.end_byte, instead)  # type: ignore[attr-defined]
    elif kind == "expression_statement" and len(children) == 2 and not is_assertion(children[0]):
        yield site("statement", node.start_byte, node.end_byte, ";")  # type: ignore[attr-defined]


class _Python(ast.NodeVisitor):
    """Collects the sites of a module."""

    def __init__(self, path: str, text: bytes) -> None:
        self.path = path
        self.text = text
        self.lines = [0, *(at + 1 for at, byte in enumerate(text) if byte == ord("\n"))]
        self.found: list[Site] = []
        self.statement = 0
        self.scope = ""
        self.depth = 0

    def at(self, line: int, column: int) -> int:
        """The byte of a line and column of the parser."""
        return self.lines[line - 1] + column

    def span(self, node: ast.AST) -> tuple[int, int]:
        """The bytes of a node."""
        return self.at(node.lineno, node.col_offset), self.at(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]

    def note(self, kind: str, begin: int, end: int, instead: str) -> None:
        """One more site."""
        self.found.append(
            Site(
                self.path,
                kind,
                begin,
                end,
                instead.encode(),
                self.statement,
                self.scope,
                is_inside=self.depth > 0,
            )
        )

    def between(self, left: ast.AST, right: ast.AST, operator: str) -> None:
        """An operator between two operands becomes another one."""
        begin = self.span(left)[1]
        end = self.span(right)[0]
        place = self.text.find(operator.encode(), begin, end)
        if place >= 0:
            self.note(kind_of(operator), place, place + len(operator), SWAPPED[operator])

    def visit(self, node: ast.AST) -> None:
        """Knows the statement, and leaves annotations, imports, text and the heads of definitions
        alone.
        """
        if isinstance(node, ast.Import | ast.ImportFrom | ast.JoinedStr):
            return
        if isinstance(node, ast.stmt):
            self.statement = self.span(node)[0]
            if self.depth == 0 and not isinstance(node, ast.ClassDef):
                self.scope = digest(ast.dump(without_docstrings(node)))
        super().visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.depth += 1
        for part in node.body:
            self.visit(part)
        self.depth -= 1

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value:
            self.visit(node.value)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if type(node.op) in PYTHON:
            self.between(node.left, node.right, PYTHON[type(node.op)])
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        operands = [node.left, *node.comparators]
        for number, operator in enumerate(node.ops):
            if type(operator) in PYTHON:
                self.between(operands[number], operands[number + 1], PYTHON[type(operator)])
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in zip(node.values, node.values[1:], strict=False):
            self.between(left, right, PYTHON[type(node.op)])
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub | ast.Not):
            begin = self.span(node)[0]
            self.note("sign", begin, self.span(node.operand)[0], "")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            return
        begin, end = self.span(node)
        instead = other_number(self.text[begin:end].decode())
        if instead is not None:
            self.note("constant", begin, end, instead)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if type(node.op) in PYTHON:
            self.between(node.target, node.value, PYTHON[type(node.op)] + "=")
        self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            begin, end = self.span(node)
            self.note("statement", begin, end, "pass")
        if not isinstance(node.value, ast.Constant):
            self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        begin, end = self.span(node)
        self.note("statement", begin, end, "pass")


def without_docstrings(tree: ast.stmt) -> ast.stmt:
    """A copy of a statement whose definitions have no docstrings."""
    bare = copy.deepcopy(tree)
    for node in ast.walk(bare):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(node) is not None:
            del node.body[0]
    return bare


def of_python(path: str, text: bytes) -> list[Site]:
    """Sites of a file in Python."""
    visitor = _Python(path, text)
    visitor.visit(ast.parse(text))
    return visitor.found
