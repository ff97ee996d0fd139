"""Records as JSON lines: what is written is read back, and what cannot be read is said."""

import math
import os
from pathlib import Path

import pytest

from refdem.core.finding import Finding, Level, Record, Series
from refdem.errors import StoreError, UsageError
from refdem.report import read_records, records, write_records, write_report
from refdem.report.jsonl import RECORDS, lines, sheets_in


def record(finding):
    return Record(
        case="pendulum",
        label="pendulum",
        parameters={},
        engine="alpha",
        version="1",
        method="rk4",
        is_reference=False,
        runs=(),
        findings=(finding,),
    )


def test_sheets_are_read_back_as_they_were_written(sheets, tmp_path):
    write_records(tmp_path, sheets)
    assert read_records(tmp_path) == sheets


def test_records_written_again_are_the_same_bytes(sheets, tmp_path):
    write_records(tmp_path / "one", sheets)
    write_records(tmp_path / "two", read_records(tmp_path / "one"))
    assert (tmp_path / "one/records.jsonl").read_bytes() == (
        tmp_path / "two/records.jsonl"
    ).read_bytes()


def test_a_malformed_line_is_named(sheets, tmp_path):
    write_records(tmp_path, sheets)
    path = tmp_path / "records.jsonl"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], lines[1][:40], *lines[2:]]))
    with pytest.raises(UsageError, match=r"records\.jsonl, line 2: "):
        read_records(tmp_path)


def test_a_sheet_of_an_unknown_kind_is_named(tmp_path):
    (tmp_path / "records.jsonl").write_text('{"type": "poem"}\n')
    with pytest.raises(UsageError, match=r"line 1: .*poem"):
        read_records(tmp_path)


def test_a_folder_without_records_says_how_to_make_them(tmp_path):
    with pytest.raises(StoreError, match="refdem run"):
        read_records(tmp_path)


def test_a_folder_that_cannot_be_written_is_a_store_error(sheets, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError, match="--out"):
        write_report(tmp_path / "file" / "report", sheets)


def test_nothing_is_left_beside_a_file_that_was_written(sheets, tmp_path):
    write_records(tmp_path, sheets)
    assert [path.name for path in tmp_path.iterdir()] == ["records.jsonl"]


def test_numbers_that_are_not_finite_cost_the_number_and_not_the_finding(tmp_path):
    good = Level(level=0.1, error=1.0, bound=2.0, seconds=1.0, counts=True)
    bad = Level(level=0.05, error=math.inf, bound=2.0, seconds=1.0, counts=True)
    curve = Series(t=[0.0, 1.0], value=[math.nan, 2.0], bound=[1.0, 1.0])
    numbers = {"value": math.nan, "bound": 1.0, "levels": (good, bad), "series": curve}
    finding = Finding(check="error", quantity="x", outcome="fail", sentence="It is nan.", **numbers)
    write_records(tmp_path, [record(finding)])
    (read,) = read_records(tmp_path)
    (found,) = read.findings
    assert (found.outcome, found.sentence, found.value, found.bound) == (
        "fail",
        "It is nan.",
        None,
        1.0,
    )
    assert found.levels == (good,)
    assert found.series == Series(t=[1.0], value=[2.0], bound=[1.0])


def test_a_report_as_tables_has_a_row_for_every_finding_and_level(folder, sheets):
    tables = records(folder)
    found = [finding for sheet in sheets if isinstance(sheet, Record) for finding in sheet.findings]
    assert len(tables.findings) == len(found)
    assert set(tables.findings["outcome"]) == {
        "pass",
        "fail",
        "error",
        "unsupported",
        "undecided",
        "expected",
        "stale",
    }
    verlet = tables.levels.query(
        "label == 'pendulum' and engine == 'reference' and method == 'verlet' and quantity == 'x'"
    )
    assert verlet["error"].tolist() == pytest.approx([3e-2, 7.5e-3, 1.875e-3, 4.6875e-4])
    row = tables.tolerance.query(
        "label == 'pendulum' and engine == 'reference' and method == 'verlet' and quantity == 'x'"
    ).iloc[0]
    assert row["step_for_3_digits"] == 0.0125
    assert math.isnan(row["step_for_6_digits"])


def test_the_public_name_reads_a_report(folder):
    import refdem

    assert len(refdem.records(folder).tolerance) > 0


def test_records_of_a_stranger_move_no_cursor(tmp_path):
    text = lines([record(Finding(check="error", quantity="x", outcome="pass", sentence="held"))])
    (tmp_path / RECORDS).write_bytes(
        text.replace(b'"sentence":"', b'"sentence":"\\u001b[31m\\u202e::')
    )
    found = [
        finding
        for sheet in sheets_in(tmp_path)
        if isinstance(sheet, Record)
        for finding in sheet.findings
    ]
    assert found
    assert all(finding.sentence.startswith("?[31m?::") for finding in found)


def test_records_that_nest_without_end_are_refused_in_one_sentence(tmp_path):
    (tmp_path / RECORDS).write_bytes(b"[" * 100_000)
    with pytest.raises(UsageError, match="line 1"):
        sheets_in(tmp_path)


def test_records_by_a_link_or_a_pipe_are_not_read(tmp_path: Path) -> None:
    (tmp_path / "elsewhere.jsonl").write_bytes(b"")
    (tmp_path / "link.jsonl").symlink_to("elsewhere.jsonl")
    os.mkfifo(tmp_path / "pipe.jsonl")
    for name in ("link.jsonl", "pipe.jsonl"):
        with pytest.raises(StoreError, match=f"cannot read .*{name}: "):
            sheets_in(tmp_path, name)
