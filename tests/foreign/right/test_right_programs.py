"""Programs that are right raise no alarm at settings drawn over the whole range of the cases that
they support; each run draws others, by the seed that it prints.
"""

import os

import alarms
from alarms import Count

PAIRS = 300
SECONDS = 60.0
"""Of one run: it judges fewer pairs on a slow machine."""
FEWEST = 20
"""Pairs that must have decided something, or the draws are no test."""


def drawn(pairs: int, seed: int) -> Count:
    """Pairs judged with a seed that is printed."""
    print(f"repeat with: .venv/bin/python ci/alarms.py --pairs {pairs} --seed {seed}")
    count = alarms.alarms(pairs, seed, SECONDS)
    print(count.summary())
    return count


def test_right_programs_raise_no_alarm_at_settings_drawn_at_random() -> None:
    seed = int(os.environ.get("REFDEM_ALARM_SEED", int.from_bytes(os.urandom(4), "big")))
    count = drawn(PAIRS, seed)
    assert count.judged >= FEWEST
    assert count.outcomes["pass"] > count.judged
    assert count.alarms == []


def test_a_seed_draws_the_same_settings_again() -> None:
    first, again = (
        [instance.label for instance in alarms.settings_of(alarms.CASES, seed=3, count=5)]
        for _ in range(2)
    )
    assert first == again
