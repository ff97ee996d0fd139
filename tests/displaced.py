"""Truths from displaced starts: each start is moved by a small part of the scales, along every
coordinate that can be moved, and along several at once.
"""

import os
import random
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.truth import Ball
from refdem.truth.balls import arb_of, ball_of, precision
from refdem.truth.closed_forms.phase_flow import PhaseFlow
from refdem.truth.closed_forms.rigid_cluster import RigidCluster
from refdem.truth.collision import Collision
from refdem.truth.from_rest import FromRest
from tests.seen_clusters import displaced_cluster
from tests.touching import touching_starts

DIGITS = 40
SIZE = Fraction(1, 10**19)
"""Of a displacement, in scales: what is not linear in it is about as small a part of the answer."""
BITS = 400
DIRECTIONS = 2
"""Random directions of each start, besides those along its coordinates."""
MOST_COORDINATES = int(os.environ.get("REFDEM_RANDOM_COORDINATES", "20"))
"""The most coordinates that are all displaced; of more, FEW are drawn."""
FEW = 8
BY_PARAMETERS = {
    "billiards": "start direction",
    "free-rigid-body": "omega_body attitude",
    "impact-benchmarks": "speed angle normal_speed psi spin partner_spin",
    "intermediate-axis": "omega_body attitude",
    "logistic": "x0",
    "neglected-gyroscopic": "omega_body attitude",
    "phase-flow": "centre",
    "stick-slip": "x0 v0",
    "two-spheres": "closing_speed angle spins",
}
"""Parameters that are the start of cases whose truths are not displaced themselves."""
DROPPED = ("dem-01", "dem-02")
"""Members of impact-benchmarks that begin with a fall from rest."""
Amounts = Sequence[Fraction]
"""Parts of SIZE by which each coordinate of a start is displaced."""


def everything(truth: Any) -> Any:
    """The same truth to DIGITS digits, with the quantities that it does not report."""
    other = copy(truth.refined(DIGITS))
    if getattr(other, "reported", ()):
        vars(other)["reported"] = ()
    return other


def combinations(rng: random.Random, count: int) -> list[Amounts]:
    """Parts of SIZE by which so many coordinates are displaced: each alone, to a random side, and
    several at once.
    """
    if count > MOST_COORDINATES:
        axes = sorted(rng.sample(range(count), FEW))
    else:
        axes = list(range(count))
    found: list[Amounts] = []
    for axis in axes:
        side = rng.choice((-1, 1))
        found.append([Fraction(side * (axis == other)) for other in range(count)])
    for _ in range(DIRECTIONS):
        amounts = [Fraction(rng.randint(-1000, 1000), 1000) for _ in range(count)]
        found.append([amount * (axis in axes) for axis, amount in enumerate(amounts)])
    return found


def is_displaced_itself(case: str, truth: Any) -> bool:
    """True where the truth itself has displaced starts, False where the parameters are those."""
    if case == "impact-benchmarks":
        return hasattr(truth, "displaced")
    return case not in BY_PARAMETERS


def has_displaced_starts(case: str) -> bool:
    """True where the start of a case can be displaced, in its parameters or by its truth."""
    return case in BY_PARAMETERS or hasattr(discovery.case(case).at().truth(), "displaced")


@dataclass(frozen=True)
class Later:
    """The motion that is `delay` [s] ahead of another: another start of the same motion, if no
    clock drives it.
    """

    truth: Any
    delay: Fraction

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """The values of the other motion `delay` later."""
        return self.truth.at(t + self.delay)


@dataclass(frozen=True)
class Lengthened:
    """A path across a table whose direction is no unit vector: reflections keep its length, and no
    place depends on it.
    """

    truth: Any
    length: Fraction

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """The same places, and directions that are `length` times as long."""
        found = dict(self.truth.at(t))
        for name in ("direction.x", "direction.y"):
            ball = found[name]
            found[name] = Ball(ball.mid * self.length, ball.radius * self.length)
        return found


def lengthened(truth: Any, given: str, moved: str) -> Lengthened:
    """The path whose direction is displaced in its length too, from the texts of both."""
    one, other = (sum(Fraction(part) ** 2 for part in text.split(",")) for text in (given, moved))
    with precision(BITS):
        return Lengthened(truth, ball_of(arb_of(other / one).sqrt()).mid)


def moved_along(truth: Any, amounts: Amounts) -> Any:
    """The truth whose start is displaced by so much along each coordinate.

    A start at rest is displaced in its place, and by its motion during a time that takes as long as
    the scales say: what it moves is a velocity.
    """
    if isinstance(truth, FromRest):
        place, rate = (truth.scale[name] for name in truth.state)
        moved = everything(truth.displaced(0, amounts[0]))
        return Later(moved, abs(amounts[1]) * place / rate**2)
    for axis, amount in enumerate(amounts):
        if amount != 0:
            truth = everything(truth.displaced(axis, amount))
    return truth


