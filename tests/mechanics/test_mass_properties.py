"""Mass properties against integrals done by hand, and against bodies put together in another
way.
"""

import numpy as np
import pytest

from refdem.mechanics.mass_properties import of_points, of_polygon, of_polyhedron
from refdem.scene.shapes import box

CUBOID = box(1.0, 2.0, 3.0)


def test_a_cuboid_has_a_twelfth_of_the_squares_of_its_sides():
    found = of_polyhedron(CUBOID.vertices, CUBOID.faces, 2.0)
    assert found.mass == pytest.approx(12, rel=1e-15)
    assert np.diag(found.inertia) == pytest.approx([13.0, 10.0, 5.0], rel=1e-14)
    assert abs(found.inertia - np.diag(np.diag(found.inertia))).max() < 1e-14


def test_a_tetrahedron_at_the_corner_of_a_cube_has_the_integrals_of_its_coordinates():
    # Over x, y, z >= 0, x + y + z <= 1: volume 1/6, mean x 1/4, mean x^2 1/10, mean x y 1/20.
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    found = of_polyhedron(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], 6.0)
    assert found.mass == pytest.approx(1, rel=1e-15)
    assert found.centre == pytest.approx([0.25] * 3, rel=1e-15)
    assert found.about((0, 0, 0)) == pytest.approx(np.eye(3) * (0.2 + 0.05) - 0.05, rel=1e-14)


def test_a_body_that_is_not_convex_is_what_is_left_of_a_cuboid():
    # An L: the square [0, 2]^2 without [1, 2]^2, one high.
    plan = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    low = [(*p, 0.0) for p in plan]
    high = [(*p, 1.0) for p in plan]
    n = len(plan)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    caps = [(0, 3, 1), (1, 3, 2), (0, 5, 3), (3, 5, 4)]
    tops = [tuple(n + i for i in reversed(face)) for face in caps]
    found = of_polyhedron(low + high, [*sides, *caps, *tops], 1.0)
    whole, notch = (
        of_polyhedron(np.array(box(s, s, 1).vertices) + at, CUBOID.faces, 1.0)
        for s, at in ((2, (1, 1, 0.5)), (1, (1.5, 1.5, 0.5)))
    )
    left = whole - notch
    assert found.mass == pytest.approx(3, rel=1e-15)
    assert found.centre == pytest.approx(left.centre, rel=1e-14)
    assert found.inertia == pytest.approx(left.inertia, rel=1e-13, abs=1e-14)


def test_a_triangle_has_the_moment_of_its_base_and_height_and_of_its_sides():
    a = 0.7
    b = 3.0
    h = 2.0
    sigma = 1.5
    found = of_polygon([(0, 0), (b, 0), (a, h)], sigma)
    assert found.inertia[2, 2] == pytest.approx(
        sigma * b * h * (b * b - a * b + a * a + h * h) / 36, rel=1e-14
    )
    squares = b * b + (a - b) ** 2 + h * h + a * a + h * h
    assert found.inertia[2, 2] == pytest.approx(found.mass * squares / 36, rel=1e-14)


def test_a_polygon_that_is_not_convex_is_the_sum_of_its_rectangles():
    found = of_polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 1.0)
    foot = of_polygon([(0, 0), (2, 0), (2, 1), (0, 1)], 1.0)
    post = of_polygon([(0, 1), (1, 1), (1, 2), (0, 2)], 1.0)
    assert found.inertia == pytest.approx((foot + post).inertia, rel=1e-14, abs=1e-15)
    assert foot.inertia[2, 2] == pytest.approx(2 * (4 + 1) / 12, rel=1e-15)


def test_mass_properties_move_and_turn_with_the_body():
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    corners = np.array(CUBOID.vertices) @ turn.T + (5, -3, 2)
    found = of_polyhedron(corners, CUBOID.faces, 2.0)
    assert found.centre == pytest.approx([5, -3, 2], rel=1e-14)
    assert found.inertia == pytest.approx(
        of_polyhedron(CUBOID.vertices, CUBOID.faces, 2.0).turned(turn).inertia, abs=1e-12
    )


def test_points_have_the_sum_of_their_squares_and_any_point_adds_its_own():
    found = of_points([1.0, 2.0], [(0, 0, 0), (3, 0, 0)])
    assert found.centre == pytest.approx([2, 0, 0])
    assert np.diag(found.inertia) == pytest.approx([0, 6, 6])
    assert np.diag(found.about((0, 0, 0))) == pytest.approx([0, 18, 18])


def test_principal_moments_rise_and_their_axes_are_right_handed():
    found = of_polyhedron(CUBOID.vertices, CUBOID.faces, 2.0).principal()
    assert found[0] == pytest.approx([5, 10, 13])
    assert np.linalg.det(found[1]) == pytest.approx(1)
