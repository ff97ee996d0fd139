"""The campaign with an engine that misbehaves: every fault costs its own run, and is named."""

import pytest

from refdem.core.finding import CampaignSheet, Record
from refdem.core.store import Store
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

EVER = 600.0
"""[s], a time limit that no busy machine reaches."""


def records(
    path,
    method="",
    checks=(),
    use_store=True,
    case="harmonic-oscillator",
    engine="played",
    timeout=EVER,
    **more,
):
    specification = Specification(
        name="test",
        case=[Entry(case)],
        engines=[engine],
        method=method,
        checks=list(checks),
        levels=3,
        timeout=timeout,
        **more,
    )
    sheets = Campaign(
        specification, Store(path / "store.sqlite"), jobs=2, use_store=use_store
    ).sheets()
    return {sheet.method: sheet for sheet in sheets if isinstance(sheet, Record)}, next(
        s for s in sheets if isinstance(s, CampaignSheet)
    )


@pytest.fixture(scope="module")
def everything(played, tmp_path_factory):
    folder = tmp_path_factory.mktemp("all")
    hung = records(folder, checks=["error", "order"], engine="stuck", timeout=1)[0]
    return hung | records(folder, checks=["error", "order"])[0]


def outcomes(record):
    return {finding.outcome for finding in record.findings}


@pytest.fixture(scope="module")
def judged(played, tmp_path_factory):
    """The methods that run to an end, under every check."""
    path = tmp_path_factory.mktemp("judged")
    return {
        name: records(path, method=name)[0][name]
        for name in ("good", "wrong-force", "drag", "forgetful")
    }


def test_a_correct_engine_raises_no_alarm(judged):
    assert outcomes(judged["good"]) == {"pass"}
    assert {f.check for f in judged["good"].findings} >= {
        "error",
        "order",
        "energy",
        "reversal",
        "determinism",
    }


@pytest.mark.parametrize(
    ("method", "kind", "says"),
    [
        ("crash", "crash", "exit code 7"),
        ("hang", "hang", "was killed"),
        ("nan", "contract", r"position\[5, 0, 0\] is nan"),
        ("short", "contract", "62 samples; expected 65"),
        ("late", "contract", "trajectory.t"),
        ("raises", "exception", "ZeroDivisionError: a bug"),
    ],
)
def test_a_broken_run_is_one_error_finding_that_says_what_happened(everything, method, kind, says):
    import re

    findings = everything[method].findings
    assert [f.outcome for f in findings] == ["error"]
    assert f"({kind})" in findings[0].sentence
    assert re.search(says, findings[0].sentence)


def test_the_rest_goes_on_when_one_method_crashes(everything):
    assert outcomes(everything["good"]) == {"pass"}
    assert outcomes(everything["refuses"]) == {"unsupported"}


@pytest.mark.parametrize(
    ("method", "check", "quantity"),
    [
        ("wrong-force", "error", "x"),
        ("drag", "reversal", "reversed"),
        ("forgetful", "determinism", "repeated"),
    ],
)
def test_a_lie_is_found_by_the_check_that_is_there_for_it(judged, method, check, quantity):
    assert any(
        f.outcome == "fail" and (f.check, f.quantity) == (check, quantity)
        for f in judged[method].findings
    )


def test_unchanged_runs_are_read_and_not_made(played, tmp_path):
    first, made = records(tmp_path, method="good")
    second, read = records(tmp_path, method="good")
    assert made.runs_made > 0
    assert made.runs_read == 0
    assert (read.runs_made, read.runs_read) == (0, made.runs_made)
    assert first["good"].findings == second["good"].findings
    assert records(tmp_path, method="good", use_store=False)[1].runs_made == made.runs_made


def test_a_new_fingerprint_runs_everything_again(played, tmp_path, monkeypatch):
    from refdem.core import discovery

    _, made = records(tmp_path, method="good")
    monkeypatch.setattr(
        type(discovery.engine("played")), "fingerprint", lambda self, method: "played 2"
    )
    assert records(tmp_path, method="good")[1].runs_made == made.runs_made


def test_a_campaign_that_is_run_twice_counts_the_runs_of_each_time(played, tmp_path):
    specification = Specification(
        name="test",
        case=[Entry("harmonic-oscillator")],
        engines=["played"],
        method="good",
        levels=3,
    )
    campaign = Campaign(specification, Store(tmp_path / "store.sqlite"), jobs=0, use_store=False)
    (first, *found), (second, *again) = campaign.sheets(), campaign.sheets()
    assert first.runs_made > 0
    assert (second.runs_made, second.runs_read) == (first.runs_made, first.runs_read)
    assert len(found) == len(again)
