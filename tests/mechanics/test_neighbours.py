"""Near pairs by cells against all pairs."""

import numpy as np
import pytest

from refdem.mechanics.neighbours import near_pairs


@pytest.mark.parametrize("size", [0.0, 5.0])
@pytest.mark.parametrize(
    ("count", "reach"), [(10, 2.4), (300, 0.7), (300, 1.6), (300, 2.4), (500, 0.3)]
)
def test_cells_find_the_pairs_that_all_pairs_find(size, count, reach):
    if size:
        position = np.random.default_rng(count).uniform(-5, 10, (count, 3))
    else:
        position = np.random.default_rng(3).uniform(0, 5, (count, 3))
    apart = position[:, None] - position
    if size:
        apart = np.min(np.abs(apart[..., None] - size * np.arange(-4, 5)), axis=-1)
    expected = {
        (i, j) for i, j in np.argwhere(np.linalg.norm(apart, axis=-1) < reach).tolist() if i < j
    }
    i, j = near_pairs(position, reach, size)
    found = [tuple(sorted(pair)) for pair in zip(i.tolist(), j.tolist(), strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == expected
    assert expected
