"""What counts as worse than the baseline, and what is only round-off."""

import msgspec
import pytest

from refdem.core.finding import Record
from refdem.core.judgement import judged
from refdem.gate.baseline import Accepted
from refdem.gate.compare import compared


def outcome(value, before, bound, *, constant=None, noise=0.0):
    finding = judged(
        check="error", quantity="x", value=value, bound=bound, unit="1", basis="b", what="w"
    )
    finding = msgspec.structs.replace(finding, constant_seen=constant)
    record = Record(
        case="c",
        label="c",
        parameters={},
        engine="e",
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=(finding,),
    )
    accepted = Accepted(
        id="c/e/m/error/x",
        outcome="pass",
        value=before,
        constant=None if constant is None else before,
    )
    (found,) = compared([record], {accepted.id: accepted}, lambda record, finding: noise)
    return found.findings[0].outcome


@pytest.mark.parametrize(
    ("value", "before", "bound", "more", "expected"),
    [
        (2e-3, 1e-3, 1e-2, {}, "worse"),
        (1.4e-3, 1e-3, 1e-2, {}, "pass"),
        (2e-3, 1e-3, 1e-2, {"noise": 1e-3}, "pass"),
        (2e-15, 5.6e-16, 1e-12, {}, "pass"),
        (2e-15, 5.6e-16, 1e-14, {}, "worse"),
        (1e-6, 1e-3, 1.0, {"constant": 2e-3}, "worse"),
        (2e-2, 1e-3, 1e-2, {}, "fail"),
    ],
)
def test_worse_is_a_constant_that_grew_or_a_value_near_its_bound(
    value, before, bound, more, expected
):
    assert outcome(value, before, bound, **more) == expected
