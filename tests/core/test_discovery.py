"""Discovery: cases by the words that people type."""

import pytest

from refdem.core import discovery
from refdem.core.discovery import cases_about
from refdem.errors import UsageError


@pytest.mark.parametrize(
    ("text", "case"),
    [
        ("satellite", "two-body-orbit"),
        ("satellite", "free-rigid-body"),
        ("drone", "free-rigid-body"),
        ("gear", "pendulum-wheel-mass"),
        ("billiard", "billiard-break"),
        ("friction", "coulomb-oscillator"),
        ("bounce", "bouncing-ball"),
        ("bouncing ball", "bouncing-ball"),
        ("top", "heavy-top"),
        ("gyroscope", "heavy-top"),
        ("Gyroscopes", "neglected-gyroscopic"),
        ("orbit", "two-body-orbit"),
        ("orbiting", "two-body-orbit"),
        ("colliding", "hard-wall"),
        ("reversible", "time-reversal"),
    ],
)
def test_a_word_that_people_type_finds_the_case(text, case):
    assert case in cases_about(text)


def test_a_case_has_all_of_several_words():
    assert cases_about("friction belt") == ["poincare-sections", "stick-slip"]
    assert cases_about("friction nowhere") == []


@pytest.mark.parametrize("text", ["", " -- "])
def test_a_text_without_words_finds_nothing(text):
    assert cases_about(text) == []


@pytest.mark.parametrize("name", discovery.own_names("cases"))
def test_every_case_gives_words_that_its_name_does_not_have(name):
    case = discovery.case(name)
    assert all(word.isalpha() and word.islower() for word in case.words)
    assert set(case.words) - set(name.split("-"))


def test_an_unknown_case_is_told_what_is_about_it():
    with pytest.raises(UsageError, match=r"cases that are about it: .*two-body-orbit"):
        discovery.case("satellite")
