"""A scout through events comes through the modes of the proof, and counts its pieces ahead."""

from fractions import Fraction

import pytest

from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.scout import PROBES, EventScout, can_be_scouted
from refdem.truth.events.system import Entry, Guard, Mode
from tests.truth.events.systems import motion

END = 5


def two_springs(*, leaves=None, then="soft"):
    """x'' = -x - 4 x^3 above 0, and x'' = -400 x - 1000 x^3 below it."""
    press = Guard("press", lambda y: y[0], lambda y: Entry("hard", None, {"part": 1}))
    part = Guard("part", lambda y: -y[0], lambda y: Entry(then, None, {"press": 1}))
    soft = Mode(spring(1, 4), (press,), leaves)
    hard = Mode(spring(400, 1000), (part,), window=Fraction(1, 16))
    return {"soft": soft, "hard": hard}


def spring(stiffness, cubic):
    """The rates of place, velocity and clock under the force -k x - c x^3 on 1 kg."""

    def rates(y):
        x, v, _ = y
        return [v, -stiffness * x - cubic * x * x * x, 1]

    return rates


def begun(modes) -> HybridMotion:
    """The motion from x = 1 at rest, with the first pieces of its proof, before its first event."""
    run = motion(modes, [1, 0, 0], "soft")
    while len(run.phases[-1].pieces) < PROBES:
        run.follow()
    assert not run.events
    return run


def test_a_scout_counts_the_pieces_that_the_proof_then_makes_and_comes_to_its_events():
    """Ahead of the first event, of which nothing that was proved tells anything."""
    run = begun(two_springs())
    made = len(run.phases[-1].pieces)
    scout = EventScout(run)
    scout.go_on(1000, END)
    assert not scout.ended
    while run.reached() < END:
        run.follow()
    assert len(run.events) > 4
    for event in run.events:
        time = float(event.time)
        assert min(abs(one - time) for one in scout.times) < 1e-9
    pieces = sum(len(phase.pieces) for phase in run.phases) - made
    end = float(run.reached())
    assert pieces / 1.4 < scout.clock(end) < 1.4 * pieces
    # The modes differ in how many pieces a step is.
    soft, hard = (scout.pieces_per_step[id(run.modes[name])] for name in ("soft", "hard"))
    assert soft > 2 * hard


def test_a_scout_of_a_motion_that_ends_counts_no_pieces_beyond():
    run = begun(two_springs(then=None))
    scout = EventScout(run)
    scout.go_on(1000, END)
    assert scout.ended
    while not run.over():
        run.follow()
    assert scout.times[-1] == pytest.approx(float(run.events[-1].time))
    assert scout.clock(END) == scout.clock(scout.times[-1])


def test_modes_that_are_left_by_a_closed_form_are_not_scouted():
    assert can_be_scouted(begun(two_springs()))
    assert not can_be_scouted(motion(two_springs(leaves=lambda y: None), [1, 0, 0], "soft"))
