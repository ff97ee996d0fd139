"""Bounds of the campaign `main` lie near what is measured: every group of findings that is far inside its bounds has a reason here."""

from fnmatch import fnmatch
from statistics import median

import pytest

from refdem.pytest_plugin import campaign_records
from refdem.report.margins import groups, margins_by_check

GROUPS = groups(campaign_records("main"))
MOST = 1.6
"""Decades: the median margin of bounds above round-off is less. It was 1.46 before S was a supremum, and is 1.50 since; the goal is 1.5."""

ROUNDINGS = "c u sqrt(n) S holds for roundings of the worst signs, on any processor; "
AT_ROUND_OFF = {
    "angular-momentum": ROUNDINGS + "a tolerance of 1e-10 is met with digits to spare",
    "apsides": ROUNDINGS + "closed forms add up nothing from sample to sample",
    "energy": ROUNDINGS + "closed forms add up nothing from sample to sample",
    "energy-return": ROUNDINGS + "closed forms add up nothing from sample to sample",
    "error": ROUNDINGS + "where the motion is a closed form, at rest or hardly moves, few of them reach a quantity",
    "event-times": ROUNDINGS + "an event of a closed form is rounded once",
    "flight": ROUNDINGS + "a step of free flight is one addition",
    "limit": ROUNDINGS + "a body that flies straight has no other error",
    "momentum": ROUNDINGS + "of ten thousand bodies the roundings cancel in the sum",
    "order": "20 c u sqrt(n) S is where truncation ends; these errors are a few roundings",
    "rest": ROUNDINGS + "what a contact solver leaves of a balance is a part of gravity, not of the scale",
    "reversal": ROUNDINGS + "on the way back they undo each other, and closed forms add up nothing",
    "second-integral": ROUNDINGS + "the integral has eight factors, each of which may be rounded",
    "stop": ROUNDINGS + "closed forms add up nothing from sample to sample",
    "symmetry": ROUNDINGS + "a picture whose numbers are multiplied by powers of 2, or where a motion is one-dimensional, keeps them",
}
"""Why bounds of round-off may lie more than the two decades above what is measured that other processors need, by check."""

TOLERANCE = "bs must land on every sample, and the samples of a body that turns are closer than the steps that its tolerance allows"
DRAWS = "which spheres of a gas meet hangs on roundings, and neighbours part as fast as the moved start shows"
RESTS = "which corner of a body that rests carries it hangs on roundings, and moved starts show how much that may change"
LOOSE = (
    ("angular-momentum", "two-spheres*", "mujoco", "MuJoCo keeps it in a contact of spheres and does not claim to"),
    ("error", "billiards*", "reference", "S counts every rounding of a million bounces in the direction that grows most"),
    ("error", "driven-duffing*", "rebound", TOLERANCE),
    ("error", "intermediate-axis*", "rebound", "near the middle axis S is thousands, and this motion starts where it grows least"),
    ("error", "neglected-gyroscopic*", "*", "S counts errors made just before an impact, in the direction that the impact turns most"),
    ("error", "newtons-first-law*", "rebound", TOLERANCE),
    ("error", "moments-of-inertia", "mujoco", "vertices are kept in single precision, and those of most solids have few binary digits"),
    ("order", "*", "*", "what an order lacks at small steps is 0 up to the next term; the bound is 0.15, or 0.5 with kinks, for all"),
    ("reversal", "*", "rebound", "a tolerance says nothing of the way back, whose errors undo those of the way there"),
    ("reversal", "intermediate-axis*", "*", "the way back undoes the growth near the axis of the middle moment, which S cannot know"),
    ("reversal", "power-oscillator*", "mujoco", "semi-implicit Euler undoes its first-order error on the way back"),
    ("symmetry", "*", "rebound", "step sizes that are chosen hang on roundings, so that two pictures may differ by the tolerance"),
    ("symmetry", "block-on-slope*", "mujoco", RESTS),
    ("symmetry", "newtons-first-law*", "mujoco", RESTS),
    ("symmetry", "granular-gas*", "reference", DRAWS),
)  # fmt: skip
"""Groups above round-off that are far inside their bounds, by patterns of check, case and engine, with the reason."""


def has_reason(group):
    if group.is_at_round_off and group.check in AT_ROUND_OFF:
        return True
    return any(_matches(group, row) for row in LOOSE)


def _matches(group, row):
    check, case, engine, _ = row
    return group.check == check and fnmatch(group.label, case.replace("[", "[[]")) and fnmatch(group.engine, engine)


def test_no_group_is_far_inside_its_bounds_without_a_reason():
    assert [group.line for group in GROUPS if group.is_loose and not has_reason(group)] == []


@pytest.mark.parametrize("row", LOOSE, ids=lambda row: "/".join(row[:3]))
def test_a_reason_belongs_to_a_group_of_the_campaign(row):
    assert any(_matches(group, row) for group in GROUPS)


def test_bounds_above_round_off_are_near_what_is_measured():
    margins = [margin for margins in margins_by_check(GROUPS, at_round_off=False).values() for margin in margins]
    assert median(margins) < MOST
