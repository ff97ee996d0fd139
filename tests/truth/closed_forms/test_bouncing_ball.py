"""A bouncing ball: held-out throws against rational arithmetic that shares nothing with the truth,
what has long been known, and how errors grow.
"""

import random
from fractions import Fraction
from itertools import pairwise

import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.surds import Surd, sign
from tests.rationals import RandomFractions, text
from tests.truth.displaced_starts import largest_growth

CASE = discovery.case("bouncing-ball")
NAMES = ("x", "y", "vx", "vy", "omega")
TINY = Fraction(1, 10**38)


def random_throw(seed: int) -> dict[str, str]:
    """A throw that reaches the plane with a rational speed v_1: 2 g h = v_1^2 - u^2."""
    rng = random.Random(seed)
    fractions = RandomFractions(rng)
    upwards = fractions.between(-10, 10)
    gravity = fractions.between(20, 90)
    speed = abs(upwards) + fractions.between(5, 40)
    height = (speed**2 - upwards**2) / (2 * gravity)
    return {
        "mass": str(fractions.between(1, 30)),
        "radius": str(fractions.between(1, 9)),
        "inertia_factor": str(Fraction(rng.randint(1, 10), 10)),
        "height": str(height),
        "velocity": text([fractions.between(-20, 20), upwards]),
        "spin": str(fractions.between(-20, 20)),
        "gravity": str(gravity),
        "restitution": str(Fraction(rng.randint(4, 8), 8)),
        "tangential_restitution": str(Fraction(rng.randint(0, 4), 4)),
        "friction": rng.choice(["0", "1/16", "1/4", "10"]),
        "bounces": str(rng.randint(1, 8)),
    }


def by_flights(given: dict[str, str], end: Fraction):
    """The times of all bounces before the end, and the state there (x, y, vx, vy, omega).

    Each flight is that of a stone thrown up, and each bounce is told by the speed of the point that
    touches, vx + R omega: the impulse along the plane changes it by P/m (1 + 1/f), and omega by P
    R/J = P/(f m R).
    """
    numbers = {k: Fraction(v) for k, v in given.items() if k != "velocity"}
    vx, vy = (Fraction(x) for x in given["velocity"].split(","))
    g, e, b = numbers["gravity"], numbers["restitution"], numbers["tangential_restitution"]
    f, radius, mu = numbers["inertia_factor"], numbers["radius"], numbers["friction"]
    x, omega = Fraction(0), numbers["spin"]
    squared = vy * vy + 2 * g * numbers["height"]
    speed = Fraction(_root(squared.numerator), _root(squared.denominator))
    now = Fraction(0)
    height = numbers["height"]
    bounce = (vy + speed) / g
    times = []
    while bounce <= end:
        times.append(bounce)
        x += vx * (bounce - now)
        contact = vx + radius * omega
        # Impulses per mass.
        normal = (1 + e) * speed
        needed = -(1 + b) * contact / (1 + 1 / f)
        along = max(-mu * normal, min(mu * normal, needed))
        vx += along
        omega += along / (f * radius)
        speed = vy = e * speed
        now = bounce
        height = Fraction(0)
        bounce = now + 2 * speed / g
    since = end - now
    y = radius + height + vy * since - g * since**2 / 2
    return times, (x + vx * since, y, vx, vy - g * since, omega)


def _root(square: int) -> int:
    from math import isqrt

    root = isqrt(square)
    assert root * root == square
    return root


@pytest.mark.parametrize("seed", range(40))
def test_held_out_throws_agree_with_rational_arithmetic(seed):
    given = random_throw(seed)
    instance = CASE.at(**given)
    truth = instance.truth()
    last = Fraction(float(instance.times[-1]))
    for part in (Fraction(1, 7), Fraction(1, 2), Fraction(6, 7), Fraction(1)):
        _, state = by_flights(given, last * part)
        told = truth.at(last * part)
        for name, value in zip(NAMES, state, strict=True):
            assert abs(told[name].mid - value) <= told[name].radius <= TINY
    times, _ = by_flights(given, last)
    scalars = truth.scalars()
    assert scalars["bounces"].mid == len(times) == int(given["bounces"])
    assert abs(scalars["first_bounce"].mid - times[0]) <= TINY
    # The list has the bounce after the end, too.
    number_listed = sum(name.endswith("_closing") for name in scalars)
    assert number_listed == len(times) + 1
    assert scalars[f"impact_{number_listed}"].mid > last
    e = Fraction(given["restitution"])
    if e < 1:
        # The flights that are still to come, each e times as long as the one before.
        longer = [now - before for before, now in pairwise(times)]
        if longer:
            assert (
                abs(scalars["accumulation_time"].mid - times[-1] - longer[-1] * e / (1 - e)) <= TINY
            )


