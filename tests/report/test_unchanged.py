"""A report that stands as it was left is not written again; one that was touched, or whose findings
changed, is.
"""

import os

import msgspec
import pytest

from refdem.core import fingerprint
from refdem.core.finding import CampaignSheet, Record
from refdem.report import is_up_to_date, read_records, write_report


@pytest.fixture
def report(sheets, store, tmp_path):
    write_report(tmp_path, sheets, store)
    return tmp_path


def time_of(report):
    return (report / "index.html").stat().st_mtime_ns


def test_it_is_left_alone_however_long_the_campaign_took(report, sheets, store):
    before = time_of(report)
    longer = [
        (
            msgspec.structs.replace(s, seconds=s.seconds + 1, runs_made=0)
            if isinstance(s, CampaignSheet)
            else s
        )
        for s in sheets
    ]
    write_report(report, longer, store)
    assert time_of(report) == before


@pytest.mark.parametrize("name", ["index.html", "records.jsonl", "figures", "cases"])
def test_a_file_that_was_changed_or_removed_is_written_again(report, sheets, store, name):
    if (report / name).is_file():
        path = report / name
    else:
        path = next((report / name).iterdir())
    whole = path.read_bytes()
    before = time_of(report)
    path.write_bytes(whole + b" ")
    write_report(report, sheets, store)
    assert path.read_bytes() == whole
    path.unlink()
    write_report(report, sheets, store)
    assert path.read_bytes() == whole
    assert time_of(report) != before


def test_another_finding_or_another_place_is_written(report, sheets, store, tmp_path_factory):
    before = time_of(report)
    (record, *_) = [sheet for sheet in sheets if isinstance(sheet, Record)]
    write_report(report, [sheet for sheet in sheets if sheet is not record], store)
    assert time_of(report) != before
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    write_report(elsewhere, sheets, store)
    assert (elsewhere / "index.html").exists()


def test_it_is_as_it_was_left_until_something_of_it_or_behind_it_changes(
    report, sheets, store, monkeypatch
):
    assert is_up_to_date(report, store)
    # Every kind of file that a report has, among them one that nobody wrote.
    for place in ("index.html", "assets/report.css", "assets/index-tolerance.js", "validation.md"):
        path = report / place
        whole = path.read_bytes()
        path.unlink()
        assert not is_up_to_date(report, store), place
        path.write_bytes(whole)
        # The same bytes at another time: looked at again, which costs time and no truth.
        assert not is_up_to_date(report, store), place
        write_report(report, sheets, store)
        assert is_up_to_date(report, store)
    monkeypatch.setattr(fingerprint, "of_refdem", lambda: "another template")
    assert not is_up_to_date(report, store)


def test_a_changed_record_is_seen_by_its_bytes_whatever_its_time(report, sheets, store):
    path = report / "records.jsonl"
    before = path.stat()
    text = path.read_text()
    changed = text.replace("The energy drifts", "The energy drift2")
    assert len(changed) == len(text)
    path.write_text(changed)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert path.stat().st_mtime_ns == before.st_mtime_ns
    assert not is_up_to_date(report, store)
    write_report(report, read_records(report), store)
    assert "The energy drift2" in (report / "cases/pendulum.html").read_text()
    assert is_up_to_date(report, store)


def test_a_pipe_in_place_of_the_records_is_not_waited_for(report, sheets, store):
    (report / "records.jsonl").unlink()
    os.mkfifo(report / "records.jsonl")
    assert not is_up_to_date(report, store)
    (report / "records.jsonl").unlink()
    write_report(report, sheets, store)


def test_no_report_and_one_of_nothing_are_not_as_left(store, tmp_path):
    assert not is_up_to_date(tmp_path, store)
    write_report(tmp_path, [], store)
    assert not is_up_to_date(tmp_path, store)
