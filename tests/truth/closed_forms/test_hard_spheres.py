"""Rigid spheres: held-out impacts against rational arithmetic that shares nothing with the truth,
limits that are decided exactly, and how errors grow.
"""

import random
from fractions import Fraction
from math import isqrt

import pytest

from refdem.core import discovery
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.impact_sequence import ImpactSequence
from refdem.truth.surds import Surd, surd
from tests.rationals import RandomFractions, cross, dot, text
from tests.truth.displaced_starts import growth, largest_growth

CASE = discovery.case("hard-spheres")
KINDS = ("r", "v", "omega")
AXES = "xyz"
TRIPLES = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (20, 21, 29), (7, 24, 25))


def random_impact(seed: int) -> dict[str, str]:
    """An impact whose normal is rational: the offset is the sine of a Pythagorean angle, or, turned
    out of its plane by another, two coordinates of a rational point of the sphere.
    """
    rng = random.Random(seed)
    fractions = RandomFractions(rng)
    opposite, _, hypotenuse = rng.choice(TRIPLES)
    y, z, unit = rng.choice(TRIPLES)
    sine = Fraction(opposite, hypotenuse) * rng.choice([-1, 0, 1])
    offset = [sine * Fraction(y, unit), sine * Fraction(z, unit)]
    return {
        "masses": text(fractions.list_of(2, 1, 30)),
        "radii": text(fractions.list_of(2, 1, 9)),
        "inertia_factors": text(Fraction(rng.randint(1, 10), 10) for _ in range(2)),
        "closing_speed": str(fractions.between(1, 40)),
        "distance": str(1 + fractions.between(1, 9)),
        "offset": text(offset),
        "spins": text(fractions.list_of(6, -20, 20)),
        "restitution": str(Fraction(rng.randint(0, 8), 8)),
        "tangential_restitution": str(Fraction(rng.randint(0, 4), 4)),
        "friction": rng.choice(["0", "1000", "1e6"]),
    }


def by_rationals(given: dict[str, str]) -> tuple[Fraction, list[dict[str, list[Fraction]]]]:
    """Time of impact and, for each sphere, its place there, its velocity and spin after it; of
    impacts without friction, or with so much that the slip is stopped or reversed.

    The impulse is found component by component in a frame of the normal and two tangents: each
    changes its own component of the velocity of contact, and no other.
    """
    numbers = {name: [Fraction(x) for x in value.split(",")] for name, value in given.items()}
    masses, radii = numbers["masses"], numbers["radii"]
    moments = [
        f * m * r * r for f, m, r in zip(numbers["inertia_factors"], masses, radii, strict=True)
    ]
    reach = sum(radii)
    y, z = numbers["offset"]
    square = 1 - y * y - z * z
    cosine = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    assert cosine**2 == square
    speed = numbers["closing_speed"][0]
    when = reach * (numbers["distance"][0] - cosine) / speed
    normal = [cosine, y, z]
    total = sum(masses)
    bodies = []
    for k in (0, 1):
        share = (-1) ** (k + 1) * masses[1 - k] / total
        bodies.append(
            {
                "r": [share * reach * x for x in normal],
                "v": [-share * speed, Fraction(0), Fraction(0)],
                "omega": numbers["spins"][3 * k : 3 * k + 3],
            }
        )
    levers = [[radii[0] * x for x in normal], [-radii[1] * x for x in normal]]
    points = [
        [v + w for v, w in zip(body["v"], cross(body["omega"], lever), strict=True)]
        for body, lever in zip(bodies, levers, strict=True)
    ]
    meeting = [a - b for a, b in zip(*points, strict=True)]
    closing = dot(meeting, normal)
    ease = 1 / masses[0] + 1 / masses[1]
    impulse = [-(1 + numbers["restitution"][0]) * closing / ease * n for n in normal]
    if given["friction"] != "0":
        across = ease + sum(r * r / j for r, j in zip(radii, moments, strict=True))
        factor = (1 + numbers["tangential_restitution"][0]) / across
        impulse = [
            p - factor * (g - closing * n) for p, g, n in zip(impulse, meeting, normal, strict=True)
        ]
    for k, side in ((0, 1), (1, -1)):
        pushed = [side * p for p in impulse]
        turned = cross(levers[k], pushed)
        body = bodies[k]
        body["v"] = [v + p / masses[k] for v, p in zip(body["v"], pushed, strict=True)]
        body["omega"] = [w + t / moments[k] for w, t in zip(body["omega"], turned, strict=True)]
    return when, bodies


@pytest.mark.parametrize("seed", range(24))
def test_held_out_impacts_agree_with_rational_arithmetic(seed):
    given = random_impact(seed)
    truth = CASE.at(**given).truth()
    when, bodies = by_rationals(given)
    limited = given["friction"] == "1000" and truth.side_of_limit > 0
    assert not limited, "the draw grips less than it should"
    since = Fraction(7, 3)
    told = truth.at(when + since)
    for number, body in enumerate(bodies, start=1):
        expected = dict(body)
        expected["r"] = [r + v * since for r, v in zip(body["r"], body["v"], strict=True)]
        for kind in KINDS:
            for axis, value in zip(AXES, expected[kind], strict=True):
                ball = told[f"{kind}{number}.{axis}"]
                assert abs(ball.mid - value) <= ball.radius <= Fraction(1, 10**40)
    assert abs(truth.scalars()["impact_time"].mid - when) <= Fraction(1, 10**40)


def state(truth: Truth, t: Fraction):
    told = truth.at(t)
    return [[[told[f"{kind}{k}.{axis}"].mid for axis in AXES] for kind in KINDS] for k in (1, 2)]


