"""Hertz's law, the piecewise linear field and the wall for wedges as elements: potentials,
dimensions, what they refuse.
"""

import numpy as np
import pytest

from refdem.errors import SceneError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.wedge import Wedge

FIELD = PiecewiseField(k1=2.0, k2=-4.0, x1=-1.0, x2=0.5)
WALL = Wedge(quadratic=12.0, stiffness=2.0)
EDGE = np.array([np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)])


def at(places, attitude=(1.0, 0.0, 0.0, 0.0)):
    """Positions (T, 1, 3) on x and attitudes."""
    position = np.zeros((len(places), 1, 3))
    position[:, 0, 0] = places
    return position, np.broadcast_to(np.array(attitude), (len(places), 1, 4))


def test_the_potential_of_the_field_is_minus_the_integral_of_its_force():
    grid = np.linspace(-1.5, 1.0, 20001)
    force = FIELD.strength(grid)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(grid))])
    scene = Scene.of([Body(mass=1.0)], [FIELD])
    assert np.abs(FIELD.potential(scene, *at(grid)) + integral).max() < 1e-7
    assert FIELD.potential(scene, *at([9.0]))[0] == -1.5
    assert force.max() == pytest.approx(2.0)


def test_the_potential_of_the_wall_is_that_of_the_side_that_looks_at_it():
    scene = Scene.of([Body(mass=1.0, inertia=(1.0, 1.0, 1.0))], [WALL])
    assert WALL.potential(scene, *at([-1.0, 0.5], EDGE)) == pytest.approx([0.0, 0.5])
    assert WALL.potential(
        scene, *at([-1.0, 0.5], (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    ) == pytest.approx([0.0, 0.25])
    assert WALL.reversible
    assert not WALL.conservative


def test_hertz_holds_two_fifths_of_the_force_times_the_overlap():
    spheres = [
        Body(mass=1.0, inertia=(0.4,) * 3, shape=Sphere(radius=1.0), position=(side, 0.0, 0.0))
        for side in (-0.875, 0.875)
    ]
    law = Contact(law="hertz", stiffness=10.0)
    scene = Scene.of(spheres, [law])
    held = scene.potential(scene.bodies.position[None], scene.bodies.attitude[None])[0]
    assert held == pytest.approx(0.4 * 10.0 * 0.25**2.5)
    assert law.dimension("stiffness") == (1, -0.5, -2)
    assert Contact(law="linear", stiffness=10.0).dimension("stiffness") == (1, 0, -2)
    assert "contact:hertz" in scene.features


@pytest.mark.parametrize(
    ("element", "reason"),
    [
        (Contact(law="hertz", stiffness=1.0, damping=1.0), "damping is 1.0, expected 0"),
        (Contact(law="hertz"), "stiffness"),
        (PiecewiseField(k1=1.0, k2=-1.0, x1=-1.0, x2=0.5), "continuous"),
        (PiecewiseField(k1=-1.0, k2=-1.0, x1=-1.0, x2=1.0), "expected x1 < 0 < x2"),
        (PiecewiseField(k1=1.0, k2=-1.0, x1=-1.0, x2=1.0, axis=(1.0, 1.0, 0.0)), "axis"),
        (Wedge(quadratic=0.0, stiffness=1.0), "quadratic"),
        (Wedge(quadratic=1.0, stiffness=1.0, normal=(2.0, 0.0, 0.0)), "normal"),
    ],
)
def test_what_is_not_physical_is_refused(element, reason):
    with pytest.raises(SceneError, match=reason):
        Scene.of([Body(mass=1.0)], [element])
