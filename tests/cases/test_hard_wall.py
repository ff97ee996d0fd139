"""Hard sphere on a wall: names, what it refuses, held-out impacts against rational arithmetic."""

import random
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from tests.rationals import RandomFractions, cross, dot, text

CASE = discovery.case("hard-wall")
FRAMES = (
    ((0, 1, 0), (1, 0, 0)),
    ((1, 2, 2), (2, -2, 1)),
    ((2, -3, 6), (3, 6, 2)),
    ((-4, 4, 7), (1, 8, -4)),
    ((1, -4, 8), (8, 4, 1)),
)
"""Normals and tangents: vectors of whole length at right angles, so that all is rational."""


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "mass radius inertia_factor normal position velocity spin restitution"
    more = "tangential_restitution friction"
    assert [p.name for p in CASE.parameters] == [*names.split(), *more.split()]
    expected = [f"{kind}.{axis}" for kind in ("r", "v", "omega") for axis in "xyz"]
    assert list(CASE.at().quantities) == expected


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"normal": "0,0,0"}, "expected a direction"),
        ({"velocity": "1,0,0"}, "does not come nearer"),
        ({"velocity": "1,1,0"}, "does not come nearer"),
        ({"position": "0,1/2,0"}, "touches or overlaps"),
        ({"position": "0,-3,0"}, "touches or overlaps"),
    ],
)
def test_what_is_no_impact_is_refused(given: dict[str, str], word: str) -> None:
    with pytest.raises(UsageError, match=word):
        CASE.at(**given)


def test_the_reference_answers_it() -> None:
    problem = CASE.at().problem
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None] == ["impacts"]


def random_impact(rng: random.Random, gripping: bool) -> dict[str, list[Fraction]]:
    """An impact on a wall of rational unit normal; one that slides has a slip of rational size.

    With its huge friction a gripping impact stops the slip, which may then be any: the sphere
    spins. A sliding one has no spin, so that its slip is the velocity along the tangent.
    """
    fractions = RandomFractions(rng, 4, 9)
    whole_normal, whole_tangent = rng.choice(FRAMES)
    normal = [Fraction(x) for x in whole_normal]
    tangent = [Fraction(x) for x in whole_tangent]
    assert dot(tangent, normal) == 0
    unit = [x / isqrt(int(dot(normal, normal))) for x in normal]
    radius = fractions.between(1, 9)
    gap = fractions.between(1, 9)
    closing_speed = fractions.between(1, 9)
    tangent_factor = fractions.between(4, 9)
    spin = [Fraction(0)] * 3
    friction = Fraction(1, 10**3)
    if gripping:
        spin = fractions.list_of(3, -9, 9)
        friction = Fraction(10**6)
    return {
        "mass": [fractions.between(1, 9)],
        "radius": [radius],
        "inertia_factor": [Fraction(rng.randint(1, 10), 10)],
        "normal": normal,
        "position": combined(radius + gap, unit, Fraction(3), tangent),
        "velocity": combined(-closing_speed, unit, tangent_factor, tangent),
        "spin": spin,
        "restitution": [Fraction(rng.randint(0, 6), 6)],
        "tangential_restitution": [Fraction(rng.randint(0, 3), 3)],
        "friction": [friction],
    }


def combined(
    alpha: Fraction, a: list[Fraction], beta: Fraction, b: list[Fraction]
) -> list[Fraction]:
    """The vector alpha a + beta b."""
    return [alpha * x + beta * y for x, y in zip(a, b, strict=True)]


@dataclass(frozen=True)
class Rebound:
    """The impact by rational arithmetic: its time and place, velocity and spin after it."""

    time: Fraction
    place: list[Fraction]
    velocity: list[Fraction]
    spin: list[Fraction]


def rebound_of(given: dict[str, list[Fraction]], gripping: bool) -> Rebound:
    """The normal velocity turns round and is multiplied by e; v_t and R omega share the impulse,
    whether it stops the slip or is mu p.
    """
    (mass,) = given["mass"]
    (radius,) = given["radius"]
    (factor,) = given["inertia_factor"]
    (e,) = given["restitution"]
    (b,) = given["tangential_restitution"]
    (mu,) = given["friction"]
    one = Fraction(1)
    normal = given["normal"]
    unit = [x / isqrt(int(dot(normal, normal))) for x in normal]
    closing_speed = -dot(given["velocity"], unit)
    time = (dot(given["position"], unit) - radius) / closing_speed
    # Slip s = v + c n + omega x (-R n): the velocity of the point that touches, without its part
    # along the normal.
    arm = [-radius * u for u in unit]
    along_wall = combined(one, given["velocity"], closing_speed, unit)
    slip = combined(one, along_wall, one, cross(given["spin"], arm))
    # Normal impulse p = (1 + e) m c; the tangential one that reverses the part b of the slip is
    # -(1 + b) s/(1/m + R^2/J) with J = f m R^2, and friction cuts it at mu p.
    pressing = (1 + e) * mass * closing_speed
    slip_factor = (1 + b) * mass / (1 + 1 / factor)
    if not gripping:
        squared = dot(slip, slip)
        slip_speed = Fraction(isqrt(squared.numerator), isqrt(squared.denominator))
        assert slip_speed**2 == squared
        assert mu * pressing < slip_factor * slip_speed
        slip_factor = mu * pressing / slip_speed
    impulse = combined(pressing, unit, -slip_factor, slip)
    moment = factor * mass * radius**2
    return Rebound(
        time=time,
        place=combined(one, given["position"], time, given["velocity"]),
        velocity=combined(one, given["velocity"], 1 / mass, impulse),
        spin=combined(one, given["spin"], 1 / moment, cross(arm, impulse)),
    )


@pytest.mark.parametrize("gripping", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_held_out_impacts_agree_with_rational_arithmetic(seed: int, gripping: bool) -> None:
    """Truth contains the rebound by its own rules, and the reference comes to round-off of it."""
    given = random_impact(random.Random(seed), gripping)
    parameters = {name: text(values) for name, values in given.items()}
    instance = CASE.at(**parameters, samples="8")
    rebound = rebound_of(given, gripping)
    last = Fraction(float(instance.times[-1]))
    place = combined(Fraction(1), rebound.place, last - rebound.time, rebound.velocity)
    truth = instance.truth().at(last)
    request = Request(problem=instance.problem, method="impacts", step=None)
    run, _ = ENGINE.run(request)
    observed = instance.observe(run)
    for kind, values in (("r", place), ("v", rebound.velocity), ("omega", rebound.spin)):
        for axis, value in zip("xyz", values, strict=True):
            name = f"{kind}.{axis}"
            ball = truth[name]
            assert abs(ball.mid - value) <= ball.radius <= Fraction(1, 10**40)
            # A few roundings, times the growth of the motion, which is some tens.
            scale = instance.quantities[name].scale
            assert abs(observed[name][-1] - float(value)) < 1e-12 * scale
