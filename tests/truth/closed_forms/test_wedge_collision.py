"""The wedge: Taylor series of both laws, energies by hand, what a turn gains or loses."""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.wedge_collision import WedgeCollision
from refdem.truth.witnesses.collisions import wedge


def apart(given):
    instance = discovery.case("wedge-collision").at(**given)
    truth = instance.truth()
    times = [Fraction(float(t)) for t in instance.times[2::7]]
    with precision(256):
        said = list(wedge(instance.p, times, {}))
        return float(
            max(
                abs(v - arb_of((truth.scalars() if t is None else truth.at(t))[n].mid))
                for t, values in said
                for n, v in values.items()
            )
        )


@pytest.mark.parametrize(
    "given", [{}, {"k1": "20", "mass": "3"}, {"k2": "1/100", "closing_speed": "5"}]
)
def test_truth_is_the_taylor_series_of_both_laws(given):
    assert apart(given) < 1e-40


def test_half_of_the_energy_is_lost_and_the_duration_is_that_of_mpmath():
    # d_m = (3/24)^(1/3) = 1/2, E' = k1 d_m^2/2 = 1/4; B(1/3, 1/2)/6 + pi/(2 sqrt 2) with mpmath at
    # 45 digits
    scalars = discovery.case("wedge-collision").at().truth().scalars()
    assert abs(scalars["max_overlap"].mid - Fraction(1, 2)) < Fraction(1, 10**38)
    assert abs(scalars["energy_change"].mid + Fraction(1, 4)) < Fraction(1, 10**38)
    assert abs(
        scalars["duration"].mid - Fraction("1.81181178720231869234147978704032049238516653")
    ) < Fraction(1, 10**38)


@pytest.mark.parametrize(("k1", "sign"), [("2", -1), ("20", 1)])
def test_energy_is_gained_where_the_flat_side_is_stiff_enough(k1, sign):
    # E' > E if and only if k1 > 2 k2 d_m/3 = 4
    assert (
        discovery.case("wedge-collision").at(k1=k1).truth().scalars()["energy_change"].mid * sign
        > 0
    )


def test_a_wrong_law_on_the_way_out_is_seen(monkeypatch):
    sound = WedgeCollision.rate
    monkeypatch.setattr(
        WedgeCollision, "rate", lambda self: sound(self) * arb_of(Fraction(101, 100))
    )
    assert apart({}) > 1e-4
