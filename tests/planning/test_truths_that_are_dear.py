"""A proof that takes too long ends, says so, and what it had certified by then is judged."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.finding import CaseSheet, Record
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.core.truth import SampledTruth
from refdem.errors import RefdemError
from refdem.execution.schedule import Job, Schedule, guarded
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification
from refdem.planning.truths import FAILED, UNASKED, BrokenProofError, sampled_truths, truth_key
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody

LIMIT = 6.0
"""Seconds of CPU; the first samples take a tenth of that, all of them minutes."""
SLIPS = {"member": "slope", "slope": "0.2", "friction": "0.7", "duration": "0.2"}
"""A body that begins to slip: the friction turns ever faster, and the proof takes tiny pieces."""


def proved(folder: Path, **settings: str) -> SampledTruth:
    """The truth within LIMIT."""
    instance = discovery.case("neglected-gyroscopic").at(**settings)
    store = Store(folder / "store.sqlite")
    with Schedule(1, LIMIT) as schedule:
        (found,) = sampled_truths(schedule, store, [(instance, ())], lambda *_: None)
    store.close()
    return found


def test_what_was_certified_in_time_stays_certified(tmp_path: Path) -> None:
    found = proved(tmp_path, **SLIPS)
    assert 0 < found.until < len(found.t) == 65
    assert found.reason.startswith(FAILED)
    assert "of CPU time and was killed; what comes before is certified" in found.reason
    assert all(len(values) == found.until for values in found.values.values())
    assert len(found.sensitivity) == found.until
    # The same motion, asked for up to a sample that is certified quickly.
    early = proved(tmp_path, **(SLIPS | {"duration": "0.0125", "samples": "4"}))
    assert early.until == 5
    for name, values in early.values.items():
        assert np.allclose(values[0], found.values[name][0], rtol=0, atol=1e-15)


def test_what_no_engine_can_say_is_not_proved(tmp_path: Path) -> None:
    entry = Entry("neglected-gyroscopic", SLIPS)
    asked = Specification(name="own", case=[entry], engines=["reference"], timeout=3000.0)
    store = Store(tmp_path / "store.sqlite")
    sheets = Campaign(asked, store, jobs=1).sheets()
    store.close()
    (case,) = (sheet for sheet in sheets if isinstance(sheet, CaseSheet))
    assert case.truth_reason == UNASKED
    (record,) = (sheet for sheet in sheets if isinstance(sheet, Record))
    assert {finding.outcome for finding in record.findings} == {"unsupported"}


class Here:
    """A scheduler that runs jobs in this process, as a worker runs them."""

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job with its bytes or its Failure, in order."""
        for job in jobs:
            yield job, guarded(job.function, *job.arguments)


def test_an_exception_in_a_proof_is_no_verdict_and_other_proofs_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was kept as the reason of an undecided finding: "the proof ended in a exception"."""
    sound = discovery.case("harmonic-oscillator").at(duration="1", samples="4")
    broken = discovery.case("free-rigid-body").at(duration="1", samples="4")

    def raising(self: object, t: object) -> float:
        raise ZeroDivisionError("a division by 0")

    monkeypatch.setattr(FreeRigidBody, "sensitivity", raising)
    store = Store(tmp_path / "store.sqlite")
    with pytest.raises(BrokenProofError, match="ZeroDivisionError: a division by 0") as caught:
        sampled_truths(Here(), store, [(broken, ()), (sound, (0.01,))], lambda *_: None)
    kept = store.truth(truth_key(sound, (0.01,)))
    store.close()
    assert broken.label in str(caught.value)
    # The command line ends with the status of refdem that broke for all that is no RefdemError.
    assert not isinstance(caught.value, RefdemError)
    assert kept is not None
    assert kept.until == 5
