"""Slips about attitudes and spins are settled by their own numbers."""

from refdem.manual import attitude_slips
from refdem.manual.slip import Measured


def values(measured: Measured) -> list[float]:
    return [float(value) for _, value in measured]


def test_orthogonal_columns_and_determinant_1_keep_no_length() -> None:
    columns, determinant, length, mirror, kept = values(
        attitude_slips.orthogonal_columns_and_determinant()
    )
    assert (columns, determinant, length) == (0, 1, 2)
    assert (mirror, kept) == (-1, 1)


def test_minus_the_conjugate_turns_back() -> None:
    (_, turned), (_, minus), (_, minus_conjugate) = attitude_slips.minus_conjugate_turns_back()
    assert turned == minus == "(0, 0, 1)"
    assert minus_conjugate == "(0, 0, -1)"


def test_body_axes_give_the_second_rate_of_the_certified_attitude() -> None:
    (_, by_euler), (_, by_differences) = attitude_slips.body_axes_have_second_rates()
    assert by_euler == by_differences


def test_pure_quaternions_do_not_anticommute_and_the_identities_hold() -> None:
    both, expected, exchanged, cross, opposite = values(
        attitude_slips.pure_quaternions_do_not_anticommute()
    )
    assert both == expected > 1
    assert exchanged > 0.1
    assert cross == opposite == 0


def test_the_ellipsoid_of_omega_rolls_on_a_fixed_plane_and_that_of_the_momentum_does_not() -> None:
    turn, distance, other_turn, other_distance = values(attitude_slips.which_ellipsoid_rolls())
    assert turn == distance == 0
    assert other_turn > 0.1
    assert abs(other_distance) > 0.1
