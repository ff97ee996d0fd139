"""The growth of displacements in the norm in which S(t) is told: motions from displaced starts,
compared at all pairs of times with the motion itself.

What is left of a displacement at s is an impulse made at s. Where the displacements along the
coordinates span the state, D(t) D(s)^-1 is known from them, and with it the impulse that grows most
of all.
"""

import os
import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb_mat

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.truth import Ball, Truth
from refdem.truth import rotation
from refdem.truth.balls import arb_of, ball_of, precision
from refdem.truth.closed_forms.hertz_spheres import HertzSpheres
from refdem.truth.closed_forms.rigid_cluster import RigidCluster
from refdem.truth.collision import Collision
from refdem.truth.validated_flow import ValidatedFlow
from tests.displaced import DROPPED, SIZE, Amounts, displaced_starts, everything
from tests.seen_clusters import SeenCluster
from tests.two_truths import asked_at

MARGIN = 1e-6
"""The part by which a growth may exceed S: what is not linear in the displacement, in matrices
whose condition is at most WORST.
"""
WORST = 1e12
LEFT = 1e-6
"""The part of a displacement that must be left at s for its growth since then to be compared."""
LOOKS = int(os.environ.get("REFDEM_RANDOM_LOOKS", "4"))
"""Times at which motions are compared, after the start: 16 find growths that are nearly the
largest.
"""
MAX_OVERESTIMATE = 1.4
"""A sharp S is at most so many times the largest growth that is found."""
BITS = 400
ASCENTS = 30
"""Rounds of the search for the impulse that grows most in a norm of several parts."""
TURN = ("turn.x", "turn.y", "turn.z")
ATTITUDE = ("attitude.w", "attitude.x", "attitude.y", "attitude.z")
BODIES = ("free-rigid-body", "intermediate-axis", "neglected-gyroscopic", "rigid-cluster")
"""Cases in whose norm the turn and the angular velocity are one part each."""
HIDDEN_STATE = ("contact-path-turned",)
"""Cases, and members, whose quantities do not say their state, or say it along other axes: impulses
are made at the start alone, where they are known.
"""
WITH_SPRINGS = ("impact-benchmarks", "two-spheres")
"""Cases with the stretch of a spring that no quantity says: what is left of a displacement is an
impulse at the start alone, where the spring has no stretch.
"""

Array = np.ndarray
Values = Mapping[str, Fraction]


def part_of(case: str, name: str) -> str:
    """The part of the norm that a coordinate belongs to: its own, if it is not of a body."""
    if case in BODIES:
        return name.split(".")[0]
    return name


def is_along_an_axis(amounts: Amounts) -> bool:
    """True for a displacement of one coordinate alone, False for several at once."""
    return [abs(amount) for amount in amounts if amount != 0] == [1]


def parts(case: str, names: Sequence[str]) -> list[list[int]]:
    """The places of the coordinates of each part of the norm."""
    found: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        found.setdefault(part_of(case, name), []).append(place)
    return list(found.values())


def length(vector: Array, rows: Sequence[Sequence[int]]) -> float:
    """The norm of a vector: the largest Euclidean length of its parts."""
    return max(float(np.linalg.norm(vector[places])) for places in rows)


def largest_growth(
    matrix: Array, rows: Sequence[Sequence[int]], columns: Sequence[Sequence[int]]
) -> float:
    """The largest growth that a matrix is found to give to a vector, in the norm of these parts.

    In components it is the largest sum of absolute values in a row. Else, for one direction u that
    is read, the best vector has its parts along those of matrix^T u; for one vector, the best u is
    along what it becomes. Either step makes the growth larger.
    """
    if all(len(part) == 1 for part in (*rows, *columns)):
        return float(np.abs(matrix).sum(axis=1).max())
    largest = 0.0
    for places in rows:
        read = matrix[places]
        blocks = [read[:, part] for part in columns]
        for u in np.linalg.svd(read)[0].T:
            for _ in range(ASCENTS):
                answers = [unit(block.T @ u) for block in blocks]
                grown = sum(block @ answer for block, answer in zip(blocks, answers, strict=True))
                u = unit(grown)
            largest = max(largest, float(np.linalg.norm(grown)))
    return largest


def unit(vector: Array) -> Array:
    """The vector with the length 1, or 0."""
    size = np.linalg.norm(vector)
    if size == 0:
        return vector
    return vector / size


