"""Pictures of a scene, number by number: shift, boost, rotation, mirror, order, units and delay."""

from math import sqrt

import numpy as np
import pytest

from refdem.core import stability, symmetry
from refdem.core.quantity import Scales
from refdem.core.symmetry import Symmetry
from refdem.scene import Body, Polyhedron, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import instance, near, standing

QUARTER = np.array([1.0, 0.0, 0.0, 1.0]) / sqrt(2.0)
"""A quarter of a turn about z: x becomes y."""
FIRST = Body(
    mass=2.0,
    inertia=(1.0, 2.0, 2.5),
    position=(1.0, 2.0, 3.0),
    velocity=(4.0, 5.0, 6.0),
    omega=(7.0, 8.0, 9.0),
    shape=Sphere(radius=0.5),
)
POINT = Body(mass=3.0, position=(-1.0, 0.0, 0.0), attitude=(0.6, 0.8, 0.0, 0.0))


def shown(by, elements=(), bodies=(FIRST, POINT)):
    """The motion of two bodies as a symmetry shows it."""
    return by.applied(instance(list(bodies), elements, times=(0.0, 2.0)).motion)


def test_an_image_shares_the_columns_that_are_as_they_were_to_the_last_bit():
    motion = instance([FIRST, POINT], times=(0.0, 2.0)).motion
    bodies = motion.scene.bodies
    shifted = Symmetry(shift=np.array([1.0, 0.0, 0.0])).applied(motion).scene.bodies
    assert shifted.velocity is bodies.velocity
    assert shifted.attitude is bodies.attitude
    assert shifted.position is not bodies.position
    # -0 equals 0, but not to the last bit.
    mirrored = Symmetry(mirrored=True).applied(motion).scene.bodies
    assert np.signbit(mirrored.velocity).any()
    assert mirrored.attitude is not bodies.attitude


