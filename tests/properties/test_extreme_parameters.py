"""Parameters that are each in bounds but together leave binary64 are bad input by name, never a
traceback; scales are plain floats.
"""

import random
from fractions import Fraction

import pytest

from refdem.cases.impact_benchmarks import MEMBERS, member
from refdem.core import discovery
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.errors import RefdemError, UsageError

NAMES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]
SEED = 12
DRAWS = 12
LEFT_ALONE = ("samples", "points", "n", "spheres")
"""Numbers of things: what they ask for costs time, not range."""


@pytest.mark.parametrize(
    "label",
    [
        "van-der-pol v0=1e91",
        "kapitza-pendulum drive_amplitude=1e87 drive=1e72",
        "power-oscillator exponent=8.22948 amplitude=1e-56",
        "van-der-pol x0=1e80 mu=1e80",
        "hertz-spheres stiffness=1e-90 closing_speed=1e90 effective_mass=1e90",
        "impact-benchmarks member=co-4 radius=1e-70",
        "impact-benchmarks member=dem-01 radius=1e30 height=1e31 density=1e30",
    ],
)
def test_what_leaves_binary64_is_refused_by_name(label):
    case, *pairs = label.split()
    with pytest.raises(UsageError, match=case):
        discovery.case(case).at(**dict(pair.split("=") for pair in pairs))


def extreme(rng: random.Random, parameter: Parameter) -> str:
    """A value anywhere within the bounds, of any size."""
    if parameter.choices:
        return rng.choice(parameter.choices)
    if parameter.above is not None:
        low = parameter.above
    else:
        low = parameter.at_least
    count = 1
    for extent in parameter.shape:
        count *= extent

    def one() -> str:
        if parameter.whole:
            return str(int(low or 1))
        size = Fraction(rng.randint(1000, 9999), 1000) * Fraction(10) ** rng.randint(-99, 99)
        if low is not None and parameter.at_most is not None and rng.random() < 0.7:
            size = Fraction(low) + Fraction(rng.randint(1, 999), 1000) * (
                Fraction(parameter.at_most) - Fraction(low)
            )
        is_signed = low is None or low < 0
        return f"{float(-size if is_signed and rng.random() < 0.5 else size):.6g}"

    return ",".join(one() for _ in range(count))


def settings(rng: random.Random, name: str) -> dict[str, str]:
    """Up to four parameters of a case, of any size."""
    declared = {p.name: p for p in discovery.case(name).parameters if p.name not in LEFT_ALONE}
    given = {}
    if name == "impact-benchmarks":
        given["member"] = rng.choice(MEMBERS)
        declared = {own: declared[own] for own in member(given["member"]).numbers}
    chosen = rng.sample(sorted(declared), min(len(declared), rng.randint(1, 4)))
    return given | {own: extreme(rng, declared[own]) for own in chosen}


@pytest.mark.parametrize("name", NAMES)
def test_parameters_of_any_size_make_a_question_or_are_refused(name):
    rng = random.Random(f"{SEED} {name}")
    for _ in range(DRAWS):
        given = settings(rng, name)
        try:
            instance = discovery.case(name).at(**given)
            assert instance.problem is not None
            assert instance.quantities
            assert instance.truth() is not None
        except RefdemError:
            continue


@pytest.mark.parametrize(
    ("name", "given"),
    [(n, {}) for n in NAMES] + [("impact-benchmarks", {"member": m}) for m in MEMBERS],
)
def test_scales_are_plain_floats_that_every_store_can_hold(name, given):
    """A numpy scalar among them was a TypeError in the store of `refdem run impact-benchmarks --set
    member=dem-05-mindlin`.
    """
    instance = discovery.case(name).at(**given)
    scales = instance.scales
    numbers = [
        scales.length,
        scales.tau,
        scales.duration,
        scales.mass,
        *(q.scale for q in instance.quantities.values()),
    ]
    assert {type(number) for number in numbers} == {float}
