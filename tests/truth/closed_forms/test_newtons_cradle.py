"""Balls in a line: held-out settings against rational arithmetic that shares nothing with the
truth, what has long been known of them, and how errors grow.
"""

import random
from fractions import Fraction
from itertools import pairwise

import pytest

from refdem.core import discovery
from refdem.errors import NotCertifiedError, UsageError
from tests.rationals import RandomFractions, text
from tests.truth.displaced_starts import largest_growth

CASE = discovery.case("newtons-cradle")
SEVEN = 7


def random_line(seed: int) -> dict[str, str]:
    """A line of 3 to 7 balls with any masses, radii, gaps and velocities, and a restitution at
    which they meet a finite number of times.
    """
    rng = random.Random(seed)
    fractions = RandomFractions(rng)
    count = rng.randint(3, SEVEN)
    masses = fractions.list_of(SEVEN, 1, 30)
    radii = fractions.list_of(SEVEN, 1, 9)
    gaps = fractions.list_of(SEVEN - 1, 1, 9)
    # The first ball is the fastest, so that some impact follows.
    first = 20 + fractions.between(1, 9)
    others = fractions.list_of(SEVEN - 1, -20, 20)
    return {
        "balls": str(count),
        "masses": text(masses),
        "radii": text(radii),
        "gaps": text(gaps),
        "velocities": text([first, *others]),
        "restitution": str(Fraction(rng.randint(5, 8), 8)),
    }


def by_world_lines(given: dict[str, str]):
    """All impacts as (time, left ball), and functions of time for places and velocities.

    Every ball has a world line x = a + v t, from its last impact on and as if it had always been
    on it; neighbours meet where the surfaces' lines cross. Velocities come from the frame of the
    centre of mass of the pair, in which each is multiplied by -e.
    """
    count = int(given["balls"])
    names = ("masses", "radii", "gaps", "velocities")
    masses, radii, gaps, v = ([Fraction(x) for x in given[name].split(",")] for name in names)
    e = Fraction(given["restitution"])
    v = v[:count]
    # Surfaces are taken out: with points in place of balls only the gaps are left.
    widths = [2 * sum(radii[:k]) + radii[k] - radii[0] for k in range(count)]
    a = [sum(gaps[:k], Fraction(0)) for k in range(count)]
    lines = [(Fraction(0), list(a), list(v))]
    impacts = []
    now = Fraction(0)
    while True:
        crossings = []
        for k in range(count - 1):
            if v[k] > v[k + 1]:
                crossings.append(((a[k + 1] - a[k]) / (v[k] - v[k + 1]), k))
        if not crossings:
            break
        now, k = min(crossings)
        total = masses[k] + masses[k + 1]
        centre = (masses[k] * v[k] + masses[k + 1] * v[k + 1]) / total
        for ball in (k, k + 1):
            here = a[ball] + v[ball] * now
            v[ball] = centre - e * (v[ball] - centre)
            a[ball] = here - v[ball] * now
        impacts.append((now, k))
        lines.append((now, list(a), list(v)))
        assert len(impacts) < 1000

    def state(t):
        _, starts, speeds = [line for line in lines if line[0] <= t][-1]
        places = [x + u * t + w for x, u, w in zip(starts, speeds, widths, strict=True)]
        return places, speeds

    return impacts, state


@pytest.mark.parametrize("seed", range(40))
def test_held_out_lines_agree_with_rational_arithmetic(seed):
    given = random_line(seed)
    impacts, state = by_world_lines(given)
    truth = CASE.at(**given).truth()
    scalars = truth.scalars()
    tiny = Fraction(1, 10**40)
    assert scalars["impacts"].mid == len(impacts)
    assert abs(scalars["last_impact_time"].mid - impacts[-1][0]) <= tiny
    # Between all impacts, and after the last one.
    times = [Fraction(0), *(when for when, _ in impacts), impacts[-1][0] + 1]
    for early, late in pairwise(times):
        t = early + (late - early) * Fraction(2, 5)
        if late == early:
            continue
        places, speeds = state(t)
        told = truth.at(t)
        for k, (place, speed) in enumerate(zip(places, speeds, strict=True), start=1):
            for name, value in ((f"r{k}.x", place), (f"v{k}.x", speed)):
                assert abs(told[name].mid - value) <= told[name].radius <= tiny
    masses = [Fraction(x) for x in given["masses"].split(",")]
    energies = []
    for t in (Fraction(0), times[-1]):
        _, speeds = state(t)
        energies.append(sum(m * v * v / 2 for m, v in zip(masses, speeds, strict=False)))
    assert abs(scalars["energy_lost"].mid - (energies[0] - energies[1])) <= tiny


@pytest.mark.parametrize("balls", range(2, 8))
def test_equal_elastic_balls_pass_the_velocity_on(balls):
    truth = CASE.at(balls=str(balls)).truth()
    scalars = truth.scalars()
    assert scalars["impacts"].mid == balls - 1
    # The gaps are 1/4 m, and one ball at a time has 1 m/s.
    assert scalars["last_impact_time"].mid == Fraction(balls - 1, 4)
    assert scalars["energy_lost"].mid == 0
    told = truth.at(Fraction(balls))
    speeds = [told[f"v{k}.x"].mid for k in range(1, balls + 1)]
    assert speeds == [0] * (balls - 1) + [1]


