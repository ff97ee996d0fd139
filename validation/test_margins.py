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

RECORDS = campaign_records("main")
GROUPS = groups(RECORDS)
MOST = 1.4
"""Decades: the median margin of bounds above round-off is less. Bounds on what follows an impact
hold wherever in its step the impact falls, and are wider than those on smooth motions.
"""
NEARLY = 2.5
"""Decades: a reason is needed while a group that it is for is this far inside its bounds; on
another processor it may be more.
"""
LOOSE_AT_ROUND_OFF = 3.5
"""Decades: a group at round-off needs a reason from here on, half a decade later than others. What
is measured there is the sum of a few roundings, which another processor makes in another order.
"""
NEARLY_AT_ROUND_OFF = 1.0
"""Decades: the same for a reason of round-off. Seen for one group on two processors: 1.7 and more
than 2.5.
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
    """True if a row of either kind is for the group.

    Which kind a group is of is decided by the finding that came nearest to its bound. Where a group
    has bounds of both kinds, roundings decide which that is.
    """
    return any(_matches(group, row) for row in (*AT_ROUND_OFF, *LOOSE))


def needs_reason(group):
    if group.is_at_round_off:
        return min(group.margins) >= LOOSE_AT_ROUND_OFF
    return group.is_loose


def _matches(group, row):
    check, case, engine, _ = row
    return (
        group.check == check
        and fnmatch(group.label, case.replace("[", "[[]"))
        and fnmatch(group.engine, engine)
    )


def test_no_group_is_far_inside_its_bounds_without_a_reason():
    without = [group for group in GROUPS if needs_reason(group) and not has_reason(group)]
    assert [group.line for group in without] == []


ROWS = [(row, True) for row in AT_ROUND_OFF] + [(row, False) for row in LOOSE]


@pytest.mark.parametrize(
    ("row", "at_round_off"),
    ROWS,
    ids=lambda value: "/".join(value[:3]) if isinstance(value, tuple) else "",
)
def test_a_reason_belongs_to_a_group_that_needs_it(row, at_round_off):
    needed = NEARLY
    if at_round_off:
        needed = NEARLY_AT_ROUND_OFF
    ours = [group for group in GROUPS if _matches(group, row)]
    assert max((min(group.margins) for group in ours), default=0.0) > needed


@pytest.mark.parametrize("row", [*AT_ROUND_OFF, *LOOSE], ids=lambda row: "/".join(row[:3]))
def test_a_reason_is_for_groups_of_one_case(row):
    """A row that excuses a check, or an engine, throughout would excuse what nobody has looked
    at.
    """
    case = row[1].partition("[")[0].partition("*")[0]
    assert row[0] != "*"
    assert case in discovery.names("cases")


def makes_steps(record):
    """False for an exact method: its bounds are round-off, however much a motion enlarges it."""
    return discovery.engine(record.engine).method(record.method).control != "exact"


def test_bounds_above_round_off_are_near_what_is_measured():
    of_steps = groups(record for record in RECORDS if makes_steps(record))
    margins = [
        margin
        for margins in margins_by_check(of_steps, at_round_off=False).values()
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
