"""Numbers that solvers hand to their kernels: a law in another unit of time is the same law, forces
balance, and directions are those of the scene.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.scene import Body, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _balance, _single_point, _sliding, rotation_algebra, stick_slip
from tests.handmade import instance, near

UNITS = [Fraction(1), Fraction(1, 4), Fraction(8)]
POINT = Body(mass=3.0, position=(1.0, 0.0, 0.0))
SPRING = Spring(a=0, b=-1, stiffness=5.0)


def friction_at(fields, speed):
    """mu(v) = (mu0 - mu1)/(1 + lambda0 v) + mu1 + lambda1 v^2, or linear in v, exactly."""
    mu0, mu1, lambda0, lambda1 = (
        Fraction(fields[name]) for name in ("mu0", "mu1", "lambda0", "lambda1")
    )
    power = 1 if fields.get("linear") else 2
    return (mu0 - mu1) / (1 + lambda0 * speed) + mu1 + lambda1 * speed**power


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("law", ["coulomb", "stribeck", "stribeck_linear"])
def test_friction_in_another_unit_of_time_is_the_same_at_every_speed(law, unit):
    slider = Slider(
        a=0,
        law=law,
        normal_force=2.0,
        friction=0.375,
        mu0=0.5,
        mu1=0.125,
        lambda0=1.5,
        lambda1=0.25,
    )
    fields = stick_slip._friction(slider, float(unit)) | {"linear": law == "stribeck_linear"}
    for speed in (Fraction(0), Fraction(1, 2), Fraction(3)):
        seen = friction_at(fields, speed * unit)
        meant = Fraction(float(slider.coefficient(np.float64(speed))))
        assert abs(seen - meant) < Fraction(1, 10**15)


class Fields:
    """In place of a struct of a kernel: its fields as they are given."""

    def __init__(self, family, name, fields):
        self.fields = fields


@pytest.mark.parametrize("unit", UNITS)
def test_a_belt_in_another_unit_of_time_has_the_same_forces(unit, monkeypatch):
    monkeypatch.setattr(stick_slip, "Struct", Fields)
    slider = Slider(a=0, axis=(0.6, 0.8, 0.0), friction=0.5, normal_force=2.0, belt_velocity=0.75)
    drive = Force(a=0, amplitude=4.0, frequency=1.5, phase=0.25, axis=(-0.6, -0.8, 0.0))
    gravity = UniformGravity(g=(3.0, 4.0, 0.0))
    scene = instance([POINT], (SPRING, slider, drive, gravity)).scene
    fields = stick_slip.belt_law(scene, float(unit)).fields
    u = float(unit)
    # m x'' = F with x'' in m/unit^2: the mass is m/unit^2, speeds and frequencies are a unit's.
    assert fields["mass"] == 3.0 / u**2
    assert fields["belt"] == 0.75 * u
    assert fields["frequency"] == 1.5 * u
    assert (fields["stiffness"], fields["normal_force"], fields["phase"]) == (5.0, 2.0, 0.25)
    assert fields["weight"] == near(3.0 * 5.0)
    assert fields["amplitude"] == near(-4.0)
    still = stick_slip.belt_law(instance([POINT], (SPRING, slider)).scene, u).fields
    assert (still["amplitude"], still["weight"], still["linear"]) == (0.0, 0.0, False)


@pytest.mark.parametrize(
    ("times", "unit"),
    [
        ([1.0, 9.0], 1.0),
        ([3e-9, 1.0], 2.0**-28),
        ([3e9, float("inf")], 2.0**31),
        ([0.0, float("inf")], 1.0),
    ],
)
def test_a_unit_of_time_is_a_power_of_two_near_the_shortest_time(times, unit):
    assert _single_point.time_unit(times) == unit


def test_the_unit_of_a_belt_is_the_shortest_of_spring_and_drives():
    slider = Slider(a=0, friction=0.5, normal_force=2.0)
    stiff = Spring(a=0, b=-1, stiffness=3.0 * 2.0**80)
    quick = Force(a=0, amplitude=1.0, frequency=2.0**60)
    assert stick_slip.law_time_unit(instance([POINT], (stiff, slider)).scene) == 2.0**-40
    assert stick_slip.law_time_unit(instance([POINT], (stiff, slider, quick)).scene) == 2.0**-60
    constant = Force(a=0, amplitude=1.0)
    assert stick_slip.law_time_unit(instance([POINT], (SPRING, slider, constant)).scene) == 1.0


def test_what_is_askew_by_more_than_a_rounding_is_not_along_the_slider():
    slider = Slider(a=0, friction=0.5, normal_force=2.0)
    for askew, fits in ((0.9e-15, True), (1.1e-15, False)):
        for body, more in (
            (Body(mass=1.0, position=(1.0, askew, 0.0)), ()),
            (Body(mass=1.0, velocity=(1.0, 0.0, askew)), ()),
            (Body(mass=1.0), (UniformGravity(g=(1.0, askew, 0.0)),)),
        ):
            scene = instance([body], (SPRING, slider, *more)).scene
            assert (stick_slip._off_line(scene) is None) == fits


@pytest.mark.parametrize(
    ("spring", "force"),
    [
        # 5 N/m; the end is at (4, 4) from (1, 0): 5 m away, along (3, 4)/5.
        (Spring(a=0, b=-1, stiffness=5.0, anchor_b=(4.0, 4.0, 0.0)), (15.0, 20.0, 0.0)),
        (Spring(a=0, b=-1, stiffness=5.0, length=7.0, anchor_b=(4.0, 4.0, 0.0)), (-6.0, -8.0, 0.0)),
        (Spring(a=0, b=-1, stiffness=5.0, anchor_b=(1.0, 0.0, 0.0)), (0.0, 0.0, 0.0)),
        (Spring(a=0, b=-1, stiffness=5.0, length=1.0, anchor_b=(1.0, 0.0, 0.0)), None),
    ],
)
def test_a_spring_pulls_its_first_end_to_the_other_by_its_stretch(spring, force):
    found = _balance._spring_force(instance([POINT], (spring,)).scene, spring)
    if force is None:
        assert found is None
    else:
        np.testing.assert_allclose(found, force, atol=1e-14)


def test_forces_that_add_up_to_zero_are_balanced_and_others_are_told():
    # 3 kg at 1 m: the spring pulls 5 N to the origin; gravity of 5/3 m/s^2 holds it.
    balanced = instance([POINT], (SPRING, UniformGravity(g=(5.0 / 3.0, 0, 0)))).scene
    assert _balance.unbalanced(balanced) is None
    for off in (UniformGravity(g=(5.01 / 3.0, 0, 0)), UniformGravity(g=(-5.0 / 3.0, 0, 0))):
        assert _balance.unbalanced(instance([POINT], (SPRING, off)).scene) is not None
    # A field of gm = 4 at 2 m pulls 3 kg with 3 N.
    far = Body(mass=3.0, position=(2.0, 0.0, 0.0))
    held = (CentralField(gm=4.0), UniformGravity(g=(1.0, 0, 0)))
    assert _balance.unbalanced(instance([far], held).scene) is None
    loose = (CentralField(gm=6.0), UniformGravity(g=(1.0, 0, 0)))
    assert _balance.unbalanced(instance([far], loose).scene) is not None


def test_a_sphere_has_its_lowest_and_its_highest_point_for_an_outline():
    ball = Body(mass=1.0, inertia=(0.1,) * 3, position=(1.0, 2.0, 3.0), shape=Sphere(radius=0.5))
    scene = instance([ball, POINT]).scene
    found = _balance._outline(scene, 0, np.array([0.0, 0.0, 1.0]))
    assert found.tolist() == [[1.0, 2.0, 2.5], [1.0, 2.0, 3.5]]
    assert _balance._outline(scene, 1, np.array([0.0, 0.0, 1.0])).tolist() == [[1.0, 0.0, 0.0]] * 2


def test_directions_of_a_scene_are_those_of_its_speeds_links_and_loads():
    first = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(5.0, 0, 0),
        velocity=(1.0, 2.0, 0),
        shape=Sphere(radius=0.5),
    )
    second = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(0, 7.0, 0),
        velocity=(0, 0.5, 0),
        shape=Sphere(radius=0.5),
    )
    links = (
        Spring(a=0, b=1, stiffness=1.0),
        Spring(a=1, b=-1, stiffness=1.0, anchor_b=(1.0, 0, 0)),
    )
    law = Contact(law="linear", stiffness=1.0)
    floor = Plane(normal=(0.0, 0.0, 1.0))
    scene = instance([first, second], (*links, law, floor, UniformGravity(g=(0, 0, -2.0)))).scene
    found = {tuple(np.asarray(d).tolist()) for d in _sliding._directions(scene)}
    assert found == {
        (1.0, 1.5, 0.0),
        (1.0, 2.0, 0.0),
        (0.0, 0.5, 0.0),
        (5.0, -7.0, 0.0),
        (-1.0, 7.0, 0.0),
        (0.0, 0.0, -2.0),
    }
    normals = {tuple(np.asarray(n).tolist()) for n in _sliding._normals(scene)}
    assert normals == {(-5.0, 7.0, 0.0), (0.0, 0.0, 1.0)}
    centred = instance([first, second], (law, CentralField(gm=1.0))).scene
    found = {tuple(np.asarray(d).tolist()) for d in _sliding._directions(centred)}
    assert {(5.0, 0.0, 0.0), (0.0, 7.0, 0.0)} <= found


R = np.sqrt(0.5)
QUARTER = np.array([R, 0.0, 0.0, R])
BELT = ([1.0, 0.5, 0.5, 0.0, 0.0], [1.0], [10.0, 0.0, 2.0], [1.0, 0.0])
"""A mass that slips all the time on a belt of 10 m/s, without a drive, from x = 1 at rest."""
EXACT = {
    "plane-turn": (([np.pi / 2], [1.0, 2.0]), [-2.0, 1.0]),
    "complex-turn": (([np.pi / 2], [1.0, 2.0]), [-2.0, 1.0]),
    "plane-eigenvalue": (([0.5],), [np.cos(0.5), np.sin(0.5)]),
    "plane-determinant": (([0.5],), [1.0]),
    "mirror": (([np.pi / 4], [1.0, 2.0]), [2.0, 1.0]),
    "mirror-determinant": (([0.5],), [-1.0]),
    "turn-about": (([0, 0, 1.0], [np.pi / 2]), [0, -1, 0, 1, 0, 0, 0, 0, 1]),
    "matrix-vector": (([0, -1, 0, 1, 0, 0, 0, 0, 1.0], [1.0, 2, 3]), [-2, 1, 3]),
    "turn-angle": (([0, -1, 0, 1, 0, 0, 0, 0, 1.0],), [np.pi / 2]),
    "quaternion-about": (([0, 0, 1.0], [np.pi / 2]), QUARTER),
    "product": (([1.0, 2, 3, 4], [5.0, 6, 7, 8]), [-60, 12, 30, 24]),
    "real-product": (([1.0, 2, 3, 4], [5.0, 6, 7, 8]), [-60, 12, 30, 24]),
    "complex-product": (([1.0, 2, 3, 4], [5.0, 6, 7, 8]), [-60, 12, 30, 24]),
    "complex-eigenvalue": (([1.0, 2, 3, 6],), [1.0, 7.0]),
    "pauli-eigenvalues": (([2.0, 3, 6],), [7.0, -7.0]),
    "vector-sum": (([1.0, 2, 3], [4.0, 5, 6]), [5, 7, 9]),
    "vector-difference": (([1.0, 2, 3], [4.0, 6, 8]), [-3, -4, -5]),
    "matrix-difference": (([2.0] * 9, [0.5] * 9), [1.5] * 9),
    "transpose": (([1.0, 2, 3, 4, 5, 6, 7, 8, 9],), [1, 4, 7, 2, 5, 8, 3, 6, 9]),
    # e_x goes to e_x + v x e_x.
    "first-order-turn": (
        ([1.0, 0, 0, 0, 1, 0, 0, 0, 1], [1.0, 2, 3]),
        [1, -3, 2, 3, 1, -1, -2, 1, 1],
    ),
    "orthogonality": (([0, -2.0, 0, 1, 0, 0, 0, 0, 3],), [0, 0, 0, 0, 3, 0, 0, 0, 8]),
    # A quarter turn about z, stretched along its axes.
    "nearest-turn": (([0, -2.0, 0, 1, 0, 0, 0, 0, 3],), [0, -1, 0, 1, 0, 0, 0, 0, 1]),
    "orthogonal-freedom": (([0, -1.0, 0, 1, 0, 0, 0, 0, 1],), [3.0]),
    # cos(5 pi/3) = 1/2; the powers of cos(pi/3) = 1/2.
    "cosine-by-recurrence": (([np.pi / 3], [5.0]), [0.5]),
    "cosine-by-powers": (([np.pi / 3], [5.0]), [0.5]),
    "inverse": (([1.0, 0, 0, 1.0],), [0.5, 0, 0, -0.5]),
    "unit": (([3.0, 0, 4, 0],), [0.6, 0, 0.8, 0]),
    "rotated": ((QUARTER.tolist(), [1.0, 2, 3]), [-2, 1, 3]),
    # q' = (0, w) q/2
    "rate": (([1.0, 0, 0, 0], [2.0, 4, 6]), [0, 1, 2, 3]),
    # q'' = ((0, a) q + (0, w) q')/2 = (-|w|^2/4, a/2)
    "second-rate": (([1.0, 0, 0, 0], [2.0, 0, 0], [0.0, 4, 6]), [-1, 0, 2, 3]),
    "omega-of-rate": (([1.0, 0, 0, 0], [0.0, 1, 2, 3]), [2, 4, 6]),
    "body-omega-of-rate": ((QUARTER.tolist(), [0.0, R, R, 0.0]), [2, 0, 0]),
    "rotation-energy": (([3.0], [2.0]), [6.0]),
    "scalar-sum": (([3.0], [-5.0]), [-2.0]),
    # 1 kg with e_x at e_y and 3 kg at rest at 4 e_z: the centre moves with e_x/4 at (0, 1/4, 3).
    "points-energy": (([1.0, 3], [1.0, 0, 0, 0, 0, 0]), [0.5]),
    "centre-energy": (([1.0, 3], [1.0, 0, 0, 0, 0, 0]), [0.125]),
    "energy-about-centre": (([1.0, 3], [1.0, 0, 0, 0, 0, 0]), [0.375]),
    "points-angular-momentum": (
        ([1.0, 3], [0.0, 1, 0, 0, 0, 4], [1.0, 0, 0, 0, 0, 0]),
        [0, 0, -1],
    ),
    "centre-angular-momentum": (
        ([1.0, 3], [0.0, 1, 0, 0, 0, 4], [1.0, 0, 0, 0, 0, 0]),
        [0, 3, -0.25],
    ),
    "angular-momentum-about-centre": (
        ([1.0, 3], [0.0, 1, 0, 0, 0, 4], [1.0, 0, 0, 0, 0, 0]),
        [0, -3, -0.75],
    ),
    # About x: both arms of 1 m and of 4 m; about z the first alone.
    "swept-energy": (([1.0, 3], [0.0, 1, 0, 0, 0, 4], [2.0, 0, 1]), [98.5]),
    "tensor-energy": (([1.0, 3], [0.0, 1, 0, 0, 0, 4], [2.0, 0, 1]), [98.5]),
    "spin-momentum": (([3.0], [2.0]), [6.0]),
    "momentum-energy": (([6.0], [3.0]), [6.0]),
    "principal-moments": (([2.0, 1, 0, 1, 2, 0, 0, 0, 5],), [1, 3, 5]),
    "cosine-product": (([0.0], [np.pi / 3]), [0.5]),
    "cosines-mixed": (([0.0], [np.pi / 3]), [0.5]),
    "rejection": (([1.0, 2, 3], [0.0, 0, 2]), [1, 2, 0]),
    "length": (([2.0, 3, 6],), [7.0]),
    "vector-dot": (([1.0, 2, 3], [4.0, -5, 6]), [12.0]),
    "cross": (([1.0, 2, 3], [4.0, 5, 6]), [-3, 6, -3]),
    "cross-square": (([1.0, 2, 3], [4.0, 5, 6]), [54.0]),
    # phi = 0 and theta = pi/2: the third axis of the body is -e_y.
    "euler-rate-matrix": (([0, np.pi / 2, 1.0],), [0, 1, 0, 0, 0, -1, 1, 0, 0]),
    "euler-rate-inverse": (([0, np.pi / 2, 1.0],), [0, 0, 1, 1, 0, 0, 0, -1, 0]),
    "first-order-freedom": (([2.0], [0, 0, 1, 0, 0, 1.0], [0, 1, 1, 2.0]), [4.0]),
    "rigid-freedom": (([2.0], [0, 0, 1, 0, 0, 1.0]), [3.0]),
    # k = 1 + 3/4 4/3 = 2 of A = 1: f0^2 = (2 - 1)^2 + 4 at w = 1, and 2^2 at w = 0.
    "balanced-forces": (([1.0], [1.0, 4 / 3, 1.0], [1.0, 0.0]), [np.sqrt(5.0), 2.0]),
    # Without damping: w^2 = 2 -+ 1.
    "balanced-drives": (([1.0], [1.0, 4 / 3, 0.0], [1.0]), [1.0, np.sqrt(3.0)]),
    # With h = 1 and S = 1: 16 delta^2 (1 + alpha) + 8 delta^2 f0^2 + f0^4 = 4 f0^2.
    "lower-fold": (([2.0, 4 / 3, 0.25], [np.sqrt(2.0)]), [2.0, 1.0]),
    "upper-fold": (([0.5, 4 / 3, 0.25], [np.sqrt(0.5)]), [np.sqrt(7.0) / 2, 1.0]),
    "two-cycle": (([3.2],), [(4.2 + np.sqrt(0.84)) / 6.4, (4.2 - np.sqrt(0.84)) / 6.4]),
    "share-below": (([0.75],), [2 / 3]),
    "doubling-point": (([1.0],), [1 + np.sqrt(6.0)]),
    # Friction 1/2 at any speed below that of the belt, which balances the steady pull: x = cos t.
    "belt-strobe": ((*BELT, [1.0]), [-1.0, 0.0]),
    "belt-passage": ((*BELT, [2.0]), [4 * np.pi, 1.0]),
}


@pytest.mark.parametrize("operation", EXACT)
def test_an_operation_of_rotation_algebra_has_the_result_of_paper(operation):
    operands, expected = EXACT[operation]
    arrays = [np.array(operand, float) for operand in operands]
    found = np.asarray(rotation_algebra.ANSWERS[operation](*arrays), float).ravel()
    np.testing.assert_allclose(found, expected, atol=1e-14)
