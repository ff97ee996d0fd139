"""Docstrings open with a whole phrase: long enough to say what is returned, and ended by a stop."""

import ast
from pathlib import Path

import pytest

import refdem

FOLDER = Path(refdem.__file__).parent
VALIDATION = Path(__file__).parents[2] / "validation"
FILES = sorted([*FOLDER.rglob("*.py"), *VALIDATION.rglob("*.py")])

LEAST = 24
"""Characters of the shortest opening: 334 that were shorter were fragments ("Of the state.")."""

CONTINUATIONS = frozenset(
    (
        *("As", "By", "From", "In", "It", "Its", "Likewise", "Of", "On", "So", "That"),
        *("Their", "These", "Those", "To", "Up", "With", "Without", "Whose"),
    )
)
"""Words with which a phrase goes on that was begun elsewhere, by the name of the function or class.

A reader who sees the docstring alone, as in a tooltip, does not know what it is about.
"""


def openings(path):
    """First paragraph of the docstring of every class and function of a file, by its name."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.ClassDef | ast.FunctionDef):
            continue
        text = ast.get_docstring(node)
        if text is not None:
            yield f"{path.name}:{node.lineno} {node.name}", " ".join(text.split("\n\n")[0].split())


def fault(opening):
    """What is wrong with an opening; None if nothing is."""
    if len(opening) < LEAST:
        return f"has fewer than {LEAST} characters"
    if opening[-1] not in ".:?":
        return "does not end with a full stop"
    if opening.split()[0] in CONTINUATIONS:
        return "continues a phrase that is not there"
    return None


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-3:]))
def test_a_docstring_opens_with_a_whole_phrase(path):
    wrong = [f"{name}: {opening!r} {fault(opening)}" for name, opening in openings(path)]
    assert [line for line in wrong if not line.endswith(" None")] == []


@pytest.mark.parametrize(
    ("opening", "said"),
    [
        ("A.", "fewer than"),
        ("Of the state.", "fewer than"),
        ("Of the centres of the bodies, in metres.", "continues"),
        ("The centres of the bodies, in metres;", "full stop"),
        ("The centres of the bodies, in metres.", None),
    ],
)
def test_a_fragment_is_named(opening, said):
    found = fault(opening)
    assert found is None if said is None else said in found
