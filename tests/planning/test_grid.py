"""The settings of a parameter study, from what a person writes."""

import pytest

from refdem.core.parameters import Parameter
from refdem.errors import UsageError
from refdem.planning import grid

LENGTH = Parameter(name="length", default="1", unit="m", doc="a length", above=0)
INERTIA = Parameter(name="inertia", default="1,2,3", unit="kg m^2", doc="moments", shape=(3,))
LAW = Parameter(name="law", default="linear", unit="", doc="a law", choices=("linear", "hertz"))


@pytest.mark.parametrize(
    ("parameter", "text", "values"),
    [
        (LENGTH, "1", ["1"]),
        (LENGTH, "0.5, 1,3/2", ["0.5", "1", "3/2"]),
        # Ten tenths are 1 exactly, which sums of binary64 are not.
        (LENGTH, "0.8:1:0.1", ["4/5", "9/10", "1"]),
        (LENGTH, "1:2:2/3", ["1", "5/3"]),
        (LENGTH, "3:1:-1", ["3", "2", "1"]),
        (LENGTH, "2:2:1,5", ["2", "5"]),
        (INERTIA, "1,2,3;1,1,1", ["1,2,3", "1,1,1"]),
        (LAW, "linear,hertz", ["linear", "hertz"]),
    ],
)
def test_values_are_listed_or_a_range(parameter: Parameter, text: str, values: list[str]) -> None:
    assert grid.values_of(parameter, text) == values


@pytest.mark.parametrize(
    ("parameter", "text", "words"),
    [
        (LENGTH, "1,,2", "empty value"),
        (LENGTH, "1:2", "first:last:step"),
        (LENGTH, "1:2:0", "does not lead from the first value to the last"),
        (LENGTH, "2:1:1", "does not lead from the first value to the last"),
        (LENGTH, "1:x:1", "expected a finite decimal"),
        (LENGTH, "0:1:1/2", "expected > 0"),
        (LENGTH, "1:1e99:1e-99", f"expected at most {grid.MOST}"),
        (INERTIA, "1,2", "expected 3"),
        (INERTIA, "1:2:1", "with ; between two of them"),
        (LAW, "linear,hetz", "expected one of linear, hertz"),
        (LAW, "1:2:1", "linear,hertz"),
    ],
)
def test_values_that_make_no_sense_are_refused(parameter: Parameter, text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words) as raised:
        grid.values_of(parameter, text)
    assert f"parameter {parameter.name}" in str(raised.value)


def test_all_combinations_are_settings_the_last_parameter_fastest() -> None:
    instances, names = grid.instances("pendulum[mass=2]", ["theta0=1/2,2", "length=3,4"])
    assert names == ["theta0", "length"]
    found = [(instance.p.theta0, instance.p.length) for instance in instances]
    assert found == [(0.5, 3.0), (0.5, 4.0), (2.0, 3.0), (2.0, 4.0)]
    assert {instance.p.mass for instance in instances} == {2.0}


def test_what_is_written_in_two_ways_is_one_setting() -> None:
    instances, _ = grid.instances("pendulum", ["theta0=2,2.0,4/2"])
    assert [instance.label for instance in instances] == ["pendulum[theta0=2]"]


@pytest.mark.parametrize(
    ("label", "pairs", "words"),
    [
        ("pendulum", [], "no parameter varies"),
        ("pendulum", ["thet0=1"], "did you mean 'theta0'"),
        ("pendulum", ["theta0"], "name=value"),
        ("pendulum[theta0=1]", ["theta0=1,2"], "in one of them"),
        ("pendulum", ["theta0=0.001:1:0.001", "mass=1,2,3"], "--set gives 3000 settings"),
        ("free-rigid-body", ["inertia=1,2,3;1,1,9"], "setting inertia=1,1,9: .*triangle"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused(label: str, pairs: list[str], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        grid.instances(label, pairs)


def test_a_selection_of_cases_is_no_case() -> None:
    with pytest.raises(UsageError, match="is a selection of cases"):
        grid.instances("time-reversal", ["theta0=1"])
