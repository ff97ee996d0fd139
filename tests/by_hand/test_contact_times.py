"""Certified contact times against the speed, as dimensions alone have it."""

from fractions import Fraction

import pytest

from refdem.core.discovery import truth_of
from refdem.core.truth import Ball


def contact_time(case: str, speed: str) -> Ball:
    return truth_of(case, closing_speed=speed).scalars()["duration"]


@pytest.mark.parametrize("speed", ["1/8", "1", "3"])
def test_spheres_of_hertz_touch_half_as_long_at_32_times_the_speed(speed: str) -> None:
    """m d'' = -k d^(3/2) has the one time (m^2/(k^2 v))^(1/5)."""
    slow = contact_time("hertz-spheres", speed)
    fast = contact_time("hertz-spheres", str(32 * Fraction(speed)))
    off = abs(slow.mid - 2 * fast.mid)
    assert off <= slow.radius + 2 * fast.radius
    assert slow.radius < slow.mid / 10**20


@pytest.mark.parametrize("speed", ["1/8", "1/5", "1/3"])
def test_spheres_of_a_linear_law_touch_as_long_at_every_speed(speed: str) -> None:
    """m d'' = -k d - c d' is linear: d/v does not depend on v."""
    slow = contact_time("two-spheres", speed)
    fast = contact_time("two-spheres", str(32 * Fraction(speed)))
    assert abs(slow.mid - fast.mid) <= slow.radius + fast.radius
    assert slow.radius < slow.mid / 10**20
