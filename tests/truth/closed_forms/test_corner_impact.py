"""The corner of a box: the witness, the derivative across the impact, and a second corner."""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.corner_impact import Box, CornerImpact
from refdem.truth.witnesses.corner_impact import corner

CASE = discovery.case("corner-impact")
TALL = {"sides": "1/2,2", "angle": "1/3", "restitution": "1/3", "mass": "7"}


def apart(given):
    """The largest difference of truth and witness."""
    instance = CASE.at(**given)
    truth = instance.truth()
    times = [Fraction(float(t)) for t in instance.times[2::7]]
    with precision(256):
        said = list(corner(instance.p, times, {}))
        differences = []
        for t, values in said:
            known = truth.scalars() if t is None else truth.at(t)
            differences += [abs(value - arb_of(known[n].mid)) for n, value in values.items()]
        return float(max(differences))


@pytest.mark.parametrize("given", [{}, TALL, {"angle": "1.5", "restitution": "1"}])
def test_truth_is_what_the_balance_equations_say(given):
    assert apart(given) < 1e-35


def test_an_arm_that_is_forgotten_is_seen(monkeypatch):
    sound = CornerImpact.ease
    monkeypatch.setattr(CornerImpact, "ease", lambda self, p: sound(self, p * 0))
    assert apart({}) > 1e-2


def test_a_square_on_its_corner_does_not_turn_and_bounces_as_a_sphere():
    body = Box(mass=Fraction(2), sides=(Fraction(1), Fraction(1)), restitution=Fraction(1, 2))
    with precision(256):
        p, d = body.arm(arb_of(1).atan())
        assert float(abs(p)) < 1e-70
        assert float(abs(d * d - arb_of(Fraction(1, 2)))) < 1e-70


def test_a_time_at_which_a_second_corner_may_have_come_down_is_not_certified():
    truth = CASE.at(angle="1/16").truth()
    truth.at(Fraction(1))
    with pytest.raises(NotCertifiedError, match="second corner"):
        truth.at(Fraction(4))


def test_a_start_that_turns_meets_the_plane_where_its_lowest_corner_does():
    truth = CASE.at().truth().displaced(5, Fraction(1, 100))
    with precision(256):
        touch = truth.touch()
        gap = touch.before[1] - touch.d
        assert float(abs(gap.mid())) < 1e-60
    assert float(touch.time) != pytest.approx(
        float(CASE.at().truth().scalars()["impact_time"].mid), abs=1e-6
    )


def test_half_of_s_is_less_than_what_errors_grow_to():
    """The derivative by differences: of omega before the impact, in vy and omega after it."""
    truth = CASE.at().truth()
    t = Fraction(3, 2)
    size = Fraction(1, 10**12)
    base = truth.at(t)
    rows = dict.fromkeys(truth.state, 0.0)
    for axis, of_start in enumerate(truth.state):
        moved = truth.displaced(axis, size * truth.scale[of_start]).at(t)
        for name in truth.state:
            change = (moved[name].mid - base[name].mid) / truth.scale[name] / size
            rows[name] += abs(float(change))
    assert max(rows.values()) <= truth.sensitivity(t) * (1 + 1e-6)
    assert max(rows.values()) > truth.sensitivity(t) / 2
