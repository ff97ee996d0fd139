"""The growth of an error that leads out of the line in which spheres move."""

import numpy as np
import pytest

from refdem.checks._impacts import Impact, growth_across
from refdem.core import discovery
from refdem.scene.elements.contact import Contact


def test_two_equal_spheres_part_along_their_line_of_centres() -> None:
    """Spheres of the radius R that are off by y_1 and y_2 as they meet, with the closing speed w,
    change their velocities across the line of motion by -+ (1 + e)/2 w (y_2 - y_1)/(2 R).
    """
    given = {"masses": "2,2,1,1,1,1,1", "radii": "0.25,0.25,1,1,1,1,1"}
    instance = discovery.case("newtons-cradle").at(**given)
    (law,) = instance.scene.all(Contact)
    length, speed = instance.scales.length, instance.scales.speed
    t = instance.times
    met = float(t[2] + t[3]) / 2
    growth = growth_across(instance, [Impact(met, 0.0, 8.0, (0, 1))])
    # Velocity across the line that an offset gives [1/s].
    kick = (1 + law.restitution) / 2 * 8.0 / 0.5
    since = t - met
    # What errors of all four numbers do to a place, in units of the length, and to a velocity.
    of_place = 1 + 2 * kick * since + (t + 2 * kick * since * met) * speed / length
    of_velocity = 1 + 2 * kick * met + 2 * kick * length / speed
    expected = np.where(t < met, 1.0, np.maximum(of_place, of_velocity))
    assert growth == pytest.approx(expected)


def test_without_an_impact_nothing_grows() -> None:
    instance = discovery.case("newtons-cradle").at()
    assert np.all(growth_across(instance, []) == 1.0)
