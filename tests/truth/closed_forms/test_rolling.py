"""A body that slides until it rolls: held-out starts against rational arithmetic that has nothing
of the truth, what has long been known, borders that are decided exactly, and how errors grow.
"""

import random
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from refdem.core import discovery
from refdem.truth.closed_forms import rolling
from refdem.truth.closed_forms.rolling import STATE

CASE = discovery.case("rolling")
NAMES = ("x", "y", "vx", "vy", "omega")
TINY = Fraction(1, 10**38)
TRIPLES = ((0, 1, 1), (3, 4, 5), (4, 3, 5), (5, 12, 13), (12, 5, 13), (7, 24, 25), (24, 7, 25))
"""Slopes whose sine, cosine and tangent are rational: opposite, adjacent, hypotenuse."""


def drawn(seed: int) -> tuple[dict[str, str], Fraction, Fraction]:
    """Parameters with a rational sine and cosine of the slope, and these two."""
    rng = random.Random(seed)

    def part(low, high):
        return Fraction(rng.randint(low, high), rng.randint(3, 11))

    opposite, adjacent, hypotenuse = rng.choice(TRIPLES)
    factor = rng.choice([Fraction(2, 5), Fraction(2, 3), Fraction(1, 2), Fraction(1)])
    slope = Fraction(opposite, adjacent)
    # Below, at and above the critical slope.
    friction = rng.choice([part(1, 9), slope / (1 + 1 / factor), Fraction(0)])
    radius = part(1, 9)
    speed = part(-40, 40)
    spin = rng.choice([part(-40, 40), -speed / radius, Fraction(0)])
    given = {
        "mass": str(part(1, 30)),
        "radius": str(radius),
        "inertia_factor": str(factor),
        "speed": str(speed),
        "spin": str(spin),
        "friction": str(friction),
        "slope": str(slope),
        "gravity": str(part(5, 90)),
    }
    return given, Fraction(opposite, hypotenuse), Fraction(adjacent, hypotenuse)


def by_forces(given: dict[str, str], sine: Fraction, cosine: Fraction, end: Fraction):
    """The state (x, y, vx, vy, omega) at the end, and the work of friction: Newton's and Euler's
    equations with the friction F that Coulomb's inclusion picks, from one change of it to the next.
    """
    n = {name: Fraction(value) for name, value in given.items()}
    m, radius, g = n["mass"], n["radius"], n["gravity"]
    inertia = n["inertia_factor"] * m * radius**2
    most = n["friction"] * m * g * cosine
    x, v, omega = Fraction(0), n["speed"], n["spin"]
    now, work = Fraction(0), Fraction(0)
    while now < end:
        slip = v + radius * omega
        # The friction with which the point of contact stays where it is: s' = 0.
        holding = -m * g * sine / (1 + m * radius**2 / inertia)
        if slip > 0 or (slip == 0 and -holding > most):
            force = -most
        elif slip < 0:
            force = most
        else:
            force = holding
        a = g * sine + force / m
        alpha = force * radius / inertia
        rate = a + radius * alpha
        step = end - now
        if slip * rate < 0:
            step = min(step, -slip / rate)
        work += abs(force * (slip * step + rate * step**2 / 2))
        x += v * step + a * step**2 / 2
        v += a * step
        omega += alpha * step
        now += step
    return (x, radius, v, Fraction(0), omega), work


@pytest.mark.parametrize("seed", range(60))
def test_held_out_starts_agree_with_rational_arithmetic(seed):
    given, sine, cosine = drawn(seed)
    instance = CASE.at(**given)
    truth = instance.truth()
    last = Fraction(float(instance.times[-1]))
    for part in (Fraction(1, 7), Fraction(1, 2), Fraction(6, 7), Fraction(1)):
        state, _ = by_forces(given, sine, cosine, last * part)
        told = truth.at(last * part)
        for name, value in zip(NAMES, state, strict=True):
            assert abs(told[name].mid - value) <= told[name].radius <= TINY
    scalars = truth.scalars()
    if "roll_time" in scalars:
        _, work = by_forces(given, sine, cosine, scalars["roll_time"].mid)
        assert abs(scalars["friction_work"].mid - work) <= TINY * 10**6


def test_the_draws_hold_every_kind_of_motion():
    kinds = set()
    for seed in range(60):
        given, _, _ = drawn(seed)
        truth = CASE.at(**given).truth()
        kinds.add(tuple(phase.side for phase in truth.phases))
    assert kinds == {(1,), (-1,), (0,), (1, 0), (-1, 0), (-1, 1)}


@pytest.mark.parametrize(
    ("factor", "kept", "sliding"),
    [("2/5", "5/7", "2/7"), ("2/3", "3/5", "2/5"), ("1/2", "2/3", "1/3"), ("1", "1/2", "1/2")],
)
def test_a_body_without_spin_keeps_a_part_of_its_speed(factor, kept, sliding):
    """5/7 of it a solid sphere, whatever the friction, after t = 2 v0/(7 mu g) (Coriolis 1835)."""
    scalars = (
        CASE.at(speed="2", friction="1/4", gravity="10", inertia_factor=factor).truth().scalars()
    )
    assert abs(scalars["roll_speed"].mid - 2 * Fraction(kept)) <= TINY
    assert abs(scalars["roll_time"].mid - Fraction(sliding) * 2 / Fraction(10, 4)) <= TINY
    # The energy m v0^2/2 of the slide loses the part 1 - kept: work of friction alone.
    assert abs(scalars["friction_work"].mid - 2 * (1 - Fraction(kept))) <= TINY


