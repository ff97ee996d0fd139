"""The shortest time of coupled pendulums: bobs that pass each other closely shorten it."""

import math

import pytest

from refdem.cases.coupled_pendulums import CASE

START = {"masses": "1000,1", "theta0": "0,-1", "stiffness": "0.5", "duration": "1"}


def tau_of(distance: str, **changed: str) -> float:
    given = {**START, "distance": distance, **changed}
    return CASE.at(**given).scales.tau


@pytest.mark.parametrize("gap", ["0.02", "0.005"])
def test_tau_is_of_the_turn_of_a_spring_between_bobs_that_pass(gap):
    # The first bob hangs, and the second falls past it at a gap: at the bottom its rod, shorter by
    # the gap, has the speed v = sqrt(2 g l (1 - cos 1)), and the spring turns at the rate v/gap.
    distance = 1e-9
    lengths = f"1,{1 - float(gap)}"
    tau = tau_of(str(distance), lengths=lengths, spring_length="1")
    speed = math.sqrt(2 * 9.8125 * (1 - math.cos(1)))
    turn = float(gap) / speed
    # A weak spring counts by the eighth root of its share, which is between 0.3 and 1.
    assert turn < tau < turn / 0.3


def test_bobs_that_do_not_meet_leave_tau_alone():
    apart = tau_of("3", spring_length="3", duration="0.1")
    assert apart == tau_of("3", spring_length="3", duration="0.01")


def test_a_spring_without_a_length_has_no_direction_to_turn():
    assert tau_of("1e-9", lengths="1,0.99", spring_length="0") > 0.1