def test_as_many_equal_balls_leave_as_come():
    """Two come with 1 m/s, one behind the other: two leave with it."""
    told = CASE.at(velocities="1,1,0,0,0,0,0", gaps="1/8,1/4,1/8,1/4,1,1").truth().at(Fraction(9))
    assert [round(told[f"v{k}.x"].mid, 30) for k in range(1, 6)] == [0, 0, 0, 1, 1]


def test_three_balls_of_geometric_masses_give_the_most_to_the_last():
    """Huygens: between masses m1 and m3 the ball sqrt(m1 m3) gives the last one the most speed."""
    fastest = {}
    for middle in ("2", "3/2", "5/2"):
        masses = f"1,{middle},4,1,1,1,1"
        given = {"balls": "3", "masses": masses, "gaps": "1,1/1000,1,1,1,1"}
        told = CASE.at(**given).truth().at(Fraction(11, 10))
        fastest[middle] = told["v3.x"].mid
    assert fastest["2"] == max(fastest.values())
    # 2 m1/(m1 + m2) 2 m2/(m2 + m3) = (2/3)(2/3).
    assert abs(fastest["2"] - Fraction(4, 9)) <= Fraction(1, 10**40)


def test_impacts_of_different_pairs_at_one_time_commute():
    """Balls 1 and 4 come from both sides of two at rest; both outer pairs meet at 1/4 s."""
    truth = CASE.at(balls="4", velocities="1,0,0,-1,0,0,0").truth()
    assert truth.scalars()["impacts"].mid == 5
    told = truth.at(Fraction(2))
    assert [told[f"v{k}.x"].mid for k in range(1, 5)] == [-1, 0, 0, 1]
    gaps = f"1/4,1/4,{Fraction(1, 4) + Fraction(1, 10**20)},1,1,1"
    nearly = CASE.at(balls="4", velocities="1,0,0,-1,0,0,0", gaps=gaps).truth()
    assert truth.sensitivity(Fraction(2)) == pytest.approx(nearly.sensitivity(Fraction(2)))


def test_at_an_impact_velocities_have_no_value():
    truth = CASE.at().truth()
    for k in range(1, 5):
        with pytest.raises(NotCertifiedError, match="jump") as caught:
            truth.at(Fraction(k, 4))
        assert caught.value.code == "jump"


@pytest.mark.parametrize("seed", range(6))
def test_no_start_that_is_displaced_a_little_goes_farther_than_s(seed):
    given = random_line(seed)
    instance = CASE.at(**given)
    truth = instance.truth()
    t = truth.scalars()["last_impact_time"].mid + Fraction(1, 3)
    observed = largest_growth(instance, Fraction(1, 10**15), t)
    s = truth.sensitivity(t)
    assert observed <= s * (1 + 1e-6)
    assert s <= 2 * int(given["balls"]) * observed * len(truth.state)


def test_errors_between_impacts_grow_no_more_than_s():
    """An error made in a flight: the motion goes on from the state there as from a start."""
    given = {"masses": "1,2,1/2,3,1,1,1", "balls": "4", "restitution": "3/4"}
    instance = CASE.at(**given)
    truth = instance.truth()
    end = truth.scalars()["last_impact_time"].mid + 1
    scale = {name: quantity.scale for name, quantity in instance.quantities.items()}
    for begin in (Fraction(1, 3), Fraction(2, 3), Fraction(3, 2)):
        state = truth.at(begin)
        for name in truth.state:
            numbers = {key: ball.mid for key, ball in state.items()}
            plain = _later(given, numbers, end - begin)
            numbers[name] += Fraction(scale[name]) / 10**15
            moved = _later(given, numbers, end - begin)
            away = max(abs(float(moved[n] - plain[n])) / scale[n] for n in plain)
            assert away * 1e15 <= truth.sensitivity(end) * (1 + 1e-6)


def _later(given, numbers, t):
    """The state a time t after one with these places and velocities; equal radii of 1/2."""
    count = int(given["balls"])
    gaps = []
    for k in range(1, count):
        gaps.append(numbers[f"r{k + 1}.x"] - numbers[f"r{k}.x"] - 1)
    lengthened = {**given, "radii": text([Fraction(1, 2)] * SEVEN)}
    lengthened["gaps"] = text([*gaps, *[1] * (SEVEN - count)])
    speeds = [numbers[f"v{k}.x"] for k in range(1, count + 1)]
    lengthened["velocities"] = text([*speeds, *[0] * (SEVEN - count)])
    _, state = by_world_lines(lengthened)
    places, speeds = state(t)
    told = {}
    for k in range(count):
        told[f"r{k + 1}.x"] = places[k] + numbers["r1.x"]
        told[f"v{k + 1}.x"] = speeds[k]
    return told


def test_a_chain_that_touches_is_refused_whatever_the_masses():
    with pytest.raises(UsageError, match="order"):
        CASE.at(balls="3", velocities="1,0,-1,0,0,0,0", masses="1,2,3,1,1,1,1")