@pytest.mark.parametrize("seed", range(8))
def test_energy_falls_by_what_is_lost(seed):
    given = random_throw(seed)
    instance = CASE.at(**given)
    last = Fraction(float(instance.times[-1]))
    mass, radius, f, g = (
        Fraction(given[k]) for k in ("mass", "radius", "inertia_factor", "gravity")
    )
    energies = []
    for t in (Fraction(0), last):
        _, (_, y, vx, vy, omega) = by_flights(given, t)
        turning = f * radius**2 * omega**2
        energies.append(mass * (vx**2 + vy**2 + turning) / 2 + mass * g * y)
    lost = instance.truth().scalars()["energy_lost"].mid
    assert abs(energies[0] - energies[1] - lost) <= TINY


def test_a_ball_from_two_metres_at_unit_gravity():
    """v_1 = 2 m/s, t_1 = 2 s; at e = 1/2 the flights last 2, 1, 1/2 s, and T = 6 s."""
    truth = CASE.at(gravity="1", restitution="1/2").truth()
    scalars = truth.scalars()
    assert scalars["first_bounce"].mid == 2
    assert scalars["accumulation_time"].mid == 6
    assert truth.at(Fraction(3))["y"].mid == 1
    assert truth.at(Fraction(9, 2))["y"].mid == Fraction(5, 8)


def test_heights_fall_by_the_square_of_the_restitution():
    """The highest point after bounce n is e^(2 n) h; e^2 = (h_n/h)^(1/n)."""
    truth = CASE.at(gravity="1", restitution="1/2", bounces="4").truth()
    # The middles of the flights: 3, 4.5, 5.25 s.
    for n, middle in enumerate((Fraction(3), Fraction(9, 2), Fraction(21, 4)), start=1):
        told = truth.at(middle)
        assert told["y"].mid - Fraction(1, 2) == 2 * Fraction(1, 4) ** n
        assert told["vy"].mid == 0


def test_friction_that_stops_the_slip_leaves_a_ball_that_rolls():
    """A solid sphere without spin keeps 5/7 of its velocity, whatever the friction that suffices
    (Garwin's formula at b = 0).
    """
    told = CASE.at(velocity="7,0", friction="10", bounces="2").truth().at(Fraction(3, 2))
    assert abs(told["vx"].mid - 5) <= TINY
    assert abs(told["vx"].mid + told["omega"].mid / 2) <= TINY


def test_at_a_bounce_velocities_have_no_value_and_after_the_last_one_nothing_is_told():
    truth = CASE.at(gravity="1", restitution="1/2", duration="9/2").truth()
    for t in (Fraction(2), Fraction(4)):
        with pytest.raises(NotCertifiedError, match="jump"):
            truth.at(t)
    assert truth.at(Fraction(4) + Fraction(1, 2))
    with pytest.raises(NotCertifiedError, match="bounces are followed") as caught:
        truth.at(Fraction(23, 4))
    assert caught.value.code == "time"


@pytest.mark.parametrize("friction", ["0", "1/16", "10"])
def test_no_start_that_is_displaced_a_little_goes_farther_than_s(friction):
    given = {"velocity": "3,1", "spin": "2", "friction": friction, "bounces": "4"}
    instance = CASE.at(**given)
    truth = instance.truth()
    t = Fraction(float(instance.times[-1]))
    observed = largest_growth(instance, Fraction(1, 10**15), t, NAMES)
    s = truth.sensitivity(t)
    assert observed <= s * (1 + 1e-6)
    assert s <= 20 * observed


def test_s_grows_without_bound_towards_the_end_of_the_bounces():
    """In one scale: an error of the place is one of the speed by (1 + e) g/v_n at bounce n."""
    seen = []
    for bounces in (4, 8, 12):
        instance = CASE.at(bounces=str(bounces), restitution="1/2")
        seen.append(instance.truth().sensitivity(Fraction(float(instance.times[-1]))))
    assert seen[0] < seen[1] / 4 < seen[2] / 16


def test_a_quotient_of_surds_times_its_divisor_is_what_was_divided():
    first = Surd(Fraction(3, 7), Fraction(-2, 5), Fraction(11))
    second = Surd(Fraction(-1, 3), Fraction(5, 2), Fraction(11))
    quotient = first / second
    assert sign(quotient * second - first) == 0
    assert sign(first / 2 * 2 - first) == 0
    assert sign(Fraction(-1, 3)) == -1
