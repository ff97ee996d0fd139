"""The first screen of a report, against what its cells and choices say."""

import math

import msgspec
import pytest

from refdem.report import overview
from refdem.report.advice import Choice, Recommendation
from refdem.report.contents import contents_of
from refdem.report.html import pages
from refdem.report.tolerance import cell, rows_of
from tests.report.synthetic import case_sheet, engine_sheet, error, record, said


def contents():
    """Two settings of a pendulum and a spinning body, in the reference and in another engine."""
    cases = [
        ("pendulum", "pendulum", "swinging"),
        ("pendulum", "pendulum[theta0=3]", "swinging"),
        ("free-rigid-body", "free-rigid-body", "spinning"),
    ]
    sheets = [engine_sheet("reference"), engine_sheet("alpha")]
    for case, label, motion in cases:
        sheet = case_sheet(case, label, case.title(), "")
        sheets.append(msgspec.structs.replace(sheet, motion=motion))
        sheets.append(record(case, label, "reference", "exact", error("x", 1e-15, 0, steps=(0.0,))))
    sheets += [
        record("pendulum", "pendulum", "alpha", "rk4", error("x", 1e-6, 4)),
        record("pendulum", "pendulum[theta0=3]", "alpha", "rk4", error("x", 1e-3, 4)),
        record(
            "pendulum", "pendulum[theta0=3]", "alpha", "euler", said("run", "error", "It fell.")
        ),
        record(
            "free-rigid-body",
            "free-rigid-body",
            "alpha",
            "rk4",
            said("support", "unsupported", "No."),
        ),
    ]
    return contents_of(sheets)


def lines_of(found):
    cells = {
        (sheet.label, engine.engine): cell(
            found, rows_of(found, sheet.label), sheet.label, engine.engine
        )
        for sheet in found.cases
        for engine in found.engines
    }
    return overview.case_lines(found, cells)


def index_of(found):
    rows = {sheet.label: rows_of(found, sheet.label) for sheet in found.cases}
    specs = {"": {}, **{sheet.label: {} for sheet in found.cases}}
    return dict(pages(found, rows, specs))["index.html"]


def test_cases_are_grouped_by_what_moves_in_the_order_of_the_kinds():
    lines = lines_of(contents())
    assert list(lines) == ["spinning", "swinging"]
    assert [line.case for line in lines["swinging"]] == ["pendulum"]
    assert lines["swinging"][0].settings == 2


def test_a_case_has_the_digits_of_its_worst_setting_and_leads_there():
    (line,) = lines_of(contents())["swinging"]
    # Errors fall by 8^4 from the first step to the last: 1e-3/4096 in the worse setting.
    found = line.cells["alpha"]
    assert found.cell.digits == pytest.approx(6.6, abs=0.05)
    assert found.label == "pendulum[theta0=3]"
    assert found.cell.worst == "error"
    assert found.cell.counts == {"error": 1, "pass": 2}
    assert (found.measured, found.requested, found.refused) == (2, 2, {})


def test_a_case_that_an_engine_cannot_run_has_no_digits():
    (line,) = lines_of(contents())["spinning"]
    found = line.cells["alpha"]
    assert found.cell.digits is None
    assert found.cell.worst == "unsupported"
    assert (found.measured, found.requested, found.refused) == (0, 1, {"No.": 1})


def test_an_exact_setting_speaks_for_a_case_whose_other_settings_were_refused():
    sheets = [engine_sheet("alpha")]
    for label in ("pendulum", "pendulum[theta0=3]"):
        sheet = case_sheet("pendulum", label, "Pendulum", "")
        sheets.append(msgspec.structs.replace(sheet, motion="swinging"))
    refusal = said("support", "unsupported", "No.")
    exact = error("x", 0.0, 0, steps=(0.0,))
    sheets.append(record("pendulum", "pendulum", "alpha", "rk4", refusal))
    sheets.append(record("pendulum", "pendulum[theta0=3]", "alpha", "rk4", exact))
    (line,) = lines_of(contents_of(sheets))["swinging"]
    found = line.cells["alpha"]
    assert found.label == "pendulum[theta0=3]"
    assert (found.cell.digits, found.measured, found.requested) == (math.inf, 1, 2)


def test_an_engine_that_runs_a_part_of_a_case_is_told_with_what_it_refused():
    sheets = [engine_sheet("alpha")]
    for label in ("pendulum", "pendulum[theta0=3]"):
        sheet = case_sheet("pendulum", label, "Pendulum", "")
        sheets.append(msgspec.structs.replace(sheet, motion="swinging"))
    sheets.append(record("pendulum", "pendulum", "alpha", "rk4", error("x", 1e-6, 4)))
    refusal = said("support", "unsupported", "No large angles.")
    sheets.append(record("pendulum", "pendulum[theta0=3]", "alpha", "rk4", refusal))
    found = contents_of(sheets)
    ((title, engine, cell_found),) = overview.part_refused(lines_of(found))
    assert (title, engine, cell_found.refused) == ("Pendulum", "alpha", {"No large angles.": 1})
    page = index_of(found)
    assert "Pendulum, alpha: digits in 1 of 2 settings" in page
    assert "Refused in 1: No large angles." in page
    assert overview.part_refused(lines_of(contents())) == []


