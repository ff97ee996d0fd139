"""The whole kill matrix: every fault at twenty random parameter sets, and the engine without any at each of them."""

from refdem.campaign.kills import Trial

SEEDS = 20


def test_every_fault_is_killed_at_every_seed_and_the_correct_engine_never_alarms():
    matrix = Trial(seeds=SEEDS).matrix()
    assert [f"{kill.fault} (seed {kill.seed}): {kill.sentence}" for kill in matrix.survivors()] == []
    assert [f"{alarm.id}: {alarm.sentence}" for alarm in matrix.alarms] == []
    assert matrix.idle() == []
    assert len(matrix.kills) >= 60 * SEEDS
