"""Billiards: the same paths by other ways, S by displaced starts, and the ends at corners and
tangents.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core.discovery import truth_of
from refdem.errors import NotCertifiedError
from refdem.truth.balls import precision
from refdem.truth.maps.rectangle import Rectangle
from refdem.truth.maps.stadium import Stadium

NAMES = ("position.x", "position.y", "direction.x", "direction.y")
SCALE = {"position.x": 4, "position.y": 4, "direction.x": 1, "direction.y": 1}
# mpmath with 400 digits, chords of all four pieces tried: bounce 64 of the default
FAR = [
    "0.4414846174552397076324794074076665567103",
    "-1",
    "0.2723315281678219282699939166214031950049",
    "0.9622034809570056900753613101808257085875",
]
TABLES = [
    (("4", "2"), ("1/4", "1/8"), ("4", "3")),
    (("3", "2"), ("-3/8", "0"), ("-1", "1/16")),
    (("4", "2"), ("3/2", "1/2"), ("-2", "1")),
    (("2", "2"), ("1/4", "0"), ("3", "4")),
]


def of(kind, table):
    size, start, direction = (tuple(Fraction(x) for x in pair) for pair in table)
    return kind(size, start, direction, SCALE)


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("n", [1, 2, 5, 30])
def test_the_stadium_agrees_with_chords_in_decimal_arithmetic(paths, table, n):
    seen = of(Stadium, table).at(Fraction(n))
    size, start, direction = (tuple(float(Fraction(x)) for x in pair) for pair in table)
    for name, value in zip(NAMES, paths["stadium"](size, start, direction, n), strict=True):
        assert abs(seen[name].mid - Fraction(value)) <= seen[name].radius + Fraction(1, 10**60)
        assert seen[name].radius <= Fraction(1, 10**40)


def test_sixty_four_bounces_keep_forty_digits():
    seen = truth_of("billiards", n="64").at(Fraction(64))
    assert all(
        abs(seen[name].mid - Fraction(text)) < Fraction(1, 10**38)
        for name, text in zip(NAMES, FAR, strict=True)
    )


@pytest.mark.parametrize(
    "table",
    [
        *TABLES[:2],
        (("7", "3"), ("1", "-1/3"), ("-2/7", "5/11")),
        (("2", "1"), ("0", "0"), ("1", "0")),
    ],
)
@pytest.mark.parametrize("n", [0, 1, 2, 3, 50, 1001])
def test_the_unfolded_rectangle_is_the_path_bounce_by_bounce(paths, table, n):
    place, speed = paths["rectangle"](*table, n)
    length = sum(u * u for u in speed)
    seen = of(Rectangle, table).at(Fraction(n))
    for i, axis in enumerate("xy"):
        assert (
            abs(seen[f"position.{axis}"].mid - place[i])
            <= seen[f"position.{axis}"].radius
            <= Fraction(1, 10**39)
        )
        direction = seen[f"direction.{axis}"]
        assert abs(direction.mid**2 - speed[i] ** 2 / length) < Fraction(1, 10**38)
        assert direction.mid * speed[i] >= 0


def test_a_million_bounces_are_as_quick_as_one(paths):
    table = TABLES[0]
    seen = of(Rectangle, table).at(Fraction(10**6))
    again, _ = paths["rectangle"](
        *table, 10**6 % 600 + 600
    )  # the path closes: 4 : 3 in a table of 4 by 2 has period 10 crossings
    assert [float(seen[f"position.{a}"].mid) for a in "xy"] == [float(x) for x in again]


def displaced(kind, table, axis, amount):
    size, start, direction = ([Fraction(x) for x in pair] for pair in table)
    if axis < 2:
        start[axis] += amount * SCALE[NAMES[axis]]
        return kind(tuple(size), tuple(start), tuple(direction), SCALE)
    length = Fraction(float(np.hypot(*map(float, direction))))
    unit = [
        u / length for u in direction
    ]  # of length 1 to binary64: what the difference is blind to
    unit[axis - 2] += amount
    return kind(tuple(size), tuple(start), tuple(unit), SCALE)


@pytest.mark.parametrize(
    ("kind", "n"), [(Stadium, 1), (Stadium, 4), (Stadium, 9), (Rectangle, 1), (Rectangle, 7)]
)
def test_the_jacobian_is_that_of_displaced_starts(kind, n):
    table = TABLES[0]
    step = Fraction(1, 2**60)
    with precision(256):
        found = np.array(
            [[float(x) for x in row] for row in of(kind, table).jacobian(Fraction(n)).table()]
        )
    for axis in range(2):
        plus, minus = (displaced(kind, table, axis, s * step).at(Fraction(n)) for s in (1, -1))
        column = [
            float((plus[name].mid - minus[name].mid) / (2 * step)) / SCALE[name] for name in NAMES
        ]
        assert np.allclose(found[:, axis], column, rtol=1e-9, atol=1e-9 * np.abs(found).max())
    across = np.array(
        [-0.6, 0.8]
    )  # a turn of the direction; along it the start is normalised again
    plus, minus = (
        of(
            kind,
            (
                table[0],
                table[1],
                (
                    Fraction(4, 5) - s * Fraction(3, 5) * step,
                    Fraction(3, 5) + s * Fraction(4, 5) * step,
                ),
            ),
        ).at(Fraction(n))
        for s in (1, -1)
    )
    column = [
        float((plus[name].mid - minus[name].mid) / (2 * step)) / SCALE[name] for name in NAMES
    ]
    assert np.allclose(found[:, 2:] @ across, column, rtol=1e-9, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize(("kind", "n"), [(Stadium, 12), (Rectangle, 40)])
def test_sensitivity_is_no_less_than_the_jacobian_from_the_start(kind, n):
    truth = of(kind, TABLES[0])
    with precision(256):
        rows = [sum(abs(float(x)) for x in row) for row in truth.jacobian(Fraction(n)).table()]
    assert max(rows) <= truth.sensitivity(Fraction(n)) <= 40 * max(rows)


@pytest.mark.parametrize(
    ("table", "last"),
    [
        ((("4", "2"), ("0", "0"), ("2", "1")), 0),  # straight into the corner
        ((("4", "2"), ("0", "0"), ("2", "3")), 1),
        ((("2", "1"), ("1/4", "1/4"), ("-5/4", "5/4")), 1),
        ((("1", "1"), ("0", "1/8"), ("4", "9")), 4),
    ],
)
def test_a_corner_of_the_rectangle_is_decided_exactly(paths, table, last):
    truth = of(Rectangle, table)
    with pytest.raises(NotCertifiedError, match="corner") as ended:
        truth.at(Fraction(last + 1))
    assert (ended.value.code, ended.value.time) == ("corner", last)
    place, _ = paths["rectangle"](*table, last)
    assert [ended.value.state[f"position.{a}"].mid for a in "xy"] == pytest.approx(
        [float(x) for x in place], abs=1e-15
    )
    truth.at(Fraction(last))
    corner, _ = paths["rectangle"](*table, last + 1)
    assert [abs(x) for x in corner] == [Fraction(s) / 2 for s in table[0]]


@pytest.mark.parametrize(
    ("start", "direction", "last"),
    [(("0", "0"), ("1", "1"), 0), (("1/2", "0"), ("1/2", "-1"), 0), (("0", "0"), ("1/3", "1"), 1)],
)
def test_where_the_wall_of_the_stadium_changes_nothing_is_certified(start, direction, last):
    truth = of(Stadium, (("4", "2"), start, direction))
    with pytest.raises(NotCertifiedError, match="corner") as ended:
        truth.at(Fraction(5))
    assert (ended.value.code, ended.value.time) == ("corner", last)
    assert set(ended.value.state) == set(NAMES)
    assert all(ball.radius < Fraction(1, 10**39) for ball in truth.at(Fraction(last)).values())


def test_chaos_ends_with_the_bits_and_says_so():
    with pytest.raises(NotCertifiedError, match="bits are used up") as ended:
        truth_of("billiards").at(Fraction(10**5))
    assert ended.value.code == "precision"
    assert ended.value.time > 1500


@pytest.mark.parametrize("direction", ["1,0", "0,1", "0,-1"])
def test_paths_along_an_axis_go_to_and_fro(direction):
    truth = truth_of("billiards", start="1/4,0", direction=direction)
    odd = truth.at(Fraction(101))
    even = truth.at(Fraction(102))
    assert all(
        abs(odd[f"direction.{a}"].mid + even[f"direction.{a}"].mid) < Fraction(1, 10**30)
        for a in "xy"
    )
    assert (
        abs(odd["position.x"].mid) == (Fraction(1, 4) if direction[0] == "0" else 2)
        or abs(abs(odd["position.x"].mid) - 2) < 1e-30
    )


def test_the_last_bounce_that_is_named_is_certified_on_a_small_table_too(monkeypatch):
    """A table of 1e-20 m asks for radii of 1e-20 of those of a metre."""
    monkeypatch.setattr("refdem.truth.maps.iterated.MOST_BITS", 512)
    small = Fraction(1, 10**20)
    scale = {name: small if name.startswith("position") else 1 for name in NAMES}
    size, start = (4 * small, 2 * small), (small / 4, small / 8)
    truth = Stadium(size, start, (Fraction(4), Fraction(3)), scale)
    with pytest.raises(NotCertifiedError) as ended:
        truth.at(Fraction(1000))
    last = Fraction(ended.value.time)
    assert last > 20
    assert all(ball.radius <= truth.largest_radius() for ball in truth.at(last).values())
    with pytest.raises(NotCertifiedError):
        truth.at(last + 1)
