"""Points of sections: literals of an independent integration, a motion known on paper, both
directions, displaced starts, and honest ends.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.core import discovery
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import poincare_sections

# mpmath.odefun (Taylor, 60 digits) phase by phase, events by Anderson's regula falsi; 44 digits
LITERALS = {
    "strobe-1": (
        "-4.82342231228633811089954791786327750643019903",
        "1.69857228343538995351440745726169531501462574",
    ),
    "strobe-2": (
        "1.95408800333711613876154690906321664678585084",
        "1.0",
    ),
    "strobe-3": (
        "-5.39152109239007604534961015513717483073231465",
        "2.72175873295417105913118752251780236189577327",
    ),
    "passage-1": (
        "1.69462162104631290515241527790206586660608118",
        "2.43330132491400283285487073710923018305340416",
    ),
    "passage-2": (
        "11.4465019076838367715785657090023191206407364",
        "3.16121645680644999129545443994725054139242066",
    ),
    "passage-3": (
        "17.6953032514607911104542596879539853560724597",
        "0.66613418425298774336658011892212668710216455",
    ),
    "passage-4": (
        "22.7126863638932273239180355362226225957018743",
        "0.67631066795045915477773821372899361814992275",
    ),
}
GLIDING = {
    "a": "1",
    "mu0": "1/2",
    "mu1": "1/2",
    "lambda0": "0",
    "lambda1": "0",
    "belt": "10",
    "gamma": "0",
    "eta": "5",
    "x0": "1",
    "v0": "0",
}
"""It slips for ever, and friction balances the steady pull: x = cos t."""
DAMPED = GLIDING | {"a": "10", "lambda1": "1", "x0": "-1"}
"""Friction that grows tenfold faster than what a swing needs: it creeps to x = 0 from below."""


def truth_of(**given):
    """The truth at parameters."""
    return discovery.case("poincare-sections").at(**given).truth()


def test_points_are_those_of_an_independent_integration():
    found = truth_of().refined(40).scalars()
    assert set(found) == {f"{name}.{i}" for name in LITERALS for i in range(2)}
    for name, said in LITERALS.items():
        for i, text in enumerate(said):
            ball = found[f"{name}.{i}"]
            assert abs(ball.mid - Fraction(text)) < Fraction(1, 10**40)
            assert ball.radius < Fraction(1, 10**40)


def test_points_of_a_swing_without_loss_are_those_on_paper():
    found = truth_of(**GLIDING).scalars()
    with precision(200):
        expected = {}
        for n in range(1, 5):
            expected |= {f"passage-{n}.0": 2 * n * arb.pi(), f"passage-{n}.1": arb(1)}
        for n in range(1, 4):
            angle = 2 * n * arb.pi() / 5
            expected |= {f"strobe-{n}.0": angle.cos(), f"strobe-{n}.1": -angle.sin()}
        assert set(expected) == set(found)
        for name, value in expected.items():
            off = abs(value - arb_of(found[name].mid))
            assert off < arb_of(found[name].radius + Fraction(1, 10**50)), name


def test_passages_rise_and_fall():
    given = {"x0": "1", "v0": "-1/2", "gamma": "5/2", "eta": "6/5"}
    truth = truth_of(**given)
    with precision(256):
        motion = truth.flow.motion(256)
        passages = truth.passages(motion)
    modes = [event.mode for event in passages]
    # From v < 0 it rises to v > 0 first, and falls from there.
    assert modes[:2] == [poincare_sections.BACKWARD, poincare_sections.RETREAT]
    assert all(float(event.state[0]) > 0 for event in passages)


def test_the_growth_bounds_what_a_displaced_start_does_to_any_point():
    given = {"x0": "1", "v0": "1/2"}
    instance = discovery.case("poincare-sections").at(**given)
    sizes = instance.case.of_motion(instance.p)
    amount = Fraction(1, 2**60)
    truth = instance.truth().refined(40)
    points = truth.scalars()
    grown = []
    for name in ("x0", "v0"):
        off = truth_of(**given | {name: str(Fraction(given[name]) + amount)}).refined(40).scalars()
        shift = float(amount) / sizes[name[0]]
        grown += [
            abs(float(off[point].mid - ball.mid)) / instance.quantities[point].scale / shift
            for point, ball in points.items()
        ]
    # Errors of the start fade while it sticks; S counts those that are made later, too. The scale
    # of a point has its phase in it, up to PASSAGES times 2 pi.
    assert 0.1 < max(grown) < truth.sensitivity(Fraction(0)) < 20


def test_a_motion_that_does_not_come_to_the_section_is_not_certified():
    with pytest.raises(NotCertifiedError, match="only 0 times in 16 periods"):
        truth_of(**DAMPED).constants()


def test_a_start_on_the_section_without_a_force_is_refused():
    with pytest.raises(UsageError, match="x0"):
        discovery.case("poincare-sections").at(x0="2", v0="0")


def test_a_section_without_its_event_lacks_every_passage(monkeypatch):
    """As a test of the tests: with the modes of the motion alone nothing passes."""
    monkeypatch.setattr(poincare_sections.Sectioned, "modes", lambda self: self.oscillator.modes())
    with pytest.raises(NotCertifiedError, match="only 0 times"):
        truth_of().constants()
