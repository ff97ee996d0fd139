"""Pendulum: against the Taylor witness, the equation of motion, published periods, and planted
errors.
"""

from contextlib import suppress
from fractions import Fraction
from itertools import pairwise

import pytest
from flint import arb

from refdem.core.discovery import case, truth_of
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.closed_forms.pendulum import Equilibrium, Pendulum, Revolution, Separatrix, Swing
from refdem.truth.refiner import Refiner
from tests.quadratic_flows import pendulum_flow

NAMES = ("theta", "thetadot", "x", "y", "rod_force")
STARTS = [
    (Swing, "1", "0", 0),
    (Swing, "-2", "1/3", 0),
    (Swing, "0", "1", 0),
    (Swing, "3.14159265358979323846264338", "0", 0),
    (Swing, "9", "1/3", 0),
    (Swing, "-1e-30", "0", 1),
    (Swing, "0.5", "-0.1", 3),
    (Revolution, "0.5", "-3", 0),
    (Revolution, "-20", "2.9", 0),
    (Revolution, "0", "1e-20", 1),
    (Revolution, "0", "-2.0000000000000000001", 0),
    (Revolution, "-0.3", "-1", -5),
    (Separatrix, "0", "2", 0),
    (Separatrix, "0", "-2", 2),
    (Equilibrium, "0", "0", 0),
    (Equilibrium, "0", "0", 1),
    (Equilibrium, "0", "0", -2),
]


def pendulum(theta0, thetadot0, half_turns=0):
    """Unit mass, length and gravity: w0 = 1."""
    one = Fraction(1)
    exact = {
        "mass": one,
        "length": one,
        "gravity": one,
        "theta0": Fraction(theta0),
        "thetadot0": Fraction(thetadot0),
    }
    return Pendulum(refiner=Refiner.of(dict.fromkeys(NAMES, 1.0)), half_turns=half_turns, **exact)


def misses(truth, t=Fraction(5)):
    """The quantities in which a truth and the witness exclude each other."""
    theta = arb_of(truth.theta0) + truth.half_turns * arb.pi()
    cosine, sine, rate = pendulum_flow(theta, truth.thetadot0, Fraction(1), t, order=60)
    assert max(x.rad() for x in (cosine, sine, rate)) < 1e-25
    found = truth.evaluate(arb_of(t))
    expected = {"thetadot": rate, "x": sine, "y": -cosine, "rod_force": rate * rate + cosine}
    return [name for name, value in expected.items() if not found[name].overlaps(value)]


@pytest.mark.parametrize(("kind", "theta0", "thetadot0", "half_turns"), STARTS)
def test_closed_form_meets_the_taylor_witness(kind, theta0, thetadot0, half_turns):
    truth = pendulum(theta0, thetadot0, half_turns)
    with precision(400):
        assert type(truth.motion()) is kind
        assert misses(truth) == []


