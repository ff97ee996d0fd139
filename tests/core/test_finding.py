"""Findings in the order in which a person should read them."""

import math

import pytest

from refdem.core.finding import Finding, Record, worst_first


def finding(quantity, outcome, value=None, bound=1.0):
    return Finding(
        check="error", quantity=quantity, outcome=outcome, sentence="said", value=value, bound=bound
    )


@pytest.mark.parametrize(
    ("value", "margin"),
    [(0.1, 1.0), (10.0, -1.0), (0.0, math.inf), (math.nan, -math.inf), (math.inf, -math.inf)],
)
def test_a_margin_is_in_decades_and_what_is_no_number_has_the_worst(value, margin):
    assert finding("x", "fail", value).margin == margin


def test_the_worst_comes_first_by_outcome_and_then_by_margin():
    found = (
        finding("held", "pass", 0.1),
        finding("near", "fail", 2.0),
        finding("broken", "error"),
        finding("far", "fail", math.nan),
    )
    record = Record(
        case="c",
        label="c",
        parameters={},
        engine="e",
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=found,
    )
    assert [f.quantity for _, f in worst_first([record])] == ["broken", "far", "near", "held"]
