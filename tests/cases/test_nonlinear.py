"""Scales where a drive carries a mass over the rim of its well: those of the place it comes to."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.sampled import sampled

OUT = [
    ("driven-duffing", {"beta": "-0.235", "f0": "1440", "duration": "0.25", "samples": "16"}),
    ("driven-duffing", {"beta": "-0.4", "x0": "0", "duration": "3", "samples": "16"}),
    ("quadratic-response", {"f0": "5,5", "duration": "2", "samples": "16"}),
    ("quadratic-response", {"f0": "0,-3", "drive": "0,0", "duration": "4", "samples": "16"}),
]


@pytest.mark.parametrize(("name", "given"), OUT)
def test_the_length_is_that_of_the_place_to_which_a_drive_carries_the_mass(name, given):
    instance = discovery.case(name).at(**given)
    truth = instance.truth()
    places = []
    for t in instance.times:
        try:
            places.append(abs(float(truth.at(Fraction(t))["x"].mid)))
        except NotCertifiedError:
            break
    # Samples see the largest place but for what lies between two of them.
    assert len(places) > 8
    assert 0.9 * max(places) <= instance.scales.length
    assert instance.scales.length <= max(1.2 * max(places), 20.0)


def test_a_drive_that_does_not_carry_it_out_leaves_the_scales_of_the_well():
    inside = discovery.case("driven-duffing").at(beta="-0.1", f0="0.1")
    assert 1.0 < inside.scales.length < 1.2
    fast = discovery.case("driven-duffing").at(beta="-0.235", f0="1440", drive="100", x0="0")
    assert fast.scales.length <= np.sqrt(1 / 0.235)


@pytest.mark.parametrize("beside", ["-65/32", "-61/32"])
def test_a_start_beside_the_middle_of_three_amplitudes_leaves_it_for_the_small_one(beside):
    """Harmonic balance has 0.707, 2.401 and 2.944 m at 9/5 rad/s; the middle one starts at x =
    -1.962 m, v = 2.490 m/s.
    """
    instance = discovery.case("driven-duffing").at(
        drive="9/5", x0=beside, v0="5/2", duration="64", samples="256"
    )
    places = abs(sampled(instance.truth(), instance.times.tolist()).value("x"))
    assert 2 < np.max(places[:16]) < 2.6
    assert np.max(places[-32:]) == pytest.approx(0.717, abs=0.02)
