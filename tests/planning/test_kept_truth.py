"""A campaign takes the truth that comes with refdem where it is not stale, and proves the rest."""

from pathlib import Path
from typing import Any

import pytest

from refdem.core import discovery
from refdem.core.store import Store
from refdem.execution import worker
from refdem.execution.schedule import InProcess
from refdem.planning import truths
from refdem.truth.sampled import sampled


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "store.sqlite")


def unseen(stage: str, done: int, total: int) -> None:
    """Nobody looks at the progress."""


def test_what_is_kept_is_not_proved_again_and_what_is_not_is(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = discovery.case("harmonic-oscillator").at()
    other = discovery.case("harmonic-oscillator").at(mass="2")
    truth = sampled(kept.truth(), kept.times.tolist())
    monkeypatch.setattr(
        truths, "kept_truth", lambda instance: truth if instance.label == kept.label else None
    )
    asked = []
    prove = worker.sampled_truth

    def proved(case: str, given: dict[str, str], delays: tuple[float, ...], *more: Any) -> bytes:
        asked.append((given, delays))
        return prove(case, given, delays, *more)

    monkeypatch.setattr(worker, "sampled_truth", proved)
    found = truths.sampled_truths(InProcess(), store, [(kept, ()), (other, ())], unseen)
    assert found[0] is truth
    assert found[1].until == len(other.times)
    assert asked == [({"mass": "2"}, ())]


def test_velocities_that_lag_need_a_truth_of_their_own(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    instance = discovery.case("harmonic-oscillator").at()
    truth = sampled(instance.truth(), instance.times.tolist())
    monkeypatch.setattr(truths, "kept_truth", lambda instance: truth)
    (found,) = truths.sampled_truths(InProcess(), store, [(instance, (0.125,))], unseen)
    assert list(found.earlier) == [0.125]