PLANTED = {
    "phase at the start of the wrong sign": ("0.5", "1", lambda m: vars(m).update(shift=-m.shift)),
    "other branch at the start": (
        "0.5",
        "1",
        lambda m: vars(m).update(shift=2 * m.jacobi.k - m.shift),
    ),
    "sense of the revolution": ("0.5", "-3", lambda m: vars(m).update(sense=-m.sense)),
    "modulus off by 1e-20": ("0.5", "-3", lambda m: vars(m).update(k=m.k * (1 + arb("1e-20")))),
    "side of the separatrix": ("0", "2", lambda m: vars(m).update(sense=-m.sense)),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees_a_wrong(fault):
    theta0, thetadot0, plant = PLANTED[fault]
    truth = pendulum(theta0, thetadot0)
    with precision(400):
        plant(truth.motion())
        assert misses(truth)


@pytest.mark.parametrize("t", [Fraction(0), Fraction(-7, 3), Fraction(1000)])
@pytest.mark.parametrize(("kind", "theta0", "thetadot0", "half_turns"), STARTS)
def test_equation_of_motion_and_energy_hold_at_any_time(kind, theta0, thetadot0, half_turns, t):
    truth = pendulum(theta0, thetadot0, half_turns)
    with precision(3200):
        h = arb(2) ** -400
        time = arb_of(t)
        before, now, after = (truth.evaluate(x) for x in (time - h, time, time + h))
        rate = (after["theta"] - before["theta"]) / (2 * h)
        acceleration = (after["thetadot"] - before["thetadot"]) / (2 * h)
        assert abs(rate - now["thetadot"]) < arb("1e-100")
        assert abs(acceleration + now["theta"].sin()) < arb("1e-100")
        start = arb_of(truth.theta0) + half_turns * arb.pi()
        energy = arb_of(truth.thetadot0) ** 2 / 2 - start.cos()
        assert abs(now["thetadot"] * now["thetadot"] / 2 + now["y"] - energy) < arb("1e-100")
        if t == 0:
            assert abs(now["theta"] - start) < arb("1e-100")


@pytest.mark.parametrize(("kind", "theta0", "thetadot0", "half_turns"), STARTS)
def test_balls_of_forty_digits_contain_those_of_a_hundred(kind, theta0, thetadot0, half_turns):
    truth = pendulum(theta0, thetadot0, half_turns)
    for t in (Fraction(1, 3), Fraction(1000)):
        wide = truth.at(t)
        narrow = truth.refined(100).at(t)
        assert all(ball.radius <= Fraction(1, 10**40) for ball in wide.values())
        assert all(
            abs(ball.mid - narrow[name].mid) <= ball.radius + narrow[name].radius
            for name, ball in wide.items()
        )


@pytest.mark.parametrize("bits", [53, 80, 200])
@pytest.mark.parametrize(("kind", "theta0", "thetadot0", "half_turns"), STARTS)
def test_balls_of_few_bits_contain_the_values_of_many(kind, theta0, thetadot0, half_turns, bits):
    truth = pendulum(theta0, thetadot0, half_turns)
    t = Fraction(3, 2)
    with precision(1000):
        sure = truth.evaluate(arb_of(t))
    with precision(bits), suppress(UndecidedError):
        assert [
            name
            for name, ball in truth.evaluate(arb_of(t)).items()
            if not ball.contains(sure[name])
        ] == []


def test_angle_is_continuous_over_many_revolutions():
    truth = pendulum("0", "3")
    angles = [float(truth.at(Fraction(k, 4))["theta"].mid) for k in range(200)]
    steps = [b - a for a, b in pairwise(angles)]
    assert 0.25 * 5**0.5 < min(steps) < max(steps) < 0.75
    assert angles[-1] > 100


@pytest.mark.parametrize(
    ("theta0", "factor"),
    # T/(2 pi sqrt(l/g)) = 1/agm(1, cos(theta0/2)): 1.1803405990 at 90 degrees (K(1/2) 2/pi); series
    # 1 + a^2/16 + 11 a^4/3072 at 1e-3
    [
        ("1.5707963267948966192313216916397514420985846996875529104875", 1.18034059901609622604),
        ("1e-3", 1.0000000625000035807),
    ],
)
def test_period_of_a_swing_is_the_published_one(theta0, factor):
    period = pendulum(theta0, "0").scalars()["period"]
    assert float(period.mid) == pytest.approx(6.283185307179586476925 * factor, rel=2e-15)


def test_a_revolution_takes_its_period():
    truth = pendulum("0.5", "-3")
    with precision(300):
        end = truth.evaluate(truth.constants()["period"])
        assert end["theta"].overlaps(arb("0.5") - 2 * arb.pi())
        assert end["thetadot"].overlaps(arb(-3))


@pytest.mark.parametrize(
    ("theta0", "thetadot0", "half_turns"), [("0", "2", 0), ("0", "0", 0), ("0", "0", 1)]
)
def test_separatrix_and_rest_have_no_period(theta0, thetadot0, half_turns):
    assert pendulum(theta0, thetadot0, half_turns).scalars() == {}


def test_exactly_at_the_top_it_stays_and_next_to_it_it_leaves_as_cosh():
    assert pendulum("0", "0", 1).at(Fraction(100))["thetadot"].mid == 0
    end = float(pendulum("1e-12", "0", 1).at(Fraction(5))["x"].mid)
    assert end == pytest.approx(-1e-12 * 74.20994852478785, rel=1e-12)


def test_quantities_and_units_are_those_of_the_case():
    instance = case("pendulum").at(
        length="2", mass="3", gravity="9.8125", theta0="0.5", thetadot0="1"
    )
    start = instance.truth().at(Fraction(0))
    assert set(start) == set(instance.quantities)
    expected = {
        "x": 2 * 0.479425538604203,
        "y": -2 * 0.8775825618903728,
        "rod_force": 3 * (2 + 9.8125 * 0.8775825618903728),
    }
    assert {name: float(start[name].mid) for name in expected} == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("given", [{}, {"theta0": "3"}, {"theta0": "1", "thetadot0": "7"}])
def test_sensitivity_is_the_response_of_the_witness_to_a_small_change(given):
    p = case("pendulum").at(**given).p
    truth = truth_of("pendulum", **given)
    t = Fraction(3, 2)
    h = Fraction(1, 10**12)
    rate = Fraction(truth.scale["thetadot"])
    ratio = Fraction(p["gravity"])
    with precision(300):
        moves = ((h, 0), (0, h * rate))
        ends = [
            [
                pendulum_flow(
                    arb_of(p["theta0"] + s * a), p["thetadot0"] + s * b, ratio, t, order=40
                )
                for s in (1, -1)
            ]
            for a, b in moves
        ]
        columns = [[(a - b) / (2 * arb_of(h)) for a, b in zip(*pair, strict=True)] for pair in ends]
        tilt = [float((c[0] * c[0] + c[1] * c[1]).sqrt()) for c in columns]
        speed = [abs(float(c[2])) / float(rate) for c in columns]
        rows = [sum(abs(float(entry)) for entry in row) for row in truth.jacobian(t).table()]
    assert rows[0] == pytest.approx(sum(tilt), rel=1e-9)
    assert rows[1] == pytest.approx(sum(speed), rel=1e-9)
    assert truth.sensitivity(t) >= max(rows) * (1 - 1e-12)
