"""Hard sphere on a wall: names, what it refuses, held-out impacts against rational arithmetic."""

import random
from fractions import Fraction
from math import isqrt

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError

CASE = discovery.case("hard-wall")
NORMALS = ((0, 1, 0), (1, 2, 2), (2, -3, 6), (-4, 4, 7), (1, -4, 8))
"""Vectors of whole length, so that all is rational."""


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


def cross(a, b):
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    return [x, y, z]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def drawn(rng: random.Random, gripping: bool) -> dict[str, list[Fraction]]:
    """An impact on a wall of rational unit normal; one that slides has a slip of rational size."""

    def part(low, high):
        return Fraction(rng.randint(low, high), rng.randint(4, 9))

    normal = [Fraction(x) for x in rng.choice(NORMALS)]
    unit = [x / isqrt(int(dot(normal, normal))) for x in normal]
    radius = part(1, 9)
    gap = part(1, 9)
    closing = part(1, 9)
    tangents = {
        (0, 1, 0): (1, 0, 0),
        (1, 2, 2): (2, -2, 1),
        (2, -3, 6): (3, 6, 2),
        (-4, 4, 7): (1, 8, -4),
        (1, -4, 8): (8, 4, 1),
    }
    tangent = [Fraction(x) for x in tangents[tuple(int(x) for x in normal)]]
    assert dot(tangent, normal) == 0
    speed = part(4, 9)
    spin = [Fraction(0)] * 3
    if gripping:
        spin = [part(-9, 9) for _ in range(3)]
    friction = Fraction(1, 10**3)
    if gripping:
        friction = Fraction(10**6)
    return {
        "mass": [part(1, 9)],
        "radius": [radius],
        "inertia_factor": [Fraction(rng.randint(1, 10), 10)],
        "normal": normal,
        "position": [(radius + gap) * u + 3 * t for u, t in zip(unit, tangent, strict=True)],
        "velocity": [-closing * u + speed * t for u, t in zip(unit, tangent, strict=True)],
        "spin": spin,
        "restitution": [Fraction(rng.randint(0, 6), 6)],
        "tangential_restitution": [Fraction(rng.randint(0, 3), 3)],
        "friction": [friction],
    }


@pytest.mark.parametrize("gripping", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_held_out_impacts_agree_with_rational_arithmetic(seed: int, gripping: bool) -> None:
    """Truth contains, and the reference comes to round-off of, the rebound by its own rules: v_n
    turns round, v_t and R omega share the impulse, whether it stops the slip or is mu p.
    """
    given = drawn(random.Random(seed), gripping)
    told = {name: ",".join(map(str, values)) for name, values in given.items()}
    instance = CASE.at(**told, samples="8")
    mass, radius, factor = (given[name][0] for name in ("mass", "radius", "inertia_factor"))
    normal = given["normal"]
    unit = [x / isqrt(int(dot(normal, normal))) for x in normal]
    closing = -dot(given["velocity"], unit)
    when = (dot(given["position"], unit) - radius) / closing
    e, b, mu = (given[n][0] for n in ("restitution", "tangential_restitution", "friction"))
    point = [-radius * u for u in unit]
    swept = cross(given["spin"], point)
    slip = [v + closing * u + w for v, u, w in zip(given["velocity"], unit, swept, strict=True)]
    pressing = (1 + e) * mass * closing
    factor_of_slip = (1 + b) * mass / (1 + 1 / factor)
    if not gripping:
        squared = dot(slip, slip)
        size = Fraction(isqrt(squared.numerator), isqrt(squared.denominator))
        assert size**2 == squared
        assert mu * pressing < factor_of_slip * size
        factor_of_slip = mu * pressing / size
    impulse = [pressing * u - factor_of_slip * s for u, s in zip(unit, slip, strict=True)]
    velocity = [v + p / mass for v, p in zip(given["velocity"], impulse, strict=True)]
    turned = cross(point, impulse)
    spin = [w + t / (factor * mass * radius**2) for w, t in zip(given["spin"], turned, strict=True)]
    met = [r + v * when for r, v in zip(given["position"], given["velocity"], strict=True)]
    last = Fraction(float(instance.times[-1]))
    place = [r + v * (last - when) for r, v in zip(met, velocity, strict=True)]
    truth = instance.truth().at(last)
    request = Request(problem=instance.problem, method="impacts", step=None)
    run, _ = ENGINE.run(request)
    seen = instance.observe(run)
    for kind, values in (("r", place), ("v", velocity), ("omega", spin)):
        for axis, value in zip("xyz", values, strict=True):
            ball = truth[f"{kind}.{axis}"]
            assert abs(ball.mid - value) <= ball.radius <= Fraction(1, 10**40)
            # A few roundings, times the growth of the motion, which is some tens.
            scale = instance.quantities[f"{kind}.{axis}"].scale
            assert abs(seen[f"{kind}.{axis}"][-1] - float(value)) < 1e-12 * scale
