"""Grids: what a replay rounds, and by how much."""

import msgspec
import numpy as np

from refdem.core.finding import Sheet
from refdem.core.replay import STEPS, Grid
from tests.report import synthetic


def test_a_grid_is_off_by_half_a_step_at_most_and_leaves_zeros_out():
    values = np.zeros((5, 4))
    values[:, 1] = [0.0, 1e-9, -3e-9, 2e-9, 1.2345e-9]
    values[:, 3] = 1e-9 / 3
    grid = Grid.of(values)
    assert grid.scale == 3e-9
    assert grid.columns == (1, 3)
    off = np.abs(grid.values(5, 4) - values)
    # Half of a step, and the rounding of binary64 beside it.
    assert off.max() <= 0.501 * grid.scale / STEPS
    assert np.all(off[:, [0, 2]] == 0)


def test_a_grid_of_nothing_but_zeros_is_empty():
    grid = Grid.of(np.zeros((3, 6)))
    assert (grid.scale, grid.columns, grid.data) == (0.0, (), "")
    assert np.array_equal(grid.values(3, 6), np.zeros((3, 6)))


def test_a_replay_is_a_sheet_that_json_gives_back():
    replay = synthetic.replay("pendulum", "alpha", "rk4")
    data = msgspec.json.encode(replay)
    assert msgspec.json.decode(data, type=Sheet) == replay