def test_backspin_brings_a_sphere_back_and_some_backspin_stops_it_dead():
    back = CASE.at(speed="1", spin="30").truth().scalars()
    assert abs(back["roll_speed"].mid + Fraction(25, 7)) <= TINY
    # v0 = (2/5) R omega0: no angular momentum about the line of contact.
    dead = CASE.at(speed="4", spin="20").truth()
    assert dead.scalars()["roll_speed"].mid == 0
    assert dead.at(Fraction(3))["vx"].mid == dead.at(Fraction(3))["omega"].mid == 0


def test_topspin_speeds_a_sphere_up():
    scalars = CASE.at(speed="1", spin="-30").truth().scalars()
    assert abs(scalars["roll_speed"].mid - Fraction(35, 7)) <= TINY


def test_the_critical_slope_is_decided_exactly():
    """At tan a = 7/2 mu a solid sphere just rolls from rest; a hair above it slides, for ever."""
    at = CASE.at(speed="0", slope="7/8").truth()
    above = CASE.at(speed="0", slope="0.875000000000000000000000000001").truth()
    assert [phase.side for phase in at.phases] == [0]
    assert [phase.side for phase in above.phases] == [1]
    # A slip down the critical slope neither ends nor grows.
    sliding = CASE.at(slope="7/8").truth()
    assert sliding.scalars() == {}
    for t in (Fraction(1), Fraction(1000)):
        told = sliding.at(t)
        assert abs(told["vx"].mid + told["omega"].mid / 2 - 4) <= TINY


def test_a_body_that_rolls_from_the_start_is_known_to():
    """v0 = -omega R in decimals that binary64 does not have."""
    truth = CASE.at(radius="1/10", speed="0.3", spin="-3").truth()
    assert [phase.side for phase in truth.phases] == [0]
    assert abs(truth.at(Fraction(7))["x"].mid - Fraction(21, 10)) <= TINY


def test_without_friction_nothing_turns():
    told = CASE.at(friction="0", slope="3/4", gravity="10", spin="3").truth().at(Fraction(2))
    assert abs(told["vx"].mid - 16) <= TINY
    assert told["omega"].mid == 3


def test_at_the_end_of_the_slip_itself_the_state_is_told():
    truth = CASE.at(gravity="10", speed="7", friction="1/7", inertia_factor="2/5").truth()
    end = Fraction(14) / Fraction(10)
    assert abs(truth.scalars()["roll_time"].mid - end) <= TINY
    assert abs(truth.at(end)["vx"].mid - 5) <= TINY


GROWN = [
    {},
    {"spin": "20"},
    {"spin": "-8"},
    {"slope": "3/4", "speed": "-2"},
    {"slope": "7/8"},
    {"slope": "7/8", "speed": "-2"},
    {"slope": "7/8", "speed": "0"},
    {"slope": "1", "speed": "0"},
    {"slope": "2", "speed": "-4"},
    {"friction": "0"},
]


@pytest.mark.parametrize("spins", [1, 16, 1 / 16])
@pytest.mark.parametrize("given", GROWN, ids=str)
def test_no_error_made_at_any_time_grows_beyond_s(given, spins):
    """Errors of either sign of all coordinates at once, at the start and at times in between; where
    errors of omega count more or less than they would, friction makes larger ones of smaller ones.
    """
    instance = CASE.at(**given)
    last = Fraction(float(instance.times[-1]))
    scale = {name: quantity.scale for name, quantity in instance.quantities.items()}
    scale["omega"] *= spins
    truth = rolling.truth(instance.p, scale)
    size = Fraction(1, 10**12)
    grown = []
    for part in (Fraction(0), Fraction(1, 3), Fraction(19, 40), Fraction(3, 4)):
        made = last * part
        now = truth.at(made)
        for sides in product((-1, 1), repeat=len(STATE)):
            # The motion that starts anew from the state there, with errors of all coordinates.
            state = [
                Fraction(now[name].mid) + side * size * Fraction(scale[name])
                for name, side in zip(STATE, sides, strict=True)
            ]
            start = dict(zip(("place", "speed", "spin"), state, strict=True))
            other = replace(CASE.at(**given).truth(), **start)
            told = other.at(last - made)
            whole = truth.at(last)
            away = [abs(float(told[n].mid - whole[n].mid)) / scale[n] for n in NAMES]
            grown.append(max(away) / float(size))
    s = truth.sensitivity(last)
    assert max(grown) <= s * (1 + 1e-6)
    # 14 per cent is what the cells may add, the rest what lies between the times above.
    assert s <= 1.3 * max(grown)


def test_friction_that_turns_round_magnifies_no_slip():
    """Above the critical slope an error of the slip is multiplied by (tan a - mu k)/(tan a + mu
    k).
    """
    truth = CASE.at(slope="2", speed="-4").truth()
    matrix = np.array([[float(x) for x in row] for row in truth.incline.reversed()])
    slip = np.array([0.0, 1.0, float(truth.incline.radius)])
    limit = 0.875
    assert np.allclose(slip @ matrix, (2 - limit) / (2 + limit) * slip, rtol=1e-14, atol=0)
    # A body that rolls has lost it all, and keeps its moment about the line of contact.
    held = np.array([[float(x) for x in row] for row in truth.incline.held()])
    moment = np.array([0.0, 1.0, -0.4 * 0.5])
    assert np.allclose(slip @ held, 0.0, atol=1e-15)
    assert np.allclose(moment @ held, moment, rtol=1e-14, atol=1e-15)
