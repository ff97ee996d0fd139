"""The asymmetric field: literals, Taylor series from edge to edge, exact branches, work there and
back, planted slips.
"""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.asymmetric_field import AsymmetricField
from refdem.truth.witnesses.collisions import tent

STARTS = [
    ({}, "left rising falling right"),
    ({"x0": "3/4", "v0": "-1"}, "right falling rising falling right"),
    ({"x0": "1", "v0": "-3"}, "right falling rising left"),
    ({"x0": "1", "v0": "-1/8"}, "right falling right"),
    ({"x0": "-1/2", "v0": "0"}, "rising falling right"),
    ({"x0": "-1/2", "v0": "-3/4", "mass": "2"}, "rising left"),
    ({"x0": "-1/2", "v0": "-1/2"}, "rising"),
    ({"x0": "1/4", "v0": "1", "x2": "4", "k1": "3"}, "falling right"),
]


def at(given):
    return discovery.case("asymmetric-field").at(**given)


def apart(given):
    """How far truth and witness are apart, and the phases."""
    instance = at(given)
    truth = instance.truth()
    times = [Fraction(float(t)) for t in instance.times[3::6]]
    with precision(256):
        said = list(tent(instance.p, times, {}))
        worst = max(
            abs(v - arb_of((truth.scalars() if t is None else truth.at(t))[n].mid))
            for t, values in said
            for n, v in values.items()
        )
        return float(worst), " ".join(phase.region for phase in truth.phases())


@pytest.mark.parametrize(("given", "phases"), STARTS)
def test_truth_is_the_taylor_series_from_edge_to_edge(given, phases):
    worst, found = apart(given)
    assert found == phases
    assert worst < 1e-40


def test_states_are_those_of_the_formulas_with_mpmath():
    # mpmath at 45 digits: x(1) = -1 + sinh(3/4); x(5/4) on the falling flank, v at the end
    # sqrt(5/2)
    truth = at({}).truth()
    assert abs(
        truth.at(Fraction(1))["x"].mid - Fraction("-0.177683268064170019296338365553086151")
    ) < Fraction(1, 10**35)
    late = truth.at(Fraction(5, 4))
    assert abs(late["x"].mid - Fraction("0.17399688152108528969271877218044003")) < Fraction(
        1, 10**34
    )
    assert abs(late["v"].mid - Fraction("1.51242981109340918607018730966157588")) < Fraction(
        1, 10**34
    )


def test_work_is_gained_forward_and_lost_backward():
    forward = at({"duration": "10"}).truth()
    gained = forward.at(Fraction(10))["v"]
    speed = gained.mid
    assert abs(speed * speed / 2 - Fraction(1, 2) - forward.scalars()["work"].mid) < Fraction(
        1, 10**38
    )
    back = (
        at({"x0": "1", "v0": str(-Fraction(round(speed * 10**30), 10**30)), "duration": "10"})
        .truth()
        .at(Fraction(10))["v"]
    )
    assert abs(back.mid + 1) < Fraction(1, 10**28)


def test_on_the_separatrix_it_creeps_to_the_edge_for_ever():
    x = at({"x0": "-1/2", "v0": "-1/2", "duration": "20"}).truth().at(Fraction(20))["x"]
    assert abs(float(x.mid + 1) - 0.5 * 2.061153622438558e-09) < 1e-22  # exp(-20)/2


PLANTED = {
    "fall": (
        lambda sound: (
            lambda self, start: (
                sound(self, start) and (sound(self, start)[0] * 2, *sound(self, start)[1:])
            )
        )
    ),
    "lag": lambda sound: lambda self, eta, start: -sound(self, eta, start),
    "climb": (
        lambda sound: (
            lambda self, start: (
                sound(self, start) and (sound(self, start)[0] + 1, *sound(self, start)[1:])
            )
        )
    ),
}


@pytest.mark.parametrize(
    ("kind", "method"), [("fall", "descended"), ("lag", "lag"), ("climb", "climbed")]
)
def test_a_planted_slip_is_seen(monkeypatch, kind, method):
    monkeypatch.setattr(AsymmetricField, method, PLANTED[kind](getattr(AsymmetricField, method)))
    assert apart({})[0] > 1e-6
