"""A zero exactly where a piece of the integration ends is found, and a precision below the finest
split does not split for ever.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.dual import parameters, slopes_of
from refdem.truth.events.crossing import Along, SwitchError, Watched, carried_crossing
from refdem.truth.events.motion import HybridMotion
from refdem.truth.events.system import Entry, Guard, Mode, Traced


def running(level: Fraction, bits: int) -> HybridMotion:
    """x' = v' = 0 but x = t and a fast wave beside it, until x is at the level."""
    stop = Guard("stop", lambda y: level - y[0], lambda y: Entry("rest"))
    modes = {
        "run": Mode(lambda y: [1, 16 * y[2], -16 * y[1], 1], (stop,), window=Fraction(8)),
        "rest": Mode(lambda y: [0, 0, 0, 1]),
    }
    start = [arb(0), arb(1), arb(0), arb(0)]
    return HybridMotion(
        {name: Traced(mode, 4) for name, mode in modes.items()}, start, Entry("run"), bits
    )


def test_a_zero_at_the_end_of_a_piece_is_an_event() -> None:
    probe = running(Fraction(10), 192)
    probe.follow()
    end = probe.phases[0].pieces[0].end
    motion = running(end, 192)
    assert motion.at(arb(2))[0].contains(arb(end.numerator) / end.denominator)
    assert [event.name for event in motion.events] == ["stop"]
    assert motion.phases[0].pieces[0].end == end


def test_few_bits_do_not_split_for_ever() -> None:
    """A set that is through the level in part is undecided, also where the finest split is below
    the bits.
    """
    stop = Guard("stop", lambda y: 1 - y[0], lambda y: Entry("rest"))
    modes = {
        "run": Traced(Mode(lambda y: [1, 1], (stop,)), 2),
        "rest": Traced(Mode(lambda y: [0, 1]), 2),
    }
    motion = HybridMotion(modes, [arb(0, 0.5), arb(0)], Entry("run"), 48)
    with pytest.raises(SwitchError):
        motion.at(arb(1))


def test_a_crossing_carries_the_derivatives_of_its_function() -> None:
    """x^2 = p at x = sqrt(p), with the derivative 1/(2 sqrt p); a later one does not matter."""
    (p,) = parameters([arb(2)])
    square: list[Along] = [lambda x: p - x * x, lambda x: -2 * x]
    later: list[Along] = [lambda x: 2 * p - x, lambda x: arb(-1)]
    found = carried_crossing([Watched("later", later), Watched("square", square)], arb(0), arb(5))
    assert found is not None
    name, x = found
    assert name == "square"
    (slope,) = slopes_of(x)
    assert slope.overlaps(arb(1) / (2 * arb(2).sqrt()))
    assert slope.rad() < 1e-12
