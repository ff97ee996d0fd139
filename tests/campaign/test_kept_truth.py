"""A campaign takes the truth that comes with refdem where it is not stale, and proves the rest."""

from pathlib import Path

import pytest

from refdem.campaign import truths, worker
from refdem.campaign.campaign import Campaign
from refdem.campaign.schedule import InProcess
from refdem.campaign.specification import Specification
from refdem.core import discovery
from refdem.core.store import Store
from refdem.truth.sampled import sampled


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    return Campaign(Specification(name="kept", case=[]), Store(tmp_path / "store.sqlite"), jobs=0)


def test_what_is_kept_is_not_proved_again_and_what_is_not_is(
    campaign: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = discovery.case("harmonic-oscillator").at()
    other = discovery.case("harmonic-oscillator").at(mass="2")
    truth = sampled(kept.truth(), kept.times.tolist())
    monkeypatch.setattr(
        truths, "kept_truth", lambda instance: truth if instance.label == kept.label else None
    )
    asked = []
    prove = worker.sampled_truth

    def proved(case: str, given: dict[str, str], delays: tuple[float, ...]) -> bytes:
        asked.append((given, delays))
        return prove(case, given, delays)

    monkeypatch.setattr(worker, "sampled_truth", proved)
    found = campaign._truths(InProcess(), [(kept, ()), (other, ())])
    assert found[0] is truth
    assert found[1].until == len(other.times)
    assert asked == [({"mass": "2"}, ())]


def test_velocities_that_lag_need_a_truth_of_their_own(
    campaign: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    instance = discovery.case("harmonic-oscillator").at()
    truth = sampled(instance.truth(), instance.times.tolist())
    monkeypatch.setattr(truths, "kept_truth", lambda instance: truth)
    (found,) = campaign._truths(InProcess(), [(instance, (0.125,))])
    assert list(found.earlier) == [0.125]
