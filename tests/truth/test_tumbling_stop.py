"""A corner that presses on a slope is proved to stop where friction takes its slip, and nowhere
else.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.neglected_gyroscopic import slope
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.scout import PROBES, EventScout
from refdem.truth.events.system import Entry, TracedModes
from refdem.truth.tumbling_contact import Modes, lean_rates
from refdem.truth.tumbling_stop import first_stop

CORNER = 6
NAME = f"{CORNER}p"
BITS = 192
NEAR_STOP = (
    *("-0.958947491858", "0.204641342248", "-0.0758648370469", "0.181069476726"),
    *("-0.000537526592758", "0.000219340384965", "0.0011218099762"),
    *("-0.00999038535754", "-7.85020306963e-05", "0.0183038536983"),
    *("0.239149954346", "-0.181911129696", "-0.604953342671", "0"),
)
"""The state of the box of friction 1 at 0.129703779 s, in the axes of the slope: corner 6 slips at
1.35e-3 m/s, which falls at 206 m/s^2.
"""


def system(friction):
    return slope(discovery.case("neglected-gyroscopic").at(member="slope", friction=friction).p)


def modes(friction):
    return Modes(system(friction), first_stop)


def state(**changes):
    values = list(NEAR_STOP)
    for place, value in changes.items():
        values[int(place.removeprefix("y"))] = value
    return [arb_of(Fraction(value)) for value in values]


def begun(friction):
    """The motion from there, with all pieces up to the first one at whose end a stop is sought."""
    traced = TracedModes(modes(friction), 14, lean_rates)
    with precision(BITS):
        motion = HybridMotion(traced, state(), Entry(NAME), BITS)
    while len(motion.phases[-1].pieces) < PROBES:
        motion.follow()
    return motion


def test_a_slip_that_friction_takes_ends_at_the_time_that_its_rate_says():
    bound = modes("1")[NAME].stops(state())
    assert 1.35e-3 / 206 < bound < 1.3 * 1.35e-3 / 206


@pytest.mark.parametrize("friction", ["1/5", "1/2"])
def test_a_friction_that_does_not_hold_the_corner_proves_no_stop(friction):
    assert modes(friction)[NAME].stops(state()) is None


def test_without_friction_there_is_nothing_to_prove():
    assert modes("0")[NAME].stops is None


def test_a_corner_that_slips_fast_is_not_proved_to_stop():
    assert modes("1")[NAME].stops(state(y10="2.24")) is None


def test_a_set_as_wide_as_its_slip_is_not_proved_to_stop():
    wide = [value + arb(0, 2e-3) for value in state()]
    assert modes("1")[NAME].stops(wide) is None


def test_a_time_after_the_stop_is_refused_at_once_and_one_before_is_certified():
    motion = begun("1")
    with precision(BITS):
        before = motion.at(arb_of(Fraction(5, 10**7)))
        with pytest.raises(SwitchError, match="runs into a singularity by t =") as caught:
            motion.at(arb_of(Fraction(1, 100)))
    assert (caught.value.code, caught.value.final) == ("singular", True)
    assert max(float(value.rad()) for value in before) < 1e-40
    assert len(motion.phases[-1].pieces) < 40


def test_a_scout_counts_no_pieces_beyond_a_stop():
    scout = EventScout(begun("1"))
    scout.go_on(1000, 1.0)
    assert scout.is_over
    assert scout.clock(1.0) == scout.pieces[-1] < 40
