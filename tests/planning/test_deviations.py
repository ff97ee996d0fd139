"""Expected deviations excuse what lies in their range, and nothing else."""

import msgspec
import pytest

from refdem.core.deviation import Deviation
from refdem.core.finding import Record
from refdem.core.judgement import judged
from refdem.planning.deviations import applied

DEVIATION = Deviation(
    case="pendulum",
    parameters="",
    method="rk4",
    check="error",
    quantity="x",
    versions="4.*",
    low=0.1,
    high=0.5,
    reason="it is soft",
)


def record(value, label="pendulum", version="4.0.0", check="error", quantity="x"):
    finding = judged(
        check=check, quantity=quantity, value=value, bound=0.05, unit="1", basis="b", what="w"
    )
    return Record(
        case="pendulum",
        label=label,
        parameters={},
        engine="e",
        version=version,
        method="rk4",
        is_reference=False,
        runs=(),
        findings=(finding,),
    )


@pytest.mark.parametrize(
    ("value", "outcome"),
    [
        (0.2, "expected"),
        (0.1, "expected"),
        (0.6, "fail"),
        (0.07, "fail"),
        (0.01, "stale"),
        (float("nan"), "fail"),
    ],
)
def test_a_value_is_excused_only_inside_the_range(value, outcome):
    finding = applied(record(value), [DEVIATION]).findings[0]
    assert finding.outcome == outcome
    assert "it is soft" in finding.sentence


@pytest.mark.parametrize(
    ("label", "outcome"),
    [
        ("pendulum", "expected"),
        ("pendulum[theta0=2]", "expected"),
        ("pendulum[theta0=3]", "fail"),
        ("pendulum[theta0=2 samples=8]", "fail"),
    ],
)
def test_a_deviation_names_several_settings(label, outcome):
    several = msgspec.structs.replace(DEVIATION, parameters=("", "theta0=[12]"))
    assert applied(record(0.2, label=label), [several]).findings[0].outcome == outcome


@pytest.mark.parametrize(
    "other",
    [{"label": "pendulum[theta0=2]"}, {"version": "5.0"}, {"check": "order"}, {"quantity": "y"}],
)
def test_a_deviation_speaks_only_of_what_it_names(other):
    assert applied(record(0.2, **other), [DEVIATION]).findings[0].outcome == "fail"
