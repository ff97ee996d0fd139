"""The turning point of a wedge that meets a wall, and which end it shows on its way, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from refdem.solvers import exact_wedge
from tests.handmade import near

INWARD = (8.0, 1.0)
OUTWARD = (2.0, 1.0)


@pytest.mark.parametrize(
    ("overlap", "rate", "deepest"),
    [
        # F = 8 d on the way in and 2 d on the way out; 2 kg at 3 m/s have 9 J: D = sqrt(2 E/k).
        (0.0, 3.0, 1.5),
        (-1.0, 3.0, 1.5),
        (0.5, 3.0, np.sqrt(2.25 + 0.25)),
        (0.5, 0.0, 0.5),
        # On the way out by the other law: it came from sqrt(9 + 1/4).
        (0.5, -3.0, np.sqrt(9.25)),
        # At a touch it is in no contact unless it closes.
        (0.0, 0.0, 0.0),
        (0.0, -3.0, 0.0),
        (-1.0, -3.0, 0.0),
        (-1.0, 0.0, 0.0),
    ],
)
def test_a_wedge_turns_where_its_energy_is_that_of_the_overlap(overlap, rate, deepest):
    found = exact_wedge._deepest(2.0, INWARD, OUTWARD, overlap, rate)
    assert found == near(deepest, rel=1e-14)


def test_a_square_law_turns_by_the_cube_root():
    # F = 3 d^2: 9 J = D^3.
    assert exact_wedge._deepest(2.0, (3.0, 2.0), OUTWARD, 0.0, 3.0) == near(9 ** (1 / 3))


class Wall:
    """A wall that the edge points at, or not."""

    def __init__(self, edge_first):
        self.now = edge_first

    def edge_first(self, attitude):
        return self.now


SCENE = SimpleNamespace(bodies=SimpleNamespace(attitude=np.array([[1.0, 0.0, 0.0, 0.0]])))
"""No more than an attitude."""


@pytest.mark.parametrize(
    ("overlap", "rate", "turned"),
    [
        (0.5, -1.0, True),
        (0.5, 0.0, False),
        (0.5, 1.0, False),
        (0.0, -1.0, False),
        (-1.0, -1.0, False),
    ],
)
@pytest.mark.parametrize("now", [True, False])
def test_what_comes_first_on_the_way_in_goes_last_on_the_way_out(overlap, rate, turned, now):
    assert exact_wedge._approaches_edge_first(SCENE, Wall(now), overlap, rate) == (now != turned)
