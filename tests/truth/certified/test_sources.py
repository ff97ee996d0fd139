"""The digest of a case covers every file that its truth can reach, and none that it cannot."""

import ast
from pathlib import Path

import pytest

from refdem.truth.certified import sources


def reached(case: str) -> set[str]:
    return {
        path.relative_to(sources.ROOT).as_posix()
        for path in sources.closure(sources.case_files(case))
    }


def test_it_follows_imports_inside_functions_and_through_others() -> None:
    found = reached("pendulum")
    assert {
        "cases/pendulum.py",
        "truth/closed_forms/pendulum.py",
        "truth/jacobi.py",
        "truth/balls.py",
    } <= found
    assert not any("two_body" in name or "witness" in name for name in found)
    assert {"cases/_attitude.py", "truth/free_body.py"} <= reached("free-rigid-body")
    assert {"truth/validated_ivp/integration.py", "truth/validated_ivp/enclosure.py"} <= reached(
        "van-der-pol"
    )


@pytest.mark.parametrize(
    ("name", "stale"),
    [("truth/balls.py", True), ("cases/pendulum.py", True), ("truth/witness.py", False)],
)
def test_a_changed_file_changes_the_digest_of_those_that_reach_it(
    name: str, stale: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = sources.digest_of("pendulum")
    content = sources._content

    def other(path: Path) -> str:
        if path == sources.ROOT / name:
            return "changed"
        return content(path)

    monkeypatch.setattr(sources, "_content", other)
    assert (sources.digest_of("pendulum") != before) is stale


def test_a_case_of_another_package_has_no_digest() -> None:
    assert sources.digest_of("somebody-elses") == ""


PLAIN = b"""
def growth(x, y=2):
    return {"a": x + 1, "b": [y, 'c']}
LIMIT = 3
"""
SAID = b"""
'''A module that says what it does.'''
# a comment
def growth(
    x,
    y = 2,
):
    '''A docstring.'''
    return {
        'a': (x + 1),   # why
        "b": [y, "c"],
    }


LIMIT = 3
'''What it limits.'''
"""
CHANGED = [
    (b"x + 1", b"x + 2"),
    (b"x + 1", b"x - 1"),
    (b"y=2", b"y=3"),
    (b"LIMIT = 3", b"LIMIT = 3.0"),
    (b"LIMIT = 3", b"LIMIT: int = 3"),
    (b"'c'", b"'d'"),
    (b"'c'", b"b'c'"),
    (b"growth", b"growths"),
    (b"return {", b"{"),
]


def test_layout_comments_and_sentences_change_no_digest() -> None:
    assert sources.code_of(PLAIN) == sources.code_of(SAID)


@pytest.mark.parametrize(("old", "new"), CHANGED)
def test_any_change_of_code_changes_the_digest(old: bytes, new: bytes) -> None:
    assert old in PLAIN
    assert sources.code_of(PLAIN.replace(old, new)) != sources.code_of(PLAIN)


def test_a_formatter_makes_nothing_stale(tmp_path: Path) -> None:
    """Every file of the truth as ruff would write it at another width."""
    for path in (sources.ROOT / "truth").rglob("*.py"):
        other = ast.unparse(ast.parse(path.read_bytes()))
        assert sources.code_of(other.encode()) == sources.code_of(path.read_bytes()), path


def test_text_that_a_function_gives_is_code() -> None:
    assert sources.code_of(b"def f():\n    return 'a'") != sources.code_of(
        b"def f():\n    return 'b'"
    )
