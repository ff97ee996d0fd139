"""Bounds of the campaign `main` lie near what is measured: every group of findings that is far
inside its bounds has a reason here.
"""

import tomllib
from collections import Counter
from fnmatch import fnmatch
from pathlib import Path
from statistics import median

import pytest

from refdem.core import discovery
from refdem.pytest_plugin import campaign_records
from refdem.report.margins import groups, margins_by_check

GROUPS = groups(campaign_records("main"))
MOST = 1.5
"""Decades: the median margin of bounds above round-off is less."""
NEARLY = 2.5
"""Decades: a reason is needed while a group that it is for is this far inside its bounds; on
another processor it may be more.
"""

TABLES = Path(__file__).with_name("margins")
"""Groups that are far inside their bounds, a file a case: patterns of check, case and engine, with
the reason, or the name of one that several rows share.
"""
SHARED_REASONS = tomllib.loads(Path(__file__).with_name("shared_reasons.toml").read_text())


def rows_of(kind):
    """Rows (check, case, engine, reason) of all files, of one kind: `at_round_off` or `loose`."""
    rows = []
    for path in sorted(TABLES.glob("*.toml")):
        for row in tomllib.loads(path.read_text()).get(kind, []):
            reason = row.get("reason")
            if reason is None:
                reason = SHARED_REASONS[row["because"]]
            rows.append((row["check"], row["case"], row["engine"], reason))
    return tuple(rows)


AT_ROUND_OFF = rows_of("at_round_off")
"""Groups whose bounds of round-off are more than the two decades that other processors need above
what is measured.
"""
LOOSE = rows_of("loose")
"""Groups above round-off that are far inside their bounds."""


def has_reason(group):
    rows = LOOSE
    if group.is_at_round_off:
        rows = AT_ROUND_OFF
    return any(_matches(group, row) for row in rows)


def _matches(group, row):
    check, case, engine, _ = row
    return (
        group.check == check
        and fnmatch(group.label, case.replace("[", "[[]"))
        and fnmatch(group.engine, engine)
    )


def test_no_group_is_far_inside_its_bounds_without_a_reason():
    assert [group.line for group in GROUPS if group.is_loose and not has_reason(group)] == []


ROWS = [(row, True) for row in AT_ROUND_OFF] + [(row, False) for row in LOOSE]


@pytest.mark.parametrize(
    ("row", "at_round_off"),
    ROWS,
    ids=lambda value: "/".join(value[:3]) if isinstance(value, tuple) else "",
)
def test_a_reason_belongs_to_a_group_that_needs_it(row, at_round_off):
    ours = [
        group for group in GROUPS if _matches(group, row) and group.is_at_round_off == at_round_off
    ]
    assert max((min(group.margins) for group in ours), default=0.0) > NEARLY


@pytest.mark.parametrize("row", [*AT_ROUND_OFF, *LOOSE], ids=lambda row: "/".join(row[:3]))
def test_a_reason_is_for_groups_of_one_case(row):
    """A row that excuses a check, or an engine, throughout would excuse what nobody has looked
    at.
    """
    case = row[1].partition("[")[0].partition("*")[0]
    assert row[0] != "*"
    assert case in discovery.names("cases")


def test_bounds_above_round_off_are_near_what_is_measured():
    margins = [
        margin
        for margins in margins_by_check(GROUPS, at_round_off=False).values()
        for margin in margins
    ]
    assert median(margins) < MOST


def test_every_shared_reason_is_named_by_two_rows_or_more():
    named = Counter()
    for path in TABLES.glob("*.toml"):
        for rows in tomllib.loads(path.read_text()).values():
            named.update(row["because"] for row in rows if "because" in row)
    assert sorted(named) == sorted(SHARED_REASONS)
    assert min(named.values()) > 1
