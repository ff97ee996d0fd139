"""The whirling shaft: its motion against Taylor series in rationals, its border, its double root,
and the bound of its growth where it is over-damped.
"""

from fractions import Fraction

import pytest

from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.whirling_shaft import WhirlingShaft, truth

F = Fraction
SCALE = {"x": 1.0, "y": 1.0, "vx": 2.0, "vy": 2.0}
SHAFT = {
    "mass": F(2),
    "stiffness": F(8),
    "outer_damping": F(1, 2),
    "inner_damping": F(1),
    "turning": F(5),
    "x0": (F(1), F(-1, 3)),
    "v0": (F(1, 2), F(1)),
}
DOUBLE = {"outer_damping": F(3), "inner_damping": F(5), "turning": F(0)}
"""Critical damping: b = (3 + 5)/4 = w0."""
SETTINGS = [
    {},
    {"turning": F(2)},
    {"turning": F(3)},
    {"turning": F(-7)},
    {"outer_damping": F(0), "inner_damping": F(0)},
    DOUBLE,
    {**DOUBLE, "turning": F(1, 10**12)},
    {"outer_damping": F(30), "turning": F(1)},
]


def at(t: Fraction, **given: Fraction) -> dict[str, Fraction]:
    balls = truth({**SHAFT, **given}, SCALE).at(t)  # type: ignore[arg-type]
    return {name: ball.mid for name, ball in balls.items()}


def series(t: Fraction, **given: Fraction) -> dict[str, Fraction]:
    """x, y, vx, vy by the Taylor series of Newton's law in Cartesian coordinates, in rationals."""
    p = {**SHAFT, **given}
    m = p["mass"]
    c = p["outer_damping"] + p["inner_damping"]
    push = p["inner_damping"] * p["turning"]
    x = [p["x0"][0], p["v0"][0]]
    y = [p["x0"][1], p["v0"][1]]
    for n in range(220):
        factor = m * (n + 1) * (n + 2)
        next_x = -p["stiffness"] * x[n] - push * y[n] - c * (n + 1) * x[n + 1]
        next_y = -p["stiffness"] * y[n] + push * x[n] - c * (n + 1) * y[n + 1]
        x.append(next_x / factor)
        y.append(next_y / factor)
    found = {}
    for name, terms in (("x", x), ("y", y)):
        found[name] = sum(term * t**n for n, term in enumerate(terms))
        found[f"v{name}"] = sum(n * term * t ** (n - 1) for n, term in enumerate(terms) if n)
    return found


@pytest.mark.parametrize("given", SETTINGS, ids=str)
@pytest.mark.parametrize("t", [F(0), F(1, 2), F(2)])
def test_the_motion_is_the_taylor_series_of_newtons_law(given: dict[str, Fraction], t: F) -> None:
    expected = series(t, **given)
    for name, value in at(t, **given).items():
        assert abs(value - expected[name]) < F(1, 10**38)


@pytest.mark.parametrize("turning", [F(3), F(-3)])
def test_at_the_border_the_rate_is_exactly_0_and_the_orbit_a_circle_of_rate_w0(turning: F) -> None:
    given = {"turning": turning}
    scalars = truth({**SHAFT, **given}, SCALE).scalars()  # type: ignore[arg-type]
    assert scalars["border"].mid == 3
    assert scalars["growth_rate"].mid == scalars["growth_rate"].radius == 0
    # exp(-2 b 40) of the other root is left: 1e-13.
    late = at(F(40), **given)
    sense = 1 if turning > 0 else -1
    assert late["vx"] == pytest.approx(float(-2 * sense * late["y"]), abs=1e-12)
    assert late["vy"] == pytest.approx(float(2 * sense * late["x"]), abs=1e-12)
    assert late["x"] ** 2 + late["y"] ** 2 > F(1, 10)


@pytest.mark.parametrize("part", [F(1, 10**6), F(1, 10**30)])
def test_the_sign_of_the_rate_changes_at_the_border(part: F) -> None:
    def rate(turning: F) -> F:
        ball = truth({**SHAFT, "turning": turning}, SCALE).scalars()["growth_rate"]  # type: ignore[arg-type]
        assert ball.radius < part / 1000
        return ball.mid

    assert rate(3 * (1 + part)) > 0 > rate(3 * (1 - part))


def test_without_inner_damping_there_is_no_border_and_nothing_grows() -> None:
    scalars = truth({**SHAFT, "inner_damping": F(0)}, SCALE).scalars()  # type: ignore[arg-type]
    assert set(scalars) == {"growth_rate"}
    assert scalars["growth_rate"].mid == pytest.approx(-1 / 8)


def test_roots_that_are_the_same_are_decided_and_those_beside_them_are_close() -> None:
    there = at(F(2), **DOUBLE)
    for turning in (F(1, 10**30), F(-1, 10**30)):
        beside = at(F(2), **{**DOUBLE, "turning": turning})
        assert all(0 < abs(beside[name] - there[name]) < F(1, 10**28) for name in there)


@pytest.mark.parametrize("turning", [F(0), F(1), F(-40), F(200)])
@pytest.mark.parametrize("outer", [F(40), F(400)])
def test_the_bound_of_an_overdamped_growth_is_above_it_and_not_far(outer: F, turning: F) -> None:
    """|exp(J t)|, the largest sum of a row, at times up to t; 2 sqrt 2 is what the bound loses."""
    given = {**SHAFT, "outer_damping": outer, "turning": turning}
    shaft = truth(given, SCALE)  # type: ignore[arg-type]
    assert isinstance(shaft, WhirlingShaft)
    for t in (F(1, 100), F(1), F(20)):
        bound = shaft.sensitivity(t)
        with precision(128):
            largest = max(norm(shaft, t * part / 64) for part in range(65))
        assert largest <= bound
        if t == 20:
            assert bound <= 3 * largest


def norm(shaft: WhirlingShaft, t: F) -> float:
    """|exp(J t)| for x, y, vx, vy in scales."""
    z_by_z, z_by_v, v_by_z, v_by_v = shaft.moved(arb_of(t))
    ratio = float(SCALE["x"] / SCALE["vx"])
    rows = [
        [abs(complex(z_by_z).real) + abs(complex(z_by_z).imag), z_by_v, 1 / ratio],
        [abs(complex(v_by_v).real) + abs(complex(v_by_v).imag), v_by_z, ratio],
    ]
    sums = []
    for diagonal, other, factor in rows:
        value = complex(other)
        sums.append(diagonal + factor * (abs(value.real) + abs(value.imag)))
    return max(sums)
