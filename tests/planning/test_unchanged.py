"""A campaign of which nothing has changed is read whole; whatever its findings follow from makes it
judge again.
"""

import dataclasses

import msgspec
import pytest

from refdem.core import discovery
from refdem.core.deviation import Deviation
from refdem.core.finding import CampaignSheet
from refdem.core.store import Store
from refdem.planning import judging, unchanged
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

SPECIFICATION = Specification(
    name="t",
    case=[Entry("harmonic-oscillator")],
    engines=["played"],
    method="good",
    checks=["error"],
    levels=3,
)


@pytest.fixture
def judgements(monkeypatch):
    """How often something is judged."""
    seen = []
    record = judging.record
    monkeypatch.setattr(
        judging,
        "record",
        lambda task, *more: (seen.append(task.method.name), record(task, *more))[1],
    )
    return seen


def of(path, **changed):
    use_store = changed.pop("use_store", True)
    return Campaign(
        msgspec.structs.replace(SPECIFICATION, **changed),
        Store(path / "store.sqlite"),
        0,
        use_store,
    ).sheets()


def without_times(sheets):
    return [sheet for sheet in sheets if not isinstance(sheet, CampaignSheet)]


def test_nothing_is_judged_twice_and_the_sheets_are_the_same(played, tmp_path, judgements):
    first = of(tmp_path)
    second = of(tmp_path)
    assert judgements == ["good"]
    assert without_times(first) == without_times(second)
    assert (first[0].runs_made, second[0].runs_made, second[0].runs_read) == (3, 0, 3)


@pytest.mark.parametrize(
    "changed", [{"levels": 2}, {"checks": ["energy"]}, {"perturbed_ulps": 1}, {"use_store": False}]
)
def test_another_question_is_judged(played, tmp_path, judgements, changed):
    of(tmp_path)
    of(tmp_path, **changed)
    assert judgements == ["good", "good"]


@pytest.mark.parametrize("attribute", ["methods", "version", "fingerprint", "expected"])
def test_an_engine_of_other_code_or_claims_is_judged(
    played, tmp_path, judgements, monkeypatch, attribute
):
    of(tmp_path)
    engine = discovery.engine("played")
    other = {
        "methods": tuple(dataclasses.replace(method, order=3) for method in engine.methods),
        "version": lambda: "1.1",
        "fingerprint": lambda method: "played 2",
        "expected": (
            Deviation(
                case="pendulum",
                method="*",
                check="error",
                quantity="x",
                versions="*",
                low=0.0,
                high=1.0,
                reason="known",
                link="",
            ),
        ),
    }
    monkeypatch.setattr(engine, attribute, other[attribute])
    of(tmp_path)
    assert judgements == ["good", "good"]


@pytest.mark.parametrize("part", ["of_refdem", "of_tree"])
def test_other_code_of_refdem_or_other_deviations_judge_again(
    played, tmp_path, judgements, monkeypatch, part
):
    of(tmp_path)
    monkeypatch.setattr(unchanged.fingerprint, part, lambda *folder: "another state")
    of(tmp_path)
    assert judgements == ["good", "good"]


def test_what_may_end_otherwise_next_time_is_not_kept(played, tmp_path, judgements):
    for _ in range(2):
        hanging = msgspec.structs.replace(
            SPECIFICATION, engines=["stuck"], method="hang", timeout=1.0
        )
        Campaign(hanging, Store(tmp_path / "store.sqlite"), 1).sheets()
    assert judgements == ["hang", "hang"]


def test_checks_of_another_package_are_always_asked(played, tmp_path, judgements, monkeypatch):
    monkeypatch.setattr(discovery, "has_others", lambda folder: folder == "checks")
    of(tmp_path)
    of(tmp_path)
    assert judgements == ["good", "good"]
