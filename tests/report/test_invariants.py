"""What is conserved: the verdict of each law from its findings, and the cells that tell it."""

import msgspec
import pytest

from refdem.core.finding import Finding, Record
from refdem.core.judgement import INTEGRATED
from refdem.report.contents import contents_of
from refdem.report.invariants import KEPT, law_sheets
from refdem.report.markdown import validation
from refdem.report.tolerance import rows_of
from tests.report.synthetic import engine_sheet, error, said


def finding(check, quantity, value, **more):
    """A finding that passes, unless more is said."""
    given = {"outcome": "pass", "sentence": "", "value": value, "bound": 1.0} | more
    return Finding(check=check, quantity=quantity, **given)


def record(*findings, label="pendulum", method="rk4", engine="mujoco"):
    """A record of one method."""
    return Record(
        case="pendulum",
        label=label,
        parameters={},
        engine=engine,
        version="1",
        method=method,
        is_reference=False,
        runs=(),
        findings=findings,
    )


def summary(*records):
    """The summary of the one law and the one engine that the records are about."""
    (sheet,) = law_sheets(contents_of(records))
    (found,) = sheet.summaries.values()
    return found


@pytest.mark.parametrize(
    ("value", "more", "verdict"),
    [
        (0.0, {}, "kept"),
        (KEPT, {}, "kept"),
        (1.01 * KEPT, {}, "approximate"),
        (0.5, {}, "approximate"),
        (1e-15, {"outcome": "fail"}, "lost"),
        (0.5, {"outcome": "expected"}, "lost"),
        (None, {"outcome": "undecided"}, "undecided"),
    ],
)
def test_the_verdict_of_one_setting(value, more, verdict):
    assert summary(record(finding("momentum", "total", value, **more))).counts == {verdict: 1}


def test_the_best_method_speaks_for_an_engine_and_the_worst_setting_for_a_case():
    momentum = [
        record(finding("momentum", "total", 1e-3), method="euler"),
        record(finding("momentum", "total", 1e-6), method="rk4"),
        record(finding("momentum", "total", 0.0), label="pendulum[l=2]"),
    ]
    found = summary(*momentum)
    assert found.counts == {"kept": 1, "approximate": 1}
    assert found.kept == 1
    assert found.largest_error.method == "rk4"
    (sheet,) = law_sheets(contents_of(momentum))
    assert sheet.cases["pendulum"]["mujoco"].label == "pendulum"


def test_a_quantity_that_fails_loses_the_law_whatever_the_others_say():
    spins = finding("angular-momentum", "spin", 1e-3, outcome="fail")
    assert summary(record(finding("angular-momentum", "total", 0.0), spins)).counts == {"lost": 1}


def test_energy_is_told_at_the_finest_level_and_at_the_coarsest_where_that_alone_was_decided():
    coarse = finding("energy", "balance", 1e-2)
    fine = finding("energy", "finest", 1e-6)
    blank = finding("energy", "finest", None, outcome="undecided")
    assert summary(record(coarse, fine)).largest_error.change == 1e-6
    assert summary(record(coarse, blank)).largest_error.change == 1e-2


def test_energy_whose_work_was_integrated_between_samples_is_not_told():
    blurred = finding("energy", "balance", 1e-2, basis=f"round-off, plus {INTEGRATED}")
    assert law_sheets(contents_of([record(blurred)])) == []


def test_what_is_refused_and_what_other_checks_find_is_no_law():
    refused = finding("momentum", "total", None, outcome="unsupported")
    assert law_sheets(contents_of([record(refused, finding("error", "x", 1e-3))])) == []


def test_the_order_is_told_where_it_was_seen():
    order = finding("order", "state", 0.0, order_claimed=4.0)
    missed = finding("order", "state", 0.0, order_claimed=4.0, outcome="fail")
    for other, expected in ((order, 4.0), (missed, None)):
        found = summary(record(finding("constraint", "length", 1e-4), other))
        assert found.largest_error.order == expected


def test_the_table_in_markdown_counts_every_setting():
    contents = contents_of(
        [
            record(finding("reversal", "reversed", 0.0)),
            record(finding("reversal", "reversed", 2e-4), label="pendulum[l=2]"),
            record(
                finding("reversal", "reversed", None, outcome="undecided"), label="pendulum[l=3]"
            ),
        ]
    )
    rows = {sheet.label: rows_of(contents, sheet.label) for sheet in contents.cases}
    text = validation(contents, rows, set())
    line = "kept in 1 of 3, 1 change by at most 2e-4, 1 undecided"
    assert f"| time reversal: back to the start | {line} |" in text


def test_the_change_at_the_default_step_follows_from_the_finest_one_and_the_order():
    # Order 2 and a finest step of 0.0125 s: at 0.05 s the change is 16 times as large.
    order = msgspec.structs.replace(said("order", "pass", ""), order_claimed=2.0)
    findings = (finding("momentum", "total", 1e-6), error("x", 1e-3, 2), order)
    sheets = [record(*findings), msgspec.structs.replace(engine_sheet("mujoco"), default_step=0.05)]
    (sheet,) = law_sheets(contents_of(sheets))
    assert sheet.summaries["mujoco"].at_default == pytest.approx(1.6e-5)
    contents = contents_of(sheets)
    rows = {one.label: rows_of(contents, one.label) for one in contents.cases}
    assert "about 1.6e-5 at the default step" in validation(contents, rows, set())


@pytest.mark.parametrize(
    ("value", "default_step", "at_default"),
    [
        # What is kept is kept at any step; without a default step nothing is said.
        (0.0, 0.05, None),
        (1e-6, None, None),
        # Not below round-off, and not beyond the coarsest step that ran.
        (1e-11, 1e-6, KEPT),
        (1e-2, 0.11, None),
    ],
)
def test_the_change_at_the_default_step_has_limits(value, default_step, at_default):
    order = msgspec.structs.replace(said("order", "pass", ""), order_claimed=2.0)
    own = record(finding("momentum", "total", value), error("x", 1e-3, 2), order)
    engine = msgspec.structs.replace(engine_sheet("mujoco"), default_step=default_step)
    (sheet,) = law_sheets(contents_of([own, engine]))
    assert sheet.summaries["mujoco"].at_default == at_default
