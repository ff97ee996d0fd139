"""Impacts a second of rigid spheres: what is counted, and how it is shown."""

import numpy as np
import pytest

from refdem.bench.hard_spheres import Rate, box_of_spheres, rates, table
from refdem.scene.elements.plane import Plane


@pytest.mark.parametrize("part", [0.01, 0.3])
def test_spheres_start_apart_and_in_their_box(part: float) -> None:
    scene = box_of_spheres(100, part)
    size = max(max(plane.point) for plane in scene.all(Plane))
    assert 100 * np.pi / 6 / size**3 == pytest.approx(part)
    position = scene.bodies.position
    assert np.all((position > 0.5) & (position < size - 0.5))
    apart = np.linalg.norm(position[:, None] - position, axis=2) + 9 * np.eye(100)
    assert apart.min() > 1


def test_every_box_has_its_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("refdem.bench.hard_spheres.IMPACTS", 1000)
    found = rates([27], rounds=2)
    assert [rate.part for rate in found] == [0.01, 0.3, 0.4]
    assert all(len(rate.rounds) == 2 and min(rate.rounds) > 0 for rate in found)


def test_a_rate_is_that_of_the_median_round() -> None:
    rows = table([Rate(1000, 0.3, [1e-6, 4e-6, 2e-6])]).rows
    assert rows == [("1000 spheres, 0.3 of the box", "5e+05", "2 us", "1 us to 4 us")]
