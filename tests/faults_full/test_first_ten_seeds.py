"""The whole kill matrix: every fault, and the engine without any, at the first ten of twenty random parameter sets."""

ELSEWHERE = {"capture", "cooling", "equilibrium", "second-integral", "top"}
"""Checks of elements that the transparent engine does not carry: tests/checks has the faults that they kill."""


def test_every_fault_is_killed_at_the_first_ten_seeds_and_every_check_kills(held):
    assert set(held(0).idle()) == ELSEWHERE
