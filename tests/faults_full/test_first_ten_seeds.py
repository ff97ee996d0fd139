"""The whole kill matrix: every fault, and the engine without any, at the first ten of twenty random parameter sets."""

ELSEWHERE = {"cooling", "roughness", "apsides"}
"""Checks of gases, which the transparent engine does not carry, and of orbits that turn: tests/checks has the faults that they kill."""


def test_every_fault_is_killed_at_the_first_ten_seeds_and_every_check_kills_one_that_is_named_for_it(held):
    assert set(held(0).idle()) == ELSEWHERE
