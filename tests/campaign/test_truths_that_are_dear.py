"""A proof that takes too long ends, says so, and what it had certified by then is judged."""

from pathlib import Path

import numpy as np

from refdem.campaign.campaign import Campaign
from refdem.campaign.schedule import Schedule
from refdem.campaign.specification import Entry, Specification
from refdem.campaign.truths import FAILED, UNASKED, sampled_truths
from refdem.core import discovery
from refdem.core.finding import CaseSheet, Record
from refdem.core.store import Store
from refdem.core.truth import SampledTruth

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
