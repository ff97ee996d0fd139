"""Numbers with a name have a reason: a line below or above says what they bound and why."""

import ast
from itertools import zip_longest
from pathlib import Path

import pytest

import refdem

FOLDER = Path(refdem.__file__).parent
BESIDE = FOLDER.parent / "validation"
"""Drivers of codes, which an installed refdem has inside."""
FILES = sorted({*FOLDER.rglob("*.py"), *BESIDE.rglob("*.py")})


def is_number(node):
    """True for a number written out, or an arithmetic expression of such numbers."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    return isinstance(node, ast.BinOp) and is_number(node.left) and is_number(node.right)


def named_numbers(body):
    """Every statement of a module that names a number, with the statement after it."""
    for statement, following in zip_longest(body, body[1:]):
        if isinstance(statement, ast.Assign | ast.AnnAssign) and is_number(statement.value):
            yield statement, following


def is_text(statement):
    """True for a statement that is a string alone: the docstring of the assignment before it."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def without_reason(source):
    """Numbers of a module without a docstring below, and without a comment above or beside them."""
    lines = source.splitlines()
    for statement, following in named_numbers(ast.parse(source).body):
        above = lines[: statement.lineno - 1][-1:]
        is_commented = any(line.startswith("#") for line in above) or (
            "#" in lines[statement.end_lineno - 1]
        )
        if not is_text(following) and not is_commented:
            yield f"{statement.lineno}: {lines[statement.lineno - 1]}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(FOLDER.parent)))
def test_every_number_with_a_name_has_a_reason(path):
    assert list(without_reason(path.read_text())) == []


def test_the_rule_sees_a_number_without_a_reason():
    bare = "LIMIT = 2 * 3.5\nPLAIN: int = -1\n"
    assert list(without_reason(bare)) == ["1: LIMIT = 2 * 3.5", "2: PLAIN: int = -1"]


def test_the_rule_takes_a_docstring_and_a_comment_for_a_reason():
    with_reasons = '# As it is.\nA = 1\nB = 2\n"""Why."""\nC = 3  # so\nNAME = "no number"\n'
    assert list(without_reason(with_reasons)) == []
