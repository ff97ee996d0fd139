"""The whole kill matrix, in two halves that two workers share."""

import pytest

from refdem.campaign.kills import Matrix, Trial

SEEDS = 10


@pytest.fixture
def held():
    """The matrix of ten seeds from `first` on, after it has been seen that all is killed and the correct engine never alarms."""

    def matrix(first: int) -> Matrix:
        found = Trial(seeds=SEEDS, first=first, whole=False).matrix()
        assert [f"{kill.fault} (seed {kill.seed}): {kill.sentence}" for kill in found.survivors()] == []
        assert [f"{alarm.id}: {alarm.sentence}" for alarm in found.alarms] == []
        assert len(found.kills) >= 60 * SEEDS
        return found

    return matrix
