"""Reasons of a report: where nothing was decided, sentences that open alike are one reason; what
failed stands each for itself.
"""

import pytest

from refdem.report.contents import contents_of
from refdem.report.reasons import reasons_by_outcome
from tests.report import synthetic

BLIND = "Undecided: the allowed error hides the motion; use smaller steps."


def reasons(outcome, *sentences):
    """The reasons of a record in which one finding says each sentence."""
    findings = [synthetic.said("error", outcome, sentence) for sentence in sentences]
    record = synthetic.record("swing", "swing", "alpha", "euler", *findings)
    return reasons_by_outcome(contents_of([record]))[outcome]


def headings(found):
    """What a reader sees of reasons before they are unfolded."""
    return [reason.heading for reason in found]


def test_sentences_that_open_alike_are_one_reason_with_what_each_says_beyond_it():
    (one,) = reasons("undecided", f"{BLIND} It is 0.25 of 3e-07.", f"{BLIND} It is 2 of 0.5.")
    assert one.heading == BLIND
    assert list(one.details) == ["It is 0.25 of 3e-07.", "It is 2 of 0.5."]
    assert one.count == 2


def test_a_reason_may_say_no_more_than_its_heading():
    (one,) = reasons("undecided", BLIND)
    assert (one.heading, list(one.details)) == (BLIND, [""])


def test_reasons_that_hold_for_more_findings_come_first():
    found = reasons("undecided", "Undecided: a.", "Undecided: b.", "Undecided: b.")
    assert headings(found) == ["Undecided: b.", "Undecided: a."]


@pytest.mark.parametrize("outcome", ["fail", "expected", "unsupported"])
def test_each_sentence_that_says_something_else_is_a_reason_of_its_own(outcome):
    sentences = ["The error of x is 0.1. Basis: a.", "The error of x is 0.2. Basis: a."]
    assert headings(reasons(outcome, *sentences)) == sentences
