"""Programs that are right raise no alarm at settings drawn over the whole range of the cases that
they support; each change of the tree draws others, by the seed that is printed.
"""

import os
import subprocess

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


def seed_of_tree() -> int:
    """A seed that every change of the tree changes, so that what a commit was tested with can be
    repeated; a random one outside of a repository.
    """
    asked = os.environ.get("REFDEM_ALARM_SEED")
    if asked is not None:
        return int(asked)
    tree = subprocess.run(
        ["git", "rev-parse", "HEAD^{tree}"], cwd=alarms.ROOT, capture_output=True, text=True
    )
    if tree.returncode == 0:
        return int(tree.stdout[:8], 16)
    return int.from_bytes(os.urandom(4), "big")


def test_right_programs_raise_no_alarm_at_settings_drawn_at_random() -> None:
    count = drawn(PAIRS, seed_of_tree())
    assert count.judged >= FEWEST
    assert count.outcomes["pass"] > count.judged
    assert count.alarms == []


def test_a_seed_draws_the_same_settings_again() -> None:
    first, again = (
        [instance.label for instance in alarms.settings_of(alarms.CASES, seed=3, count=5)]
        for _ in range(2)
    )
    assert first == again
