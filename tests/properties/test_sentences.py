"""The sentences of findings: subject first, what was measured, what it is compared with, why."""

import ast
from pathlib import Path

import numpy as np
import pytest

import refdem
from refdem.core.judgement import judged, order_statement

CHECKS = sorted((Path(refdem.__file__).parent / "checks").glob("*.py"))
LISTED = "by pairs of levels: 3.98, 4.03"


def said(value, **more):
    """The sentence of a finding with bound 0.2."""
    given = {"unit": "1", "what": "The error of x", "basis": "a reason"} | more
    return judged(check="error", quantity="x", value=value, bound=0.2, **given).sentence


@pytest.mark.parametrize(
    ("value", "unit", "sentence"),
    [
        (0.0, "1", "The error of x is 0, within the bound 0.2. Basis: a reason."),
        (0.1, "m", "The error of x is 0.1 m, within the bound 0.2 m. Basis: a reason."),
        (0.3, "m", "The error of x is 0.3 m, above the bound 0.2 m. Basis: a reason."),
        (np.nan, "m", "The error of x is not a number (the bound is 0.2 m). Basis: a reason."),
    ],
)
def test_a_value_is_given_with_its_unit_and_with_its_bound(value, unit, sentence):
    assert said(value, unit=unit) == sentence


@pytest.mark.parametrize(
    ("seen", "deficit", "rest"),
    [
        (4.03, 0.0, "meets the claimed 4 (tolerance 0.2)"),
        (3.5, 0.1, "approaches the claimed 4 (extrapolated deficit 0.1, tolerance 0.2)"),
        (3.5, 0.5, "is below the claimed 4 by 0.5 (tolerance 0.2)"),
    ],
)
def test_an_order_is_compared_with_the_claimed_one(seen, deficit, rest):
    assert order_statement(seen, 4.0, deficit, 0.2, LISTED) == (
        f"Observed order {seen:.2f} ({LISTED}) {rest}"
    )


def test_a_statement_replaces_the_comparison():
    assert said(0.0, statement="The run is bit-equal") == "The run is bit-equal. Basis: a reason."


def openings(path):
    """The literal beginnings of every `what` and `statement` that a check gives to a finding."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.keyword) or node.arg not in ("what", "statement"):
            continue
        text = node.value
        if isinstance(text, ast.JoinedStr):
            text = text.values[0]
        if isinstance(text, ast.Constant):
            yield text.value


@pytest.mark.parametrize("path", CHECKS, ids=lambda path: path.stem)
def test_the_subject_of_a_finding_is_a_noun_phrase_with_a_capital(path):
    """A question as a subject (what, how far, whether) makes a riddle of the finding."""
    for opening in openings(path):
        assert opening[0].isupper(), opening
        assert opening.split()[0] not in ("What", "How", "Whether"), opening
