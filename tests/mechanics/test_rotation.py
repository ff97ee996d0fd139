"""Matrices, Euler angles and quaternions against one another and against derivatives."""

from itertools import pairwise

import numpy as np
import pytest

from refdem.mechanics import rotation
from refdem.mechanics.quaternion import _cross, angle_between, matrix, product, rotated

GENERATOR = np.random.default_rng(11)
ATTITUDES = [q / np.linalg.norm(q) for q in GENERATOR.normal(size=(20, 4))]
ATTITUDES += [np.array(q, float) for q in ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]


@pytest.mark.parametrize("q", ATTITUDES)
def test_matrix_quaternion_and_euler_angles_are_one_attitude(q):
    turn = matrix(q)
    assert angle_between(rotation.quaternion_of_matrix(turn), q) < 1e-14
    euler = rotation.euler_of_matrix(turn)
    assert rotation.matrix_of_euler(*euler) == pytest.approx(turn, abs=1e-14)
    assert angle_between(rotation.quaternion_of_euler(*euler), q) < 1e-14


def test_two_quarter_turns_make_a_third_of_a_turn_and_take_x_to_y():
    turn = rotation.about_axis(0, -np.pi / 2) @ rotation.about_axis(1, -np.pi / 2)
    assert turn @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-14)
    assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(np.radians(120)), abs=1e-14)


def test_a_turn_about_an_axis_is_counter_clockwise_seen_against_it():
    for axis in range(3):
        unit = np.eye(3)
        quarter = rotation.about_axis(axis, np.pi / 2)
        assert quarter @ unit[(axis + 1) % 3] == pytest.approx(unit[(axis + 2) % 3], abs=1e-14)
        assert rotated(
            rotation.about_axis_quaternion(unit[axis], np.pi / 2), unit[(axis + 1) % 3]
        ) == pytest.approx(unit[(axis + 2) % 3], abs=1e-14)


@pytest.mark.parametrize("q", ATTITUDES[:6])
def test_euler_rates_are_the_derivative_of_the_angles_under_the_quaternions_rate(q):
    omega = np.array([0.3, -0.8, 0.5])
    h = 1e-6
    rate = rotation.quaternion_rate(q, omega)
    ahead, behind = (
        rotation.euler_of_matrix(matrix(p / np.linalg.norm(p)))
        for p in (q + h * rate, q - h * rate)
    )
    turned = (ahead - behind + np.pi) % (2 * np.pi) - np.pi
    phi, theta, _ = rotation.euler_of_matrix(matrix(q))
    assert rotation.euler_rates(phi, theta, omega) == pytest.approx(
        turned / (2 * h), rel=1e-6, abs=1e-8
    )


def test_euler_rates_diverge_where_the_quaternions_rate_does_not():
    omega = np.array([1.0, 0.0, 0.0])
    rates = [np.abs(rotation.euler_rates(1.0, theta, omega)).max() for theta in (1e-2, 1e-4, 1e-6)]
    assert [b / a for a, b in pairwise(rates)] == pytest.approx([100, 100], rel=1e-3)
    assert np.linalg.norm(rotation.quaternion_rate(np.array([1.0, 0, 0, 0]), omega)) == 0.5


def test_real_and_complex_matrices_multiply_as_quaternions_do():
    p, q = GENERATOR.normal(size=(2, 4))
    assert rotation.real_matrix(p) @ q == pytest.approx(product(p, q), abs=1e-14)
    both = rotation.complex_matrix(p) @ rotation.complex_matrix(q)
    assert both == pytest.approx(rotation.complex_matrix(product(p, q)), abs=1e-14)


@pytest.mark.parametrize(
    ("left", "right"), [((3,), (3,)), ((7, 3), (7, 3)), ((5, 1, 3), (4, 3)), ((3,), (6, 3))]
)
def test_the_cross_product_is_numpys_to_the_bit(left, right):
    u = GENERATOR.normal(size=left)
    v = GENERATOR.normal(size=right)
    np.testing.assert_array_equal(_cross(u, v), np.cross(u, v))
