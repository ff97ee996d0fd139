"""Area of a polygon in phase space: against quadrature of the local factor, against polygons of
many points, and its limits.
"""

from fractions import Fraction
from math import atan2, exp, floor, pi, sqrt

import pytest

from refdem.errors import NotCertifiedError
from refdem.truth.closed_forms.phase_flow import truth

GIVEN = {
    "flow": "coulomb",
    "mass": Fraction(1),
    "stiffness": Fraction(2),
    "delta": Fraction(1, 10),
    "friction_force": Fraction(5, 64),
    "length": Fraction(1),
    "gravity": Fraction(1),
}
KITE = [
    (Fraction(1, 2), Fraction(-1)),
    (Fraction(1), Fraction(-3, 4)),
    (Fraction(1, 2), Fraction(-1, 2)),
    (Fraction(1, 4), Fraction(-3, 4)),
]
SCALE = {f"{name}_{k}": 1.0 for k in range(4) for name in "xv"}


def kite(**changed):
    return truth({**GIVEN, **changed}, changed.get("corners", KITE), SCALE)


def area(found, t):
    ball = found.at(Fraction(t))["area"]
    assert ball.radius < Fraction(1, 10**38)
    return float(ball.mid)


def by_quadrature(t, f=5 / 64, k=2.0, m=1.0, n=400):
    """Midpoints of n x n cells of the kite's box: each cell times the product of (k|x| - f)/(k|x| +
    f) over its turning points so far.
    """
    total = 0.0
    w = sqrt(k / m)
    for i in range(n):
        for j in range(n):
            x = 0.25 + 0.75 * (i + 0.5) / n
            v = -1.0 + 0.5 * (j + 0.5) / n
            if x < 0.5:
                inside = abs(v + 0.75) * 4 < (x - 0.25) * 4
            else:
                inside = abs(v + 0.75) * 2 < 1.0 - x
            if not inside:
                continue
            angle = atan2(v / w, x - f / k)
            reach = sqrt((x - f / k) ** 2 + v * v / (k / m))
            factor = 1.0
            for turn in range(floor((w * t - angle) / pi)):
                place = reach - f / k - 2 * turn * f / k
                factor *= max(0.0, (k * place - f) / (k * place + f)) if place > 0 else 0.0
            total += factor * 0.75 * 0.5 / n**2
    return total


@pytest.mark.parametrize("t", ["1/2", "9/5", "5", "9"])
def test_dry_friction_multiplies_each_part_at_each_of_its_turning_points(t):
    assert area(kite(), t) == pytest.approx(by_quadrature(float(Fraction(t))), rel=2e-3)


def test_between_turning_points_dry_friction_keeps_the_area_and_at_the_end_nothing_is_left():
    first = float(kite().first_area())
    assert first == 0.1875
    assert area(kite(), 0) == area(kite(), "1/4") == first
    assert area(kite(), 3) == pytest.approx(area(kite(), "7/2"), rel=1e-15)
    assert area(kite(), 3) < first
    assert area(kite(), 100) == 0.0


def test_a_head_above_the_axis_has_the_areas_of_its_mirror_image():
    turned = kite(corners=[(-x, -v) for x, v in KITE])
    assert area(turned, "9/5") == area(kite(), "9/5")


def test_liouville_keeps_area_and_a_fluid_shrinks_it():
    assert area(kite(flow="harmonic"), 7) == area(kite(flow="pendulum"), 7) == 0.1875
    assert area(kite(flow="viscous"), 7) == pytest.approx(0.1875 * exp(-1.4), rel=1e-15)


def test_corners_move_as_their_oscillator_does_and_a_head_on_both_sides_has_no_area():
    balls = kite(flow="harmonic", stiffness=Fraction(1)).at(Fraction(1))
    cosine = 0.54030230586813972
    sine = 0.84147098480789651
    assert float(balls["x_1"].mid) == pytest.approx(cosine - 0.75 * sine, rel=1e-15)
    assert float(balls["v_1"].mid) == pytest.approx(-sine - 0.75 * cosine, rel=1e-15)
    with pytest.raises(NotCertifiedError):
        kite(corners=[(x, v + Fraction(3, 4)) for x, v in KITE]).at(Fraction(1))


def test_s_of_pendulums_counts_their_angles_and_rates_alone():
    """Places of the bobs are no quantities here: with scales of 4 rad and 4 rad/s an error grows by
    exp(t) at most, to which S adds a seventh at most, while that of a place would count 4 rods at
    once.
    """
    pendulums = truth({**GIVEN, "flow": "pendulum"}, KITE, dict.fromkeys(SCALE, 4.0))
    assert 1 <= pendulums.sensitivity(Fraction(1, 16)) < 8 / 7 * exp(1 / 16)
