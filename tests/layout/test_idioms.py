"""Messages and docstrings are in the words of the field: no idioms that halt a new reader."""

import ast
import re
from pathlib import Path

import pytest

import refdem

FOLDER = Path(refdem.__file__).parent
FILES = sorted(FOLDER.rglob("*.py"))

IDIOMS = (
    "as they like",
    "both came",
    "came without",
    "dear to prove",
    "did not come",
    "forgotten where",
    "in the open",
    "its values would be denied",
    "may not end next time",
    "no body came",
    "not there any more",
    "weather of the machine",
)
"""Phrases in place of which a message says what was given, what was expected and what to do."""


def idioms(source):
    """The idioms in the string literals of a module, docstrings among them, with their lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = re.sub(r"\s+", " ", node.value).lower()
            for idiom in IDIOMS:
                if idiom in text:
                    yield f"line {node.lineno}: {idiom!r}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-3:]))
def test_strings_have_no_idioms(path):
    assert list(idioms(path.read_text())) == []


@pytest.mark.parametrize(
    "source",
    [
        'raise ValueError(f"--{name} did not come; expected it")',
        '"""Bodies turn as they\n    like."""',
        'MESSAGE = "--step and --stride " "both came"',
        '"""Maps In the open."""',
    ],
)
def test_an_idiom_is_found_in_any_string_however_it_is_broken(source):
    (found,) = idioms(source)
    assert found.startswith("line 1: ")


def test_comments_and_other_words_are_no_idioms():
    assert list(idioms('# It did not come.\nTEXT = "got both; expected one of them"')) == []
