"""The whole kill matrix, in two halves that two workers share.

REFDEM_FAULTS has the names of faults that a change can touch, separated by commas
(ci/testing/touched_faults.py): these run at every seed. With
`all`, for a change that can touch every fault, each half has one seed; without it, as in `make
nightly`, the matrix is whole.
"""

import os

import pytest

from refdem.faults.catalogue import chosen
from refdem.kills.trials import FaultTrial, Matrix

SEEDS = 10
ASKED = os.environ.get("REFDEM_FAULTS", "")


@pytest.fixture
def held():
    """The matrix of ten seeds from `first` on, after it has been seen that all is killed and the
    correct engine never alarms.
    """

    def matrix(first: int) -> Matrix:
        faults = chosen([] if ASKED in ("", "all") else ASKED.split(","))
        if ASKED == "all":
            seeds = 1
        else:
            seeds = SEEDS
        found = FaultTrial(seeds=seeds, first=first, whole=False, chosen=faults).matrix()
        assert [
            f"{kill.fault} (seed {kill.seed}): {kill.sentence}" for kill in found.survivors()
        ] == []
        assert [f"{alarm.id}: {alarm.sentence}" for alarm in found.alarms] == []
        assert {kill.fault for kill in found.kills} == {fault.name for fault in faults}
        assert {kill.seed for kill in found.kills} == set(range(first, first + seeds))
        return found

    return matrix
