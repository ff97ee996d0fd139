"""The kernels of billiards against plain rays: the nearest wall that is ahead, and the law of
reflection there.
"""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from refdem.kernels import load, pointer

Array = NDArray[np.float64]
FAMILY = "maps"
AHEAD = 1e-9
"""[m] that a wall must be ahead, so that the one just met does not count."""
CLOSE = 1e-8
"""Error that round-off may make in a few bounces: each on an arc makes it several times larger."""
BOUNCES = 6


def billiard(function: str, width: float, height: float, start: Array, n: Array) -> Array:
    """Rows (T, 4) of place and direction after n (T,) bounces."""
    out = np.full((len(n), 4), np.nan)
    status = getattr(load(FAMILY).lib, function)(
        width,
        height,
        pointer(FAMILY, start),
        len(n),
        pointer(FAMILY, n),
        pointer(FAMILY, out, output=True),
    )
    assert status == 0
    return out


def straight_walls(
    reach_x: float, reach_y: float, place: Array, way: Array
) -> Iterator[tuple[float, Array]]:
    """Distances to four straight walls, and their normals."""
    for i, reach in ((0, reach_x), (1, reach_y)):
        for side in (-1.0, 1.0):
            if way[i] * side > 0:
                normal = np.zeros(2)
                normal[i] = side
                yield (side * reach - place[i]) / way[i], normal


def rectangle(width: float, height: float, place: Array, way: Array) -> tuple[float, Array]:
    """Distance to the nearest wall, and its normal."""
    return min(straight_walls(width / 2, height / 2, place, way), key=lambda wall: wall[0])


def stadium(width: float, height: float, place: Array, way: Array) -> tuple[float, Array]:
    """Two half circles joined by straight walls along x."""
    radius = height / 2
    half = (width - height) / 2
    walls = [
        (t, normal)
        for t, normal in straight_walls(np.inf, radius, place, way)
        if normal[1] != 0 and abs(place[0] + t * way[0]) <= half
    ]
    for side in (-1.0, 1.0):
        centre = np.array([side * half, 0.0])
        arm = place - centre
        b = arm @ way
        square = b * b - (arm @ arm - radius * radius)
        if square < 0:
            continue
        t = -b + np.sqrt(square)
        there = place + t * way
        if side * (there[0] - centre[0]) >= 0:
            walls.append((t, (there - centre) / radius))
    return min((wall for wall in walls if wall[0] > AHEAD), key=lambda wall: wall[0])


WALLS = {"refdem_rectangle": rectangle, "refdem_stadium": stadium}


def plain(function: str, width: float, height: float, start: Array) -> Array:
    """Rows (BOUNCES + 1, 4) after every bounce."""
    place = start[:2].copy()
    way = start[2:].copy()
    rows = [start]
    for _ in range(BOUNCES):
        t, normal = WALLS[function](width, height, place, way)
        place = place + t * way
        way = way - 2 * (way @ normal) * normal
        rows.append(np.array([*place, *way]))
    return np.array(rows)


ANGLES = [*np.arange(0.1, 6.3, 0.37), 0.0, np.pi / 2, np.pi, 3 * np.pi / 2]
PLACES = [(0.0, 0.0), (0.3, 0.2), (-0.7, -0.35), (1.2, 0.1), (-1.15, 0.05)]


def direction(angle: float) -> tuple[float, float]:
    """A unit vector; along an axis, exactly."""
    quarter = angle / (np.pi / 2)
    if quarter == round(quarter):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter)]
    return float(np.cos(angle)), float(np.sin(angle))


@pytest.mark.parametrize("function", WALLS)
@pytest.mark.parametrize(("width", "height"), [(3.0, 1.0), (2.75, 2.5), (2.5, 1.25)])
@pytest.mark.parametrize("place", PLACES)
def test_a_ball_bounces_as_a_ray_does(
    function: str, width: float, height: float, place: tuple[float, float]
) -> None:
    """In all directions, along the walls and at right angles to them among them."""
    n = np.arange(BOUNCES + 1.0)
    for angle in ANGLES:
        start = np.array([*place, *direction(angle)])
        expected = plain(function, width, height, start)
        found = billiard(function, width, height, start, n)
        np.testing.assert_allclose(found, expected, atol=CLOSE, err_msg=f"angle {angle}")


@pytest.mark.parametrize("function", WALLS)
def test_bounces_that_are_not_asked_for_change_nothing(function: str) -> None:
    start = np.array([0.3, 0.2, 0.6, 0.8])
    every = billiard(function, 3.0, 1.0, start, np.arange(31.0))
    some = billiard(function, 3.0, 1.0, start, np.array([0.0, 4.0, 5.0, 30.0]))
    np.testing.assert_array_equal(some, every[[0, 4, 5, 30]])


@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_a_stadium_without_straight_walls_is_a_circle(radius: float) -> None:
    """Every chord has the same length, and the same angle about the centre."""
    start = np.array([0.25 * radius, -0.5 * radius, 0.6, 0.8])
    rows = billiard("refdem_stadium", 2 * radius, 2 * radius, start, np.arange(1.0, 40.0))
    np.testing.assert_allclose(np.hypot(*rows.T[:2]), radius, rtol=1e-14)
    np.testing.assert_allclose(np.hypot(*rows.T[2:]), 1.0, rtol=1e-14)
    turned = rows[:, 0] * rows[:, 3] - rows[:, 1] * rows[:, 2]
    np.testing.assert_allclose(turned, turned[0], rtol=1e-12)


def test_a_ball_that_does_not_move_never_bounces() -> None:
    out = np.full((1, 4), np.nan)
    start = np.array([0.25, 0.125, 0.0, 0.0])
    n = np.array([1.0])
    status = load(FAMILY).lib.refdem_rectangle(
        3.0, 1.0, pointer(FAMILY, start), 1, pointer(FAMILY, n), pointer(FAMILY, out, output=True)
    )
    assert status == 1
    assert np.isnan(out).all()


def test_no_ball_is_ever_outside() -> None:
    """Not by a rounding, shot at corners: there it meets two walls at once, or almost."""
    rounded_out = 0
    for width in (0.7, 1.1, 1.3, 2.9, 3.3):
        for height in (0.3, 0.9, 1.7):
            way = np.array([width, height]) / np.hypot(width, height)
            for signs in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
                start = np.array([0.0, 0.0, *(signs * way)])
                rows = billiard("refdem_rectangle", width, height, start, np.arange(60.0))
                assert np.abs(rows[:, 0]).max() <= 0.5 * width
                assert np.abs(rows[:, 1]).max() <= 0.5 * height
                rounded_out += int((np.abs(rows[:, :2]) == [0.5 * width, 0.5 * height]).sum())
    assert rounded_out > 1000
