"""`refdem list`: cases by the words that people type."""

import json

import pytest
from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.core.case import Canonical
from refdem.errors import UsageError


def listed(*arguments: str) -> list[str]:
    """Ids that `refdem list ... --json` prints; raises what it raises."""
    done = CliRunner().invoke(app, ["list", *arguments, "--json"], catch_exceptions=False)
    return [item["id"] for item in json.loads(done.stdout)]


def test_words_leave_the_cases_that_have_all_of_them():
    assert listed("cases", "pool") == ["billiard-break", "billiards"]
    assert listed("cases", "friction", "belt") == ["poincare-sections", "stick-slip"]
    assert {"billiards", "pendulum"} <= set(listed("cases"))


def test_a_list_as_text_has_all_parameters_and_computes_no_motion(monkeypatch):
    def lines(*arguments: str) -> list[str]:
        done = CliRunner().invoke(app, ["list", *arguments], catch_exceptions=False)
        return done.stdout.splitlines()

    (billiards,) = json.loads("\n".join(lines("billiards", "--json")))
    assert billiards["quantities"]
    monkeypatch.delattr(Canonical, "at")
    first, *others = lines("billiards")
    assert first.split(maxsplit=1) == ["billiards", billiards["title"]]
    names = [line.split()[0] for line in others]
    assert names == [parameter["name"] for parameter in billiards["parameters"]]


def test_a_word_alone_finds_cases_too():
    assert listed("friction", "belt") == ["poincare-sections", "stick-slip"]
    assert listed("heavy-top") == ["heavy-top"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cases", "teapot"), "no case matches 'teapot'"),
        (("engines", "friction"), "list engines got 'friction'; search words apply to cases only"),
        (("teapot",), "no case matches 'teapot'"),
    ],
)
def test_a_question_without_an_answer_is_refused(arguments, message):
    with pytest.raises(UsageError, match=message):
        listed(*arguments)
