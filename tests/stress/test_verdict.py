"""From findings to verdicts, breaking points and promises."""

import pytest

from refdem.core.finding import Finding, Outcome, Record
from refdem.errors import UsageError
from refdem.stress.measures.parameters import Parameters
from refdem.stress.record import MethodSweep, Point, Verdict
from refdem.stress.sweep import Sweep
from refdem.stress.verdict import number, point_of, ratio, summarised, words

POINTS = ("1", "1e2", "1e4", "1e6")
BARE = MethodSweep(
    battery="b",
    sweep="l",
    label="c",
    along="x",
    engine="e",
    version="1",
    method="m",
    is_reference=True,
    points=[],
)


def sweep(promised: str = "1e4", **more: object) -> Sweep:
    return Sweep(
        name="l",
        case="pendulum",
        along="x",
        points=POINTS,
        measure=Parameters(lambda x: {}),
        promised=promised,
        basis="why",
        **more,
    )


def result(*verdicts: Verdict, promised: str = "1e4", **more: object) -> MethodSweep:
    points = [
        Point(point=point, verdict=verdict) for point, verdict in zip(POINTS, verdicts, strict=True)
    ]
    return summarised(BARE, sweep(promised, **more), points, is_required=True)


def judged(*found: tuple[Outcome, float | None]) -> Record:
    findings = tuple(
        Finding(check=f"c{k}", quantity="q", outcome=outcome, sentence="s", value=value, bound=1.0)
        for k, (outcome, value) in enumerate(found)
    )
    return Record(
        case="c",
        label="c",
        parameters={},
        engine="e",
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=findings,
    )


def test_a_method_holds_to_the_last_point_before_the_first_that_breaks() -> None:
    found = result("pass", "pass", "fail", "pass")
    assert (found.holds, found.breaks, found.kept) == (100.0, 1e4, False)
    assert words(found) == ("100", "fail at 1e4, but holds at 1 beyond")


def test_what_could_not_be_proved_is_no_breaking_point_and_no_pass() -> None:
    found = result("pass", "pass", "undecided", "undecided")
    assert (found.holds, found.breaks, found.kept) == (100.0, None, False)


@pytest.mark.parametrize("verdict", ["not run", "unsupported"])
def test_a_promise_whose_points_were_left_out_is_neither_kept_nor_broken(verdict: Verdict) -> None:
    assert result("pass", "pass", verdict, verdict).kept is None


def test_a_promise_ends_where_it_says() -> None:
    assert result("pass", "pass", "pass", "fail").kept is True
    assert (
        result("pass", "pass", "fail", "fail", exempt={"m": ("1e2", "it is for slow ones")}).kept
        is True
    )
    assert (
        result("pass", "fail", "fail", "fail", exempt={"m": ("1e2", "it is for slow ones")}).kept
        is False
    )


def test_an_engine_that_promised_nothing_is_held_to_nothing() -> None:
    points = [Point(point=point, verdict="fail") for point in POINTS]
    assert summarised(BARE, sweep(), points, is_required=False).kept is None


def test_a_promise_without_a_reason_or_beyond_the_sweep_is_refused() -> None:
    for promised, basis in (("1e4", ""), ("1e5", "why")):
        with pytest.raises(UsageError, match="expected one of its points, with a basis"):
            Sweep(
                name="l",
                case="pendulum",
                along="x",
                points=POINTS,
                measure=Parameters(lambda x: {}),
                promised=promised,
                basis=basis,
            )


@pytest.mark.parametrize(
    ("found", "verdict", "value"),
    [
        ([("pass", 0.1), ("pass", 0.9)], "pass", 0.9),
        ([("pass", 0.9), ("fail", 2.0), ("fail", 30.0)], "fail", 30.0),
        ([("pass", 0.1), ("fail", float("nan"))], "fail", None),
        ([("pass", 0.1), ("error", None)], "error", None),
        ([("undecided", None), ("pass", 0.2)], "pass", 0.2),
        ([("undecided", None)], "undecided", None),
        ([("unsupported", None)], "unsupported", None),
    ],
)
def test_a_point_is_as_bad_as_its_worst_finding(
    found: list[tuple[Outcome, float | None]], verdict: Verdict, value: float | None
) -> None:
    point = point_of("1", judged(*found))
    assert point.verdict == verdict
    assert value is None or point.value == value


def test_a_value_over_a_bound_of_zero_is_drawn_above_it_unless_it_is_zero() -> None:
    assert ratio(Point(point="1", verdict="fail", value=1.0, bound=0.0)) == float("inf")
    assert ratio(Point(point="1", verdict="pass", value=0.0, bound=0.0)) == 0
    assert ratio(Point(point="1", verdict="error")) is None


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (0.99, "0.99"), (2.0, "2"), (1e8, "1e8"), (2.0**27, "1.3e8"), (1e-12, "1e-12")],
)
def test_points_have_two_digits(value: float, shown: str) -> None:
    assert number(value) == shown
