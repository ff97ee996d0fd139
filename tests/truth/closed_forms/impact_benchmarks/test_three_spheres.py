"""A sphere squeezed by two: against three bodies, each by its own equation (the witness), and what
must be kept.
"""

from fractions import Fraction
from functools import cache

import pytest

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery
from refdem.truth.certified.writing import rows
from refdem.truth.witnesses import cross_check

TINY = Fraction(1, 10**30)


@cache
def found(**given):
    instance = discovery.case("impact-benchmarks").at(member="three-spheres", **given)
    return instance, instance.truth()


@pytest.mark.parametrize(
    "given",
    [
        {"spin": "1", "partner_radius": "1/50", "friction": "50"},
        {"cutoff": "zero_overlap", "branch": "R"},
    ],
)
def test_it_is_the_motion_of_three_bodies(given):
    """Sticking all the time, and through every switch."""
    instance, truth = found(**given)
    times = [
        Fraction(float(instance.times[-1])) * part for part in (Fraction(1, 8), Fraction(3, 8))
    ]
    balls, _ = rows(truth.refined(36), times)
    said = cross_check.cross_checked("impact-benchmarks", instance.case.meant(instance.p), balls)
    assert (said["values"], said["denied"]) == (55, [])


def test_total_angular_momentum_is_kept_where_the_levers_add_up():
    instance, truth = found()
    v = member("three-spheres").values(instance.p)

    def total(t):
        now = {name: ball.mid for name, ball in truth.at(t).items()}
        orbital = sum(
            v.large * (now[f"r{n}.x"] * now[f"v{n}.y"] - now[f"r{n}.y"] * now[f"v{n}.x"])
            for n in (1, 3)
        )
        moments = (
            v.large * v.partner_radius**2,
            v.mass * v.radius**2,
            v.large * v.partner_radius**2,
        )
        return orbital + Fraction(2, 5) * sum(
            j * now[f"omega{n}.z"] for n, j in zip((1, 2, 3), moments, strict=True)
        )

    first, last = (total(Fraction(float(instance.times[k]))) for k in (1, -1))
    assert abs(first - last) < TINY * 1000


def test_mirror_images_stay_mirror_images_and_the_middle_one_where_it_is():
    instance, truth = found()
    now = {name: ball.mid for name, ball in truth.at(Fraction(float(instance.times[20]))).items()}
    assert all(now[f"{kind}1.{axis}"] == -now[f"{kind}3.{axis}"] for kind in "rv" for axis in "xy")
    assert now["r2.x"] == now["v2.y"] == 0
    assert now["omega2.z"] not in (0, 30)