def test_a_quarter_turn_takes_x_to_y_and_turns_bodies_but_not_points():
    bodies = shown(Symmetry(turn=QUARTER)).scene.bodies
    np.testing.assert_allclose(bodies.position[0], [-2.0, 1.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(bodies.velocity[0], [-5.0, 4.0, 6.0], atol=1e-14)
    np.testing.assert_allclose(bodies.omega[0], [-8.0, 7.0, 9.0], atol=1e-14)
    np.testing.assert_allclose(bodies.attitude[0], QUARTER, atol=1e-15)
    assert bodies.attitude[1].tolist() == [0.6, 0.8, 0.0, 0.0]


def test_a_mirror_turns_spins_the_other_way():
    bodies = shown(Symmetry(mirrored=True)).scene.bodies
    assert bodies.position[0].tolist() == [-1.0, 2.0, 3.0]
    assert bodies.velocity[0].tolist() == [-4.0, 5.0, 6.0]
    assert bodies.omega[0].tolist() == [7.0, -8.0, -9.0]


def test_shift_and_boost_are_added_in_units():
    by = Symmetry(
        shift=np.array([1.0, 0, 0]), boost=np.array([0, 2.0, 0]), units=(3.0, 5.0, 4.0), delay=7.0
    )
    motion = shown(by)
    bodies = motion.scene.bodies
    assert motion.times.tolist() == [7.0, 15.0]
    assert bodies.mass.tolist() == [6.0, 9.0]
    assert bodies.inertia[0].tolist() == [75.0, 150.0, 187.5]
    assert bodies.position[0].tolist() == [10.0, 10.0, 15.0]
    assert bodies.velocity[0].tolist() == [5.0, 8.75, 7.5]
    assert bodies.omega[0].tolist() == [1.75, 2.0, 2.25]
    assert bodies.shape[0].radius == 2.5


def test_bodies_are_numbered_backwards_and_so_are_the_ends_of_links():
    links = (
        Spring(a=0, b=1, stiffness=2.0, anchor_a=(1.0, 2.0, 3.0)),
        Spring(a=1, b=-1, stiffness=2.0, anchor_b=(1.0, 2.0, 3.0)),
    )
    scene = shown(Symmetry(reverse=True), links).scene
    assert scene.bodies.mass.tolist() == [3.0, 2.0]
    assert [(link.a, link.b) for link in scene.elements] == [(1, 0), (0, -1)]
    assert isinstance(scene.bodies.shape[1], Sphere)


def test_anchors_in_the_world_move_with_space_and_those_in_bodies_do_not():
    links = (
        Spring(a=0, b=1, stiffness=2.0, length=3.0, anchor_a=(1.0, 2.0, 3.0)),
        Spring(a=1, b=-1, stiffness=2.0, anchor_b=(1.0, 2.0, 3.0)),
        UniformGravity(g=(1.0, 0.0, 0.0)),
        Plane(point=(1.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0)),
    )
    by = Symmetry(turn=QUARTER, shift=np.array([10.0, 0, 0]), units=(3.0, 5.0, 4.0))
    inner, outer, gravity, plane = shown(by, links).scene.elements
    assert inner.anchor_a == (5.0, 10.0, 15.0)
    # Nothing is nothing in all units.
    assert outer.length == 0.0
    np.testing.assert_allclose(outer.anchor_b, [40.0, 5.0, 15.0], atol=1e-14)
    # [N/m] = kg/s^2, [m/s^2]; a direction has no unit.
    assert inner.stiffness == near(2.0 * 3 / 16)
    assert inner.length == near(15.0)
    np.testing.assert_allclose(gravity.g, [0.0, 5 / 16, 0.0], atol=1e-15)
    np.testing.assert_allclose(plane.normal, [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(plane.point, [50.0, 5.0, 0.0], atol=1e-14)
    mirrored = shown(Symmetry(mirrored=True), links[:2]).scene.elements
    assert mirrored[0].anchor_a == (-1.0, 2.0, 3.0)
    assert mirrored[1].anchor_b == (-1.0, 2.0, 3.0)


def test_a_mirrored_polyhedron_has_its_faces_seen_from_outside():
    corners = ((0.0, 0, 0), (1.0, 0, 0), (0.0, 1, 0), (0.0, 0, 1))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    solid = Polyhedron(vertices=corners, faces=faces)
    by = Symmetry(mirrored=True, units=(1.0, 2.0, 1.0))._shape(solid)
    assert by.vertices[1] == (-2.0, 0.0, 0.0)
    assert by.vertices[2] == (0.0, 2.0, 0.0)
    assert by.vertices[3] == (0.0, 0.0, 2.0)
    assert by.faces[0] == (1, 2, 0)


def test_what_was_shown_is_undone():
    of = instance([FIRST, POINT], times=(0.0, 2.0, 4.0))
    by = Symmetry(
        turn=QUARTER,
        shift=np.array([1.0, -2.0, 0.5]),
        boost=np.array([0.25, 0.0, -1.0]),
        reverse=True,
        units=(3.0, 5.0, 4.0),
        delay=7.0,
    )
    for view in (by, Symmetry(mirrored=True, turn=np.array([1.0, 0, 0, 0]))):
        motion = view.applied(of.motion)
        bodies = motion.scene.bodies
        later = instance([FIRST, POINT], times=motion.times)
        flown = np.repeat(bodies.position[None], 3, axis=0)
        # The boost carries everything along.
        speed = view.units[1] / view.units[2] * view.boost
        flown = flown + speed * (motion.times - view.delay)[:, None, None]
        columns = {
            name: np.repeat(getattr(bodies, name)[None], 3, axis=0)
            for name in ("velocity", "attitude", "omega")
        }
        back = view.undone(standing(later, position=flown, **columns))
        start = of.scene.bodies
        np.testing.assert_allclose(back.t, [0.0, 2.0, 4.0], atol=1e-15)
        for sample in range(3):
            np.testing.assert_allclose(back.position[sample], start.position, atol=1e-13)
            np.testing.assert_allclose(back.velocity[sample], start.velocity, atol=1e-13)
            np.testing.assert_allclose(back.omega[sample], start.omega, atol=1e-13)
        np.testing.assert_allclose(back.attitude[0, 0], start.attitude[0], atol=1e-15)


@pytest.mark.parametrize(
    ("name", "elements", "bodies", "reason"),
    [
        ("rotated", (PeriodicBox(size=9.0),), 2, "fixed axes"),
        ("shifted", (PeriodicBox(size=9.0),), 2, None),
        ("relabelled", (), 1, "only one body"),
        ("relabelled", (), 2, None),
        ("shifted", (CentralField(gm=1.0),), 1, "origin"),
        ("boosted", (CentralField(gm=1.0),), 1, "origin"),
        ("rotated", (CentralField(gm=1.0),), 1, None),
        ("boosted", (Plane(), Contact(law="linear", stiffness=1.0)), 2, "fixed in space"),
        ("boosted", (UniformGravity(g=(0, 0, -1)),), 1, None),
        ("boosted", (Spring(a=0, b=-1, stiffness=1.0),), 1, "fixed in space"),
        ("boosted", (Spring(a=0, b=1, stiffness=1.0),), 2, None),
        ("mirrored", (Plane(), Contact(law="linear", stiffness=1.0)), 2, None),
    ],
)
def test_a_scene_has_the_symmetries_that_nothing_in_it_breaks(name, elements, bodies, reason):
    scene = instance([FIRST, POINT][:bodies], elements).scene
    said = symmetry.broken(scene, name)
    assert (said is None) if reason is None else (reason in said)


def test_a_body_that_is_fixed_breaks_a_boost():
    held = Body(mass=1.0, position=(5.0, 0, 0), fixed=True)
    assert symmetry.broken(instance([POINT, held]).scene, "boosted") is not None


def test_pictures_are_shifted_and_boosted_along_the_axes_in_which_a_scene_moves():
    # L = 4 m, L/tau = 8 m/s; samples 2 s apart.
    space = instance([FIRST])
    line = instance([Body(mass=1.0, position=(1.0, 0, 0))], (Spring(a=0, b=-1, stiffness=1.0),))
    plane = instance(
        [Body(mass=1.0, position=(1.0, 0, 0), velocity=(0, 1.0, 0))],
        (Spring(a=0, b=-1, stiffness=1.0),),
    )
    for of, axes in ((space, [1, 1, 1]), (line, [1, 0, 0]), (plane, [1, 1, 0])):
        shift = np.array([32.0, -16.0, 8.0]) * axes
        boost = np.array([4.0, -2.0, 1.0]) * axes
        assert symmetry.of(of, "shifted").shift.tolist() == shift.tolist()
        assert symmetry.of(of, "boosted").boost.tolist() == boost.tolist()
    assert symmetry.of(space, "delayed").delay == 32.0
    np.testing.assert_allclose(
        symmetry.of(space, "rotated").turn, np.array([1, 2, 3, 4]) / sqrt(30)
    )
    np.testing.assert_allclose(symmetry.of(plane, "rotated").turn, np.array([2, 0, 0, 1]) / sqrt(5))
    assert symmetry.of(space, "rescaled").units == (1 / sqrt(11.0), sqrt(51.0), 3.0 + 2.0**-24)


def test_a_probe_of_stability_takes_a_thousand_steps_of_a_multiple_of_two_tau():
    of = instance([POINT], (Spring(a=0, b=-1, stiffness=1.0),))
    motion = stability.probe(of, 0.75)
    assert len(motion.times) == 1001
    assert motion.times[1] == 0.75
    assert motion.times[-1] == 750.0


def test_a_run_exceeds_its_scales_by_its_largest_place_velocity_or_spin():
    scales = Scales(4.0, 0.5, 8.0)
    body = Body(
        mass=1.0, inertia=(0.1,) * 3, position=(1.0, 0, 0), velocity=(0, 2.0, 0), omega=(0, 0, 3.0)
    )
    held = instance([body], (Spring(a=0, b=-1, stiffness=1.0),), scales=scales)
    base = standing(held)
    # Scales: L + |r| = 5 m, L/tau + |v| = 10 m/s, 1/tau + |w| = 5/s.
    assert stability.excess(held, base) == 0.6
    for column, value, expected in (
        ("position", 50.0, 10.0),
        ("velocity", -50.0, 5.0),
        ("omega", 50.0, 10.0),
    ):
        values = np.array(getattr(base, column))
        values[2, 0, 1] = value
        assert stability.excess(held, standing(held, **{column: values})) == expected
    free = instance([body], scales=scales)
    values = np.array(base.position)
    values[2, 0, 1] = 170.0
    # A body that nothing holds may go 10 m/s for 8 s further.
    assert stability.excess(free, standing(free, position=values)) == 2.0
    assert (stability.STEPS, stability.BEYOND) == (1000, 100.0)
