"""docs/glossary.md: every outcome, problem and sheet is listed, and every class it names exists."""

import importlib
from pathlib import Path
from typing import get_args

import pytest

from refdem.core.ensemble import Ensemble
from refdem.core.finding import Outcome, Sheet
from refdem.core.problem_kinds import Problem
from refdem.core.static_problems import Solid
from refdem.stress.record import Verdict

TEXT = (Path(__file__).parents[2] / "docs/glossary.md").read_text()
CELLS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in TEXT.splitlines()]
ROWS = [(*cells, "")[:3] for cells in CELLS if cells and cells[1] not in ("meaning", "---")]
NAMED = [place.strip("`") for _, _, place in ROWS if place]


def subclasses(kind):
    """Every concrete class below a class, however deep."""
    for each in kind.__subclasses__():
        yield from subclasses(each)
        if not getattr(each, "__abstractmethods__", None):
            yield each


@pytest.mark.parametrize("place", NAMED)
def test_every_class_that_is_named_exists(place):
    module, name = place.rsplit(".", 1)
    assert isinstance(getattr(importlib.import_module(f"refdem.{module}"), name), type)


@pytest.mark.parametrize("outcome", get_args(Outcome))
def test_every_outcome_is_listed(outcome):
    assert f"| `{outcome}` |" in TEXT


def test_no_outcome_is_listed_that_does_not_exist():
    assert {word.strip("`") for word, _, _ in ROWS if word.startswith("`")} == set(
        get_args(Outcome)
    )


def test_every_verdict_of_a_stress_test_is_an_outcome_or_not_run():
    assert set(get_args(Verdict)) <= {*get_args(Outcome), "not run"}


def test_every_problem_and_every_sheet_is_listed():
    kinds = {each.__name__ for each in subclasses(Problem) if each.__module__.startswith("refdem.")}
    sheets = {each.__name__ for each in get_args(Sheet)}
    assert {Ensemble.__name__, Solid.__name__} <= kinds
    assert kinds | sheets <= {place.rsplit(".", 1)[-1] for place in NAMED}


def test_a_term_is_listed_once_and_explained_by_a_sentence():
    terms = [term for term, _, _ in ROWS]
    assert len(terms) == len(set(terms))
    for term, meaning, _ in ROWS:
        assert meaning[0].isupper(), term
        assert meaning.endswith("."), term