def balls(matrix: Array) -> arb_mat:
    """A matrix of rationals as balls."""
    return arb_mat([[arb_of(Fraction(x)) for x in row] for row in matrix])


def doubles(matrix: arb_mat) -> Array:
    """The midpoints of a matrix of balls."""
    return np.array([[float(x.mid()) for x in row] for row in matrix.table()])


def turn(attitude: Sequence[Fraction], moved: Sequence[Fraction]) -> list[Fraction]:
    """The small turn [rad] from one attitude to another: twice the vector of their quotient."""
    with precision(BITS):
        one, other = ([arb_of(x) for x in q] for q in (attitude, moved))
        w, *vector = rotation.times(other, rotation.conjugate(one))
        # A quaternion and its negative are one attitude.
        return [ball_of(2 * x * w.sgn()).mid for x in vector]


def times_of(instance: Instance, truth: Truth, rng: random.Random, looks: int) -> list[Fraction]:
    """The start, and so many random times after it."""
    asked = asked_at(instance, truth)
    if instance.problem.kind == "iteration" and not isinstance(truth, ValidatedFlow):
        return [Fraction(n) for n in range(int(asked[-1]) + 1)]
    if asked:
        last = asked[-1]
    else:
        last = Fraction(instance.times[-1])
    return [Fraction(0)] + [
        last * Fraction(1000 * k + rng.randint(1, 999), 1000 * looks) for k in range(looks)
    ]


