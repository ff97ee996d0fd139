"""Kapitza's pendulum: against another integration, Hill's determinant, the published limits of
stability, and its rest on a still pivot.
"""

from fractions import Fraction

import pytest
from flint import arb, arb_mat

from refdem.core.discovery import case, truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import kapitza_pendulum as module

TIMES = (Fraction(1, 3), Fraction(2))
sound = module.field


@pytest.mark.parametrize(
    "given",
    [
        {},
        {
            "length": "3",
            "gravity": "9.81",
            "drive_amplitude": "1",
            "drive": "7",
            "theta0": "-2",
            "thetadot0": "1",
        },
    ],
)
def test_angle_meets_the_witness(apart, given):
    assert apart("kapitza-pendulum", TIMES, **given) == {}


PLANTED = {
    "acceleration of the pivot of the wrong sign": lambda p, y: (
        y[0].sin() * y[2] * (2 * p["drive_amplitude"] * p["drive"] ** 2 / p["length"])
    ),
    "drive out of phase": (
        lambda p, y: (
            y[0].sin() * (y[2] - y[3]) * (p["drive_amplitude"] * p["drive"] ** 2 / p["length"])
        )
    ),
    "a hair of damping": lambda p, y: y[1] * Fraction(-1, 10**18),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault, monkeypatch):
    def field(p):
        def wrong(y):
            rate, turning, *rest = sound(p)(y)
            return rate, turning + PLANTED[fault](p, y), *rest

        return wrong

    monkeypatch.setattr(module, "field", field)
    assert apart("kapitza-pendulum", TIMES[:1])


def hill(amplitude, drive, size=8):
    """Trace of the motion about the top over one period, g = l = 1: 2 - 4 D sin^2(pi sqrt(A)/2), D
    being Hill's determinant.

    It is that of y'' + (A - 2 q cos 2z) y = 0 with A = -4/W^2, q = 2 a (Whittaker and Watson,
    section 19.42); the determinant is cut off at `size`, its tail being of order 1/size.
    """
    with precision(200):
        first = -4 / arb_of(drive) ** 2
        q = 2 * arb_of(amplitude)

        def entry(n, m):
            if n == m:
                return arb(1)
            if abs(n - m) == 1:
                return q / (4 * n * n - first)
            return arb(0)

        indices = range(-size, size + 1)
        determinant = arb_mat([[entry(n, m) for m in indices] for n in indices]).det()
        root = (-first).sqrt() * arb.pi() / 2
        return float(2 + 4 * determinant * root.sinh() ** 2)


@pytest.mark.parametrize(
    ("amplitude", "drive"),
    [("1/4", "10"), ("1/10", "3"), ("1/2", "10"), ("0.45", "30"), ("1", "8")],
)
def test_trace_is_that_of_hills_determinant(amplitude, drive):
    p = case("kapitza-pendulum").at(drive_amplitude=amplitude, drive=drive).p
    exact = {name: p[name] for name in ("length", "gravity", "drive_amplitude", "drive")}
    with precision(200):
        found = float(module.trace(exact))
    limit = 2 * hill(Fraction(amplitude), Fraction(drive), 40) - hill(
        Fraction(amplitude), Fraction(drive), 20
    )
    assert found == pytest.approx(limit, rel=1e-3)


def is_stable(**given):
    """Both multipliers are on the unit circle."""
    found = truth_of(
        "kapitza-pendulum", **{name: str(value) for name, value in given.items()}
    ).scalars()
    assert abs(float(found["floquet_1"].mid) * float(found["floquet_2"].mid) - 1) < 2e-15
    return abs(found["floquet_1"].mid) <= 1


@pytest.mark.parametrize(("drive", "ratio"), [(10, "1.0087"), (30, "1.00097")])
def test_the_top_becomes_stable_where_the_catalogue_says(drive, ratio):
    # (a W)^2/(2 g l) at the limit, to the digits given: unstable half a digit below, stable half a
    # digit above
    last = Fraction(1, 2 * 10 ** len(ratio.partition(".")[2]))
    for side, stable in ((-1, False), (1, True)):
        amplitude = ((2 * (float(ratio) + side * float(last))) ** 0.5) / drive
        assert is_stable(drive=drive, drive_amplitude=f"{amplitude:.15f}") is stable


def test_stability_ends_at_an_amplitude_near_45_hundredths_by_doubling_the_period():
    assert is_stable(drive=300, drive_amplitude="0.4535")
    assert not is_stable(drive=300, drive_amplitude="0.4545")
    beyond = truth_of("kapitza-pendulum", drive="300", drive_amplitude="0.46").scalars()[
        "floquet_1"
    ]
    assert beyond.mid < -1


def test_on_a_pivot_at_rest_multipliers_are_those_of_the_hyperbola():
    found = truth_of("kapitza-pendulum", drive_amplitude="0", drive="2", gravity="1").scalars()
    with precision(200):
        expected = arb.pi().exp()
        assert abs(arb_of(found["floquet_1"].mid) - expected) < 1e-35
        assert abs(arb_of(found["floquet_2"].mid) * expected - 1) < 1e-35
