"""A report that stands as it was left is not written again; one that was touched, or whose findings
changed, is.
"""

import msgspec
import pytest

from refdem.core.finding import CampaignSheet, Record
from refdem.report import write_report


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