@pytest.mark.parametrize("friction", ["0", "1/8", "100"])
def test_momentum_and_total_angular_momentum_stay_and_energy_falls_by_what_is_lost(friction):
    masses = [Fraction(2), Fraction(3)]
    radii = [Fraction(1, 2), Fraction(3, 4)]
    instance = CASE.at(
        masses="2,3", radii="1/2,3/4", spins="1,-2,3,4,1/2,-1", friction=friction, offset="1/2,1/3"
    )
    truth = instance.truth()
    moments = [Fraction(2, 5) * m * r * r for m, r in zip(masses, radii, strict=True)]
    sums = []
    for t in (Fraction(0), 3 * truth.scalars()["impact_time"].mid):
        bodies = state(truth, t)
        momentum = [sum(m * b[1][i] for m, b in zip(masses, bodies, strict=True)) for i in range(3)]
        angular = [Fraction(0)] * 3
        energy = Fraction(0)
        for mass, moment, (r, v, omega) in zip(masses, moments, bodies, strict=True):
            for i, orbital in enumerate(cross(r, v)):
                angular[i] += mass * orbital + moment * omega[i]
            energy += (mass * dot(v, v) + moment * dot(omega, omega)) / 2
        sums.append([*momentum, *angular, energy])
    before, after = sums
    before[-1] -= truth.scalars()["energy_lost"].mid
    assert all(abs(a - b) < Fraction(1, 10**38) for a, b in zip(before, after, strict=True))


@pytest.mark.parametrize(("more", "side"), [("0", 0), ("1/10**30", 1), ("-1/10**30", -1)])
def test_slip_that_just_stops_is_decided_exactly(more, side):
    """Equal solid spheres without spin at sin = 3/5, e = 3/4: |s| = 3/5, c = 4/5, m_t/m_n = 2/7, so
    that k |s| = mu p at mu = (2/7)(3/5)/((7/4)(4/5)) = 6/49.
    """
    excess = {"0": Fraction(0), "1/10**30": Fraction(1, 10**30)}.get(more, -Fraction(1, 10**30))
    friction = Fraction(6, 49) - excess
    truth = CASE.at(friction=str(friction)).truth()
    assert isinstance(truth, ImpactSequence)
    assert truth.side_of_limit == side
    assert truth.sensitivity(Fraction(3)) >= 1


def test_at_the_limit_s_is_that_of_the_worse_side():
    at, above, below = (
        CASE.at(friction=str(Fraction(6, 49) + Fraction(k, 10**9))).truth().sensitivity(Fraction(3))
        for k in (0, 1, -1)
    )
    assert at == pytest.approx(max(above, below), rel=1e-6)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"offset": "3/5,4/5"}, "only graze"),
        ({"offset": "1,1/10"}, "pass each other"),
        ({"distance": "4/5"}, "touch or overlap"),
        ({"distance": "1/2"}, "touch or overlap"),
        ({"inertia_factors": "0,1"}, "inertia_factors"),
        ({"restitution": "9/8"}, "restitution"),
        ({"tangential_restitution": "-1/8"}, "tangential_restitution"),
    ],
)
def test_what_is_no_impact_is_refused(given, words):
    with pytest.raises(UsageError, match=words):
        CASE.at(**given)


def test_at_the_impact_itself_velocities_have_no_value():
    truth = CASE.at().truth()
    with pytest.raises(NotCertifiedError, match="jump") as caught:
        truth.at(Fraction(6, 5))
    assert caught.value.code == "jump"
    assert truth.at(Fraction(6, 5) + Fraction(1, 10**6))["v1.x"].mid != Fraction(1, 2)


@pytest.mark.parametrize("samples", [2, 3, 16, 17, 64, 65])
def test_the_impact_lies_a_third_of_an_interval_after_a_sample(samples):
    # In the middle it would lie on the step grid of every even stride, and the order seen would
    # alternate from stride to stride.
    instance = CASE.at(samples=str(samples), offset="1/3,1/5")
    when = float(instance.truth().scalars()["impact_time"].mid)
    times = instance.times
    interval = times[1] - times[0]
    past = when - times[times < when].max()
    assert 0.33 < past / interval < 0.34


@pytest.mark.parametrize("axis", range(18))
@pytest.mark.parametrize("friction", ["0", "1/8", "100"])
def test_no_start_that_is_displaced_a_little_goes_farther_than_s(axis, friction):
    given = {"friction": friction, "spins": "1,2,3,-1,1/2,4", "offset": "1/2,1/3"}
    instance = CASE.at(**given)
    t = Fraction(3)
    observed = growth(instance, axis, Fraction(1, 10**12), t)
    assert observed <= instance.truth().sensitivity(t) * (1 + 1e-6)


def test_s_is_reached_within_a_small_factor():
    given = {"friction": "1/8", "spins": "1,2,3,-1,1/2,4", "offset": "1/2,1/3"}
    instance = CASE.at(**given)
    t = Fraction(3)
    observed = largest_growth(instance, Fraction(1, 10**12), t)
    assert instance.truth().sensitivity(t) <= 18 * observed


def test_order_in_a_field_of_one_root_is_exact():
    """41/29 is the best fraction of its size for sqrt(2), and is below it; its neighbour above."""
    two = Fraction(2)
    assert surd(Fraction(-41, 29), Fraction(1), two).sign() == 1
    assert surd(Fraction(-99, 70), Fraction(1), two).sign() == -1
    below = Surd(Fraction(-665857, 470832), Fraction(1), two)
    assert below.sign() == -1
    assert (below * below).sign() == 1
    assert (below - below).sign() == 0
    assert surd(Fraction(-3), Fraction(2), Fraction(9, 4)).sign() == 0
    assert (1 - surd(Fraction(0), Fraction(1), two)).sign() == -1
