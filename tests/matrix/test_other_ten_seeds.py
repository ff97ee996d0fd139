"""The whole kill matrix: every fault, and the engine without any, at the other ten of twenty random
parameter sets.
"""


def test_every_fault_is_killed_at_the_other_ten_seeds(held):
    held(10)
