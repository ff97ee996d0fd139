"""Counts of chapter 1, section 1.1, and the placements at which first order counts too much."""

import numpy as np
import pytest

from refdem.mechanics.freedom import complete_graph, first_order_freedom, rigid_freedom

POINTS = np.random.default_rng(4).normal(size=(5, 3))


@pytest.mark.parametrize(("dimension", "expected"), [(2, [2, 3, 3, 3, 3]), (3, [3, 5, 6, 6, 6])])
def test_points_that_all_hang_together_have_the_freedom_of_a_body(dimension, expected):
    assert [
        first_order_freedom(POINTS[:n, :dimension], complete_graph(n)) for n in range(1, 6)
    ] == expected
    assert [rigid_freedom(POINTS[:n, :dimension]) for n in range(1, 6)] == expected


def test_degenerate_placements_have_more_velocities_than_motions():
    flat = POINTS * (1, 1, 0)
    line = np.outer([0.0, 1.0, 2.5], [1.0, 2.0, 3.0])
    assert [first_order_freedom(flat[:n], complete_graph(n)) for n in (4, 5)] == [7, 8]
    assert [rigid_freedom(flat[:n]) for n in (4, 5)] == [6, 6]
    assert (first_order_freedom(line, complete_graph(3)), rigid_freedom(line)) == (7, 5)
    assert (first_order_freedom(line[:, :2], complete_graph(3)), rigid_freedom(line[:, :2])) == (
        4,
        3,
    )


def test_a_rod_more_than_needed_takes_no_freedom():
    square = POINTS[:4, :2]
    rods = complete_graph(4)
    assert (
        first_order_freedom(square, rods[:5])
        == first_order_freedom(square, rods)
        == first_order_freedom(square, [*rods, rods[0]])
        == 3
    )
    assert first_order_freedom(square, rods[:4]) == 4