def test_a_motion_that_enlarges_round_off_says_so_where_the_method_is_exact():
    sheet = case_sheet("pendulum", "pendulum", "Pendulum", "")
    exact = error("x", 1e-3, 0, steps=(0.0,))
    sheets = [engine_sheet("alpha"), sheet, record("pendulum", "pendulum", "alpha", "m", exact)]
    found = contents_of(sheets)
    (cell_found,) = [line.cells["alpha"] for own in lines_of(found).values() for line in own]
    # The bound is twice the error: 2e-3 of the scale, in units of 2^-53.
    assert cell_found.cell.growth == pytest.approx(2e-3 * 2**53)
    assert "1.8e13</small>" in index_of(found)
    # A method with steps has errors of its own.
    stepped = contents_of(
        [*sheets[:2], record("pendulum", "pendulum", "alpha", "m", error("x", 1e-3, 4))]
    )
    (cell_found,) = [line.cells["alpha"] for own in lines_of(stepped).values() for line in own]
    assert cell_found.cell.growth == 1.0


def test_advice_is_for_other_engines_than_the_reference_where_they_were_measured():
    (line,) = overview.advised(contents())
    assert (line.motion, line.engine, line.settings) == ("swinging", "alpha", 2)
    three, six, nine = line.best
    assert three.steps_per_tau == pytest.approx(0.5 / 0.1)
    assert six.steps_per_tau == pytest.approx(0.5 / 0.0125)
    assert nine is not None


def recommendation(*levels, control="step", tau=1.0, extrapolated=False):
    found = record("a", "a", "alpha", "rk4")
    held = tuple(
        Choice(
            record=found,
            control=control,
            tau=tau,
            level=level,
            error=1e-4,
            cost=1.0,
            is_extrapolated=extrapolated,
        )
        for level in levels
    )
    return Recommendation(engine="alpha", method="rk4", control=control, held=held, missed=())


@pytest.mark.parametrize(
    ("best", "settings", "text"),
    [
        (None, 2, "none"),
        (recommendation(0.1, 0.3), 2, "rk4, 10 steps per tau"),
        (recommendation(1 / 3.2), 1, "rk4, 4 steps per tau"),
        (recommendation(1 / 1234.0), 1, "rk4, 1300 steps per tau"),
        (recommendation(0.01, extrapolated=True), 1, "rk4, ~100 steps per tau"),
        (recommendation(0.1), 3, "rk4, 10 steps per tau (1 of 3 settings)"),
        (recommendation(1e-6, 1e-8, control="tolerance"), 2, "rk4, tolerance 1e-08"),
        (recommendation(0.0, control="exact"), 1, "rk4, any step"),
    ],
)
def test_advice_says_method_step_and_where(best, settings, text):
    assert overview.advice_text(best, settings) == text


def advised_method(*choices):
    return overview._best(list(choices)).method


def choice(method, level, control="step", **more):
    found = record("a", "a", "alpha", method)
    more = {"error": 1e-4, "cost": 1.0, "tau": 1.0, **more}
    return Choice(record=found, control=control, level=level, **more)


def test_of_methods_that_hold_as_many_settings_the_one_with_the_fewest_steps_is_advised():
    few = choice("few", 0.1, cost=9.0)
    many = choice("many", 0.01, cost=1.0)
    assert advised_method(many, few) == "few"
    # Steps that a method of a tolerance chose are counted; where nobody counted, it comes last.
    assert advised_method(few, choice("own", 1e-6, "tolerance", steps_taken=3.0)) == "own"
    assert advised_method(few, choice("own", 1e-6, "tolerance", steps_taken=30.0)) == "few"
    assert advised_method(many, choice("own", 1e-6, "tolerance")) == "many"
    # A method without step and tolerance may take steps of its own.
    own = choice("own", 0.0, "exact", steps_taken=30.0)
    assert advised_method(few, own) == "few"
    assert overview.advice_text(overview._best([own]), 1) == "own, steps of its own"
    # No step at all is fewer than any, and settings come before steps.
    assert advised_method(few, choice("exact", 0.0, "exact", cost=99.0)) == "exact"
    assert advised_method(few, many, choice("many", 0.01)) == "many"


def test_steps_that_are_shown_as_the_same_number_are_the_same():
    # 3334 and 3335 steps are shown as 3400: the first by name, not by the last digit of an error.
    assert advised_method(choice("a", 1 / 3335.0), choice("b", 1 / 3334.0)) == "a"
    assert advised_method(choice("a", 1 / 3401.0), choice("b", 1 / 3334.0)) == "b"


def test_no_more_digits_are_shown_than_binary64_has():
    assert overview.shown_digits(float("inf")) == "16"
    assert overview.shown_digits(16.4) == "16"
    assert overview.shown_digits(15.96) == "16.0"
    assert overview.shown_digits(3.14159) == "3.1"


def test_what_failed_comes_before_every_table_and_only_there():
    found = contents()
    rows = {sheet.label: rows_of(found, sheet.label) for sheet in found.cases}
    specs = {"": {}, **{sheet.label: {} for sheet in found.cases}}
    index = dict(pages(found, rows, specs))["index.html"]
    assert index.count("It fell.") == 1
    assert index.index("It fell.") < index.index("<table")
    places = [index.index(f'id="{name}"') for name in ("broken", "cases", "advice", "tolerance")]
    assert places == sorted(places)
