"""A truth does not depend on the axes: turned by right angles, mirrored, or with two bodies in
exchange, a motion has the same values in other places or with other signs, and an S that is the
same.

REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets, REFDEM_RANDOM_SEED which
ones.
"""

import random
import re
from collections.abc import Callable
from fractions import Fraction

import pytest

from refdem.core import discovery
from tests.random_settings import SETTINGS, first_accepted, settings, written
from tests.rationals import text
from tests.signed_turns import ALL, INVERSION, SignedTurn
from tests.two_truths import Answer, TwoTruths

KEEP_X = [turn for turn in ALL if turn.axes[0] == 0 and turn.signs[0] == 1]
KEEP_PLANE = [turn for turn in KEEP_X if turn.axes == (0, 1, 2)]
OF_A_BODY = {"inertia": "sizes", "omega_body": "axial", "attitude": "quaternion"}
TURNS = {
    "hard-wall": (
        ALL,
        {"normal": "polar", "position": "polar", "velocity": "polar", "spin": "axial"},
    ),
    "rigid-cluster": (ALL, {"positions": "polar", "omega": "axial"}),
    "free-rigid-body": (ALL, OF_A_BODY),
    "dissipating-body": (ALL, OF_A_BODY),
    "hard-spheres": (KEEP_X, {"offset": "across", "spins": "axial"}),
    "two-spheres": (KEEP_PLANE, {"angle": "towards y", "spins": "axial"}),
}
"""Turns and mirrors that a case allows, and how its parameters take part."""
KIND = {
    "r": "polar",
    "v": "polar",
    "omega": "axial",
    "omega_body": "axial",
    "attitude": "axial",
    "R": "axial",
}
"""How a quantity takes part; the vector part of a quaternion is that of an axis."""
COMPONENT = re.compile(r"([A-Za-z_]+)(\d*)\.([xyz]+)")
ODD = {
    "harmonic-oscillator": ("gravity x0 v0", "x v"),
    "viscous-oscillator": ("gravity x0 v0", "x v"),
    "driven-oscillator": ("gravity f0 x0 v0", "x v"),
    "coulomb-oscillator": ("x0 v0", "x v stop_position"),
    "power-oscillator": ("amplitude", "x v"),
    "duffing": ("amplitude", "x v"),
    "driven-duffing": ("f0 x0 v0", "x v"),
    "quadratic-response": ("eps f0 x0 v0", "x v"),
    "van-der-pol": ("p x0 v0", "x v"),
    "pendulum": ("theta0 thetadot0", "theta thetadot x"),
    "double-pendulum": ("theta0 thetadot0", "theta1 theta2 thetadot1 thetadot2"),
    "kapitza-pendulum": ("theta0 thetadot0", "theta thetadot"),
    "pendulum-equilibria": ("delta", "x vx"),
    "heavy-top": ("phidot0 spin", "phi psi"),
    "bouncing-ball": ("velocity/x spin", "x vx omega"),
    "billiards": ("start/x direction/x", "position.x direction.x"),
}
"""Mirrors of a line or a plane: parameters and values that change their sign. That of stick-slip is
none: the steady pull on its anchor has one sign whichever way the belt runs.
"""
SWAPPED = {
    "hard-spheres": "masses radii inertia_factors spins",
    "two-spheres": "masses radii spins",
}
"""Pairs of bodies: what each of them has."""


def text_of_turned(turn: SignedTurn, kind: str, words: str) -> str:
    """The numbers of a parameter after a turn."""
    numbers = [Fraction(number) for number in words.split(",")]
    if kind == "across":
        return text(turn.turned([Fraction(0), *numbers], "polar")[1:])
    if kind == "towards y":
        return text(turn.signs[1] * number for number in numbers)
    if kind == "quaternion":
        return text([numbers[0], *turn.turned(numbers[1:], "axial")])
    turned = []
    for start in range(0, len(numbers), 3):
        turned += turn.turned(numbers[start : start + 3], kind)
    return text(turned)