class Attack:
    """A motion and those from displaced starts, at the start and at times after it.

    `states` and `answers` have, for each time, what displacements of SIZE are by then, a column for
    each start, in scales: in the coordinates of the state, and in all that is read. `counted_as` is
    the instance that has the scales, if another has, `looks` the number of times after the start,
    which are random if no `times` are given.
    """

    def __init__(
        self,
        case: str,
        given: Mapping[str, str],
        rng: random.Random,
        counted_as: Instance | None = None,
        looks: int = LOOKS,
        times: Sequence[Fraction] = (),
    ) -> None:
        self.case = case
        self.member = given.get("member", case)
        self.instance = discovery.case(case).at(**given)
        self.counted_as = counted_as or self.instance
        self.truth: Any = everything(self.instance.truth())
        self.starts, moved = displaced_starts(self.instance, given, self.truth, rng)
        self.seen = self.as_seen(self.truth)
        self.moved = [self.as_seen(one) for one in moved]
        self.times = list(times) or times_of(self.instance, self.truth, rng, looks)
        self.bounds = [self.truth.sensitivity(t) for t in self.times]
        differences = [self.differences(t) for t in self.times]
        self.read = list(differences[0])
        self.answers = [np.array([found[name] for name in self.read]) for found in differences]
        if self.member in HIDDEN_STATE:
            self.state = list(self.truth.state)
            self.states = [np.array(self.starts).T]
            self.made_at = [0]
        else:
            self.state = [name for name in self.read if self.is_of_state(name)]
            places = [self.read.index(name) for name in self.state]
            self.states = [answer[places] for answer in self.answers]
            self.made_at = [k for k, t in enumerate(self.times) if self.is_known_at(t)]
        # Kept, for both bounds are compared with the same growths: inverses by the time of the
        # impulse, growths by the time when they are read.
        self.inverses: dict[int, arb_mat | None] = {}
        self.found: dict[int, list[float]] = {}

    def as_seen(self, truth: Any) -> Any:
        """The motion in the coordinates of the norm: of a cluster, whose truth has places."""
        if isinstance(truth, RigidCluster):
            return SeenCluster(truth, self.truth)
        return truth

    def is_known_at(self, t: Fraction) -> bool:
        """True where the quantities are the whole state: no spring that they do not say is
        stretched.
        """
        if t == 0 or self.case not in WITH_SPRINGS or self.member in DROPPED:
            return True
        if isinstance(self.truth, HertzSpheres):
            return True
        if isinstance(self.truth, Collision) and not self.truth.phases.kt:
            return True
        scalars = self.truth.scalars()
        return "duration" in scalars and t > scalars["duration"].mid

    def is_of_state(self, name: str) -> bool:
        """True for a coordinate of the state, False for what is read of it."""
        if self.case in BODIES:
            return name.split(".")[0] in ("turn", "omega_body")
        if isinstance(self.truth, Collision):
            return name in self.truth.counted()
        names = getattr(self.truth, "state", None)
        return not isinstance(names, tuple) or name in names

    def scale(self, name: str) -> Fraction:
        """The scale in which a coordinate counts."""
        if name.startswith("turn."):
            name = "attitude.w"
        if name in self.counted_as.quantities:
            return Fraction(self.counted_as.quantities[name].scale)
        return Fraction(self.truth.scale[name])

    def differences(self, t: Fraction) -> dict[str, list[Fraction]]:
        """What each displacement is at t, by coordinates, in scales and parts of SIZE."""
        base = self.seen.at(t)
        found: dict[str, list[Fraction]] = {}
        for moved in self.moved:
            changes = self.changes(base, moved.at(t))
            for name, difference in changes.items():
                found.setdefault(name, []).append(difference / self.scale(name) / SIZE)
        return found

    def changes(self, base: Mapping[str, Ball], moved: Mapping[str, Ball]) -> Values:
        """The differences of two states at one time; attitudes differ by a turn."""
        scaled = {*self.instance.quantities, *getattr(self.truth, "scale", ())}
        found = {name: moved[name].mid - base[name].mid for name in base if name in scaled}
        if self.case not in BODIES:
            return found
        attitudes = [[state[name].mid for name in ATTITUDE] for state in (base, moved)]
        turned = dict(zip(TURN, turn(*attitudes), strict=True))
        return turned | {name: found[name] for name in found if name.startswith("omega")}

    def single(self, start: int, end: int) -> Iterator[float]:
        """How much each displacement grows from one time to another, if something is left of it."""
        rows = parts(self.case, self.read)
        columns = parts(self.case, self.state)
        left = self.states[start].astype(float)
        grown = self.answers[end].astype(float)
        for column, made in enumerate(self.states[0].astype(float).T):
            size = length(left[:, column], columns)
            if size > LEFT * length(made, columns):
                yield length(grown[:, column], rows) / size

    def worst(self, start: int, end: int) -> Iterator[float]:
        """The largest growth from one time to another in all directions, where they are known."""
        if start not in self.inverses:
            self.inverses[start] = self.inverse_at(start)
        back = self.inverses[start]
        if back is None:
            return
        with precision(BITS):
            passed = doubles(balls(self.answers[end][:, : len(self.state)]) * back)
        yield largest_growth(passed, parts(self.case, self.read), parts(self.case, self.state))

    def inverse_at(self, start: int) -> arb_mat | None:
        """D(s)^-1 of the displacements along the coordinates at a time s; None where they do not
        span the state, or hardly do.
        """
        count = len(self.state)
        alone = self.states[start][:, :count]
        if sum(is_along_an_axis(amounts) for amounts in self.starts) != count:
            return None
        with precision(BITS):
            try:
                back = balls(alone).inv()
            except ZeroDivisionError:
                return None
            condition = np.abs(doubles(back)).max() * np.abs(alone.astype(float)).max()
        if condition < WORST:
            return back
        return None

    def growths(self, end: int) -> list[float]:
        """Growths up to a time, from all times before it."""
        if end not in self.found:
            self.found[end] = [
                growth
                for start in self.made_at
                if start <= end
                for growth in (*self.single(start, end), *self.worst(start, end))
            ]
        return self.found[end]

    def violations(self, part: float = 1.0) -> list[str]:
        """Growths that exceed S, or that part of it."""
        return self.beyond([part * bound for bound in self.bounds])

    def violations_of(self, truth: Truth, begin: Fraction) -> list[str]:
        """Growths that exceed the S of a truth whose motion is here after the time `begin` [s]."""
        return self.beyond([truth.sensitivity(begin + t) for t in self.times])

    def beyond(self, bounds: Sequence[float]) -> list[str]:
        """Growths that exceed bounds, one for each time."""
        found = []
        for end in range(1, len(self.times)):
            bound = bounds[end]
            growth = max(self.growths(end))
            if growth > bound * (1 + MARGIN):
                found.append(
                    f"{self.instance.label}: at t = {self.times[end]} an impulse has grown by"
                    f" {growth:.9g}, S is {bound:.9g}"
                )
        return found

    def overestimates(self) -> list[str]:
        """Bounds S that are more than MAX_OVERESTIMATE times the largest growth that is found."""
        found = []
        for end in range(1, len(self.times)):
            bound = self.bounds[end]
            growth = max(self.growths(end))
            if bound > MAX_OVERESTIMATE * growth:
                found.append(
                    f"{self.instance.label}: at t = {self.times[end]} S is {bound:.9g}, the largest"
                    f" growth that is found {growth:.9g}"
                )
        return found
