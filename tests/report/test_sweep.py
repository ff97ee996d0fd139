"""The table of a parameter study, from records made by hand."""

import json

import msgspec
import pytest

from refdem.core.finding import CaseSheet, Finding, Level, Outcome, Record
from refdem.report import sweep
from refdem.report.contents import contents_of
from refdem.report.sweep import Point

SETTING = {"theta0": "2"}


def finding(outcome: Outcome, check: str = "error", levels: tuple[Level, ...] = ()) -> Finding:
    """A finding whose sentence names its outcome."""
    return Finding(
        check=check, quantity="x", outcome=outcome, sentence=f"It is {outcome}.", levels=levels
    )


def level(step: float, error: float) -> Level:
    """A level that took 4 s."""
    return Level(level=step, error=error, bound=0.5, seconds=4.0, counts=True)


def points(*findings: Finding, engine: str = "mydem") -> list[Point]:
    """The points of one record with these findings, of a motion that lasts 8 s."""
    record = Record(
        case="swing",
        label="swing[theta0=2]",
        parameters=SETTING,
        engine=engine,
        version="1",
        method="leapfrog",
        is_reference=False,
        runs=(),
        findings=findings,
    )
    bare = contents_of([record]).cases[0]
    sheet: CaseSheet = msgspec.structs.replace(bare, scales={"T": 8.0, "tau": 1.0})
    return sweep.points(contents_of([record, sheet]), {record.label: SETTING})


def test_a_point_has_the_worst_error_of_a_level_and_seconds_a_second_of_motion() -> None:
    levels = (level(0.2, 0.04), level(0.1, 0.01))
    worse = (level(0.2, 0.03), level(0.1, 0.02))
    coarse, fine = points(finding("pass", levels=levels), finding("pass", levels=worse))
    assert (coarse.level, coarse.error, coarse.bound, coarse.cost) == (0.2, 0.04, 0.5, 0.5)
    assert (fine.level, fine.error) == (0.1, 0.02)


@pytest.mark.parametrize(
    ("outcomes", "verdict"),
    [
        (("pass", "undecided"), "pass"),
        (("pass", "fail"), "fail"),
        (("fail", "error"), "error"),
        (("undecided",), "undecided"),
        (("unsupported",), "unsupported"),
    ],
)
def test_the_verdict_is_the_worst_of_what_was_decided(
    outcomes: tuple[Outcome, ...], verdict: str
) -> None:
    (point,) = points(*(finding(outcome, "order") for outcome in outcomes))
    assert point.verdict == verdict
    assert point.reason == f"It is {verdict}."
    assert point.error is None


def test_names_from_a_file_stay_in_their_cells() -> None:
    found = points(finding("fail"), engine="my|<b>\x1b[2Jdem\nx")
    assert "\x1b" not in sweep.text(["theta0"], found)
    assert len(sweep.text(["theta0"], found).splitlines()) == 3
    markdown = sweep.markdown("Sweep", ["theta0"], found)
    assert "<b>" not in markdown
    assert "\x1b" not in markdown
    assert "\x1b" not in sweep.csv(["theta0"], found)
    assert "\x1b" not in sweep.as_json("swing", ["theta0"], found, [])


def test_the_json_has_null_for_what_was_not_measured() -> None:
    document = json.loads(sweep.as_json("swing", ["theta0"], points(finding("undecided")), ["no"]))
    (point,) = document["points"]
    assert point["setting"] == SETTING
    assert point["level"] is None
    assert point["verdict"] == "undecided"
    assert document["absent"] == ["no"]


def test_reasons_that_differ_in_numbers_alone_are_one_line() -> None:
    reasons = ("It moves by 0.09.", "It moves by 1.5e-3.", "It does not move.")
    found = [
        Point(setting=SETTING, engine="mydem", method="gear-4", verdict="undecided", reason=reason)
        for reason in reasons
    ]
    first, second = sweep.reasons(found)
    assert first.startswith("undecided, mydem/gear-4: It moves by 0.09. (2 of 3 rows; ")
    assert second == "undecided, mydem/gear-4: It does not move. (1 of 3 rows)"


def test_reasons_of_methods_that_differ_in_a_number_are_apart() -> None:
    found = [
        Point(setting=SETTING, engine="mydem", method=method, verdict="fail", reason="It fails.")
        for method in ("gear-4", "gear-5")
    ]
    assert len(sweep.reasons(found)) == 2