def turned_answer(turn: SignedTurn, name: str) -> Answer | None:
    """Where a quantity goes; which axis a body ends about has its own test."""
    if name == "final_axis":
        return None
    match = COMPONENT.fullmatch(name)
    if match is None:
        return name, Fraction(1)
    component, sign = turn.component(match[3], KIND[match[1]])
    return f"{match[1]}{match[2]}.{component}", Fraction(sign)


def turned(rng: random.Random, case: str, given: dict[str, str]) -> TwoTruths:
    """A setting, and the same after a turn or in a mirror."""
    turns, kinds = TURNS[case]
    turn = rng.choice(turns)
    other = dict(given)
    for name, kind in kinds.items():
        other[name] = text_of_turned(turn, kind, given[name])
    return TwoTruths(
        discovery.case(case).at(**given),
        discovery.case(case).at(**other),
        lambda name: turned_answer(turn, name),
    )


def negated(words: str, entry: str) -> str:
    """The numbers with other signs; only the first of them where the `entry` is x."""
    numbers = [Fraction(number) for number in words.split(",")]
    if entry:
        return text([-numbers[0], *numbers[1:]])
    return text(-number for number in numbers)


def mirrored(rng: random.Random, case: str, given: dict[str, str]) -> TwoTruths:
    """A setting, and the same with its line or plane mirrored."""
    parameters, values = (words.split() for words in ODD[case])
    other = dict(given)
    for parameter in parameters:
        name, _, entry = parameter.partition("/")
        other[name] = negated(given[name], entry)
    return TwoTruths(
        discovery.case(case).at(**given),
        discovery.case(case).at(**other),
        lambda name: (name, Fraction(-1 if name in values else 1)),
    )


def swapped_answer(name: str) -> Answer:
    """The same of the other body: a point mirror brings both back to their sides."""
    match = COMPONENT.fullmatch(name)
    if match is None:
        return name, Fraction(1)
    component, sign = INVERSION.component(match[3], KIND[match[1]])
    other = {"1": "2", "2": "1"}[match[2]]
    return f"{match[1]}{other}.{component}", Fraction(sign)


def swapped(rng: random.Random, case: str, given: dict[str, str]) -> TwoTruths:
    """A setting, and the same with the two bodies in exchange."""
    other = dict(given)
    for name in SWAPPED[case].split():
        numbers = given[name].split(",")
        half = len(numbers) // 2
        other[name] = text(numbers[half:] + numbers[:half])
    return TwoTruths(
        discovery.case(case).at(**given), discovery.case(case).at(**other), swapped_answer
    )


Image = Callable[[random.Random, str, dict[str, str]], TwoTruths]


def random_pair(image: Image, case: str, number: int) -> TwoTruths:
    """A case at a random setting, and its image."""
    return first_accepted(
        case, number, lambda rng: image(rng, case, written(case, settings(rng, case)))
    )


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize(
    ("image", "case"),
    [(turned, case) for case in TURNS]
    + [(mirrored, case) for case in ODD]
    + [(swapped, case) for case in SWAPPED],
)
def test_truth_is_the_same_after_a_turn_or_in_a_mirror(image, case, number):
    pair = random_pair(image, case, number)
    pair.compare()
    assert pair.compared
    assert pair.differences == []


def test_a_turn_of_a_spin_by_the_wrong_sign_is_found():
    """The test of the test: a spin mirrored as if it were a velocity."""
    given = written("hard-wall", {"spin": "1,2,3", "friction": "1"})
    other = given | {"velocity": "-3/4,-1,0", "spin": "-1,2,3"}
    pair = TwoTruths(
        discovery.case("hard-wall").at(**given),
        discovery.case("hard-wall").at(**other),
        lambda name: turned_answer(SignedTurn((0, 1, 2), (-1, 1, 1)), name),
    )
    pair.compare()
    assert pair.differences
