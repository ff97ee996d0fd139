"""Margins of a campaign: which groups of findings lie far inside their bounds throughout."""

import pytest

from refdem.core.finding import Finding, Record
from refdem.report import margins, write_records


def finding(value, bound, outcome="pass", check="error"):
    return Finding(
        check=check, quantity="x", outcome=outcome, sentence="said", value=value, bound=bound
    )


def record(*findings, engine="e"):
    return Record(
        case="c",
        label="c",
        parameters={},
        engine=engine,
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=findings,
    )


def test_a_group_is_loose_if_every_margin_is_three_decades():
    (loose,) = margins.groups([record(finding(1e-5, 1e-2), finding(1e-6, 1e-1))])
    (sharp,) = margins.groups([record(finding(1e-5, 1e-2), finding(1e-2, 1e-1))])
    assert (loose.is_loose, sharp.is_loose) == (True, False)


def test_methods_of_one_engine_are_one_group_and_engines_are_not():
    found = margins.groups(
        [
            record(finding(1e-5, 1e-2)),
            record(finding(1e-2, 1e-1)),
            record(finding(1e-9, 1e-1), engine="f"),
        ]
    )
    assert [(group.engine, group.is_loose) for group in found] == [("e", False), ("f", True)]


@pytest.mark.parametrize("outcome", ["undecided", "unsupported", "error"])
def test_what_nobody_decided_has_no_margin(outcome):
    assert margins.groups([record(finding(1e-9, 1e-1, outcome))]) == []


def test_what_is_exactly_zero_has_no_margin():
    assert margins.groups([record(finding(0.0, 1e-1))]) == []


def test_bounds_at_round_off_are_counted_apart():
    found = margins.groups([record(finding(1e-14, 1e-12), finding(1e-3, 1e-2))])
    assert margins.margins_by_check(found, at_round_off=True) == {"error": [pytest.approx(2.0)]}
    assert margins.margins_by_check(found, at_round_off=False) == {"error": [pytest.approx(1.0)]}


def test_the_command_prints_loose_groups_and_medians(tmp_path, capsys):
    write_records(tmp_path, [record(finding(1e-5, 1e-2), finding(1e-14, 1e-12, check="momentum"))])
    assert margins.main([str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(
        "1 of 2 groups are 3 decades or more above what is measured throughout.\n  error  c  e: x"
        " has 3.0 decades"
    )
    assert "1 bounds above round-off: the median margin is 3.00 decades." in printed


def test_a_folder_without_records_is_bad_input(tmp_path, capsys):
    assert margins.main([str(tmp_path)]) == 2
    assert "records.jsonl" in capsys.readouterr().err