def by_coordinates(truth: Any, starts: Sequence[Amounts]) -> list[Any]:
    """Truths from starts that are displaced in the coordinates of the state."""
    sizes = [SIZE * Fraction(truth.scale[name]) for name in truth.state]
    return [
        moved_along(truth, [part * size for part, size in zip(start, sizes, strict=True)])
        for start in starts
    ]


def movable(case: str, given: Mapping[str, str]) -> dict[tuple[str, int], Fraction]:
    """The numbers of the start among the parameters of a case, by the name and the place of each.

    A unit quaternion has three of them.
    """
    found = {}
    for name in BY_PARAMETERS[case].split():
        numbers = [Fraction(text) for text in given.get(name, "").split(",") if text]
        for place, number in enumerate(numbers):
            if name != "attitude" or place > 0:
                found[name, place] = number
    return found


def by_parameters(
    instance: Instance, given: Mapping[str, str], starts: Sequence[Amounts]
) -> list[Any]:
    """Truths from starts that are displaced in the parameters of the case."""
    size = SIZE * Fraction(min(quantity.scale for quantity in instance.quantities.values()))
    start = movable(instance.case.id, given)
    found = []
    for amounts in starts:
        moved = {name: given[name].split(",") for name, _ in start}
        for ((name, place), number), part in zip(start.items(), amounts, strict=True):
            moved[name][place] = str(number + part * size)
        texts = {name: ",".join(numbers) for name, numbers in moved.items()}
        one = everything(instance.case.at(**{**given, **texts}).truth())
        if "direction" in texts:
            one = lengthened(one, given["direction"], texts["direction"])
        found.append(one)
    return found


def along_axes(count: int) -> list[Amounts]:
    """One displacement along each of so many coordinates."""
    return [[Fraction(int(i == j)) for j in range(count)] for i in range(count)]


def dropped_starts(instance: Instance, given: Mapping[str, str], truth: Any) -> list[Any]:
    """What is dropped from rest, from a little higher, and a little later in its fall: what that
    moves is a velocity.
    """
    size = SIZE * Fraction(min(quantity.scale for quantity in instance.quantities.values()))
    higher = {**given, "height": str(Fraction(given["height"]) + size)}
    delay = size / Fraction(given["gravity"])
    return [everything(instance.case.at(**higher).truth()), Later(truth, delay)]


def clusters(truth: RigidCluster, starts: Sequence[Amounts]) -> list[Any]:
    """Truths of clusters that are turned and spin faster at the start, for three numbers each."""
    return [
        everything(displaced_cluster(truth, [SIZE * part for part in start])) for start in starts
    ]


def displaced_corners(instance: Instance, given: Mapping[str, str], truth: PhaseFlow) -> list[Any]:
    """Truths of polygons of which one corner is elsewhere in phase space, in its place or its rate.

    The centre moves all corners; each of them moves on its own.
    """
    found = []
    for moved in by_parameters(instance, given, along_axes(2)):
        for number, motion in enumerate(moved.motions):
            corners = [*truth.corners]
            corners[number] = moved.corners[number]
            motions = [*truth.motions]
            motions[number] = motion
            found.append(replace(truth, corners=tuple(corners), motions=tuple(motions)))
    return found


def displaced_starts(
    instance: Instance, given: Mapping[str, str], truth: Any, rng: random.Random
) -> tuple[list[Amounts], list[Any]]:
    """The displacements of the start of a case at the setting `given`, and a truth for each.

    Of spheres that touch, of what is dropped, and of the corners of a polygon there is one for each
    coordinate and no other.
    """
    case = instance.case.id
    if isinstance(truth, Collision):
        moved = touching_starts(truth, SIZE, everything)
        return along_axes(len(moved)), moved
    if given.get("member") in DROPPED:
        moved = dropped_starts(instance, given, truth)
        return along_axes(len(moved)), moved
    if isinstance(truth, PhaseFlow):
        moved = displaced_corners(instance, given, truth)
        return along_axes(len(moved)), moved
    if isinstance(truth, RigidCluster):
        starts = combinations(rng, 6)
        return starts, clusters(truth, starts)
    if is_displaced_itself(case, truth):
        starts = combinations(rng, len(truth.state))
        return starts, by_coordinates(truth, starts)
    starts = combinations(rng, len(movable(case, given)))
    return starts, by_parameters(instance, given, starts)
