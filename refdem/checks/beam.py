"""Separation of two neighbouring paths of a billiard: it grows in proportion to the length of the
path between straight walls, and exponentially where half circles focus the paths (1.6.4, figure
1.33).

Beside a path at r with the unit direction u runs a neighbour r', u'. Its offset across the path and
its angle to the path are, with a x b = a_x b_y - a_y b_x,

    w = u x (r' - r),    phi = u x (u' - u).

After a flight of length l the offset is w + l phi. Every reflection changes both signs, and a wall
with the radius of curvature r, met at the angle chi to its normal, is a mirror of the focal length
r cos(chi)/2:

    w_(n+1) = -(w_n + l phi_n),    phi_(n+1) = -phi_n + 2 (w_n + l phi_n)/(r cos chi)    (to first
    order in w and phi; the second term is 0 on a straight wall).

Between straight walls |phi| is constant, and the offset changes linearly with the length of the
path. Terms beyond first order and roundings are bounded along the true path.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from refdem.checks.bounces import wall
from refdem.checks.lyapunov import APART
from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, judged, no_truth, undecided
from refdem.core.maps import Billiard, RectangleBilliard, StadiumBilliard
from refdem.core.problem import Iteration
from refdem.core.refinement import ROUND_OFF_FACTOR
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant

LARGEST_ERROR = 1e-3
"""Largest bound on the relative error of the separation from which a rate is computed."""
HIGHER_ORDERS = 2.0
"""Factor on the terms of second order that covers those of higher order."""
FEWEST = 2
"""Smallest number of bounces over which a rate is computed."""
BASIS = (
    "the mirror equation along the true path; roundings at each bounce, and terms of second order"
    " in the separation, as they grow until then"
)


@dataclass(frozen=True)
class Beam:
    """The true separation (w [m], phi [rad]) after `bounces`, the bounds (2) of a run's error in
    it [m], [rad], and the true length [m] of the path until then.
    """

    bounces: int
    separation: Array
    bounds: Array
    path: float


class NeighbouringPaths(Check):
    """The rate at which a neighbouring path separates from the true one, with its error."""

    name = "beam"
    title = "Neighbouring paths"
    judges = (Iteration,)
    kills = (
        "a wall that is bent, a half circle of the wrong curvature or in the wrong place, a state"
        " that is rounded, so that neighbouring paths merge"
    )

    def applies(self, subject: Subject) -> str | None:
        """None for billiards in double precision, else the reason why not."""
        problem = subject.instance.problem
        if not (isinstance(problem, Iteration) and isinstance(problem.map, Billiard)):
            return "the case is not a billiard"
        if subject.method.control == "tolerance" or subject.method.precision != "double":
            return (
                "tolerances or single precision perturb neighbouring paths as much as their initial"
                " separation does"
            )
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The finest level, and the same from a perturbed start."""
        return (subject.finest, Variant(subject.levels[-1], "perturbed", APART))

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the rate of separation, per metre of path in a rectangle, per bounce in a
        stadium, over as many bounces as it is known for.
        """
        problem = subject.instance.problem
        assert isinstance(problem, Iteration)
        plain, beside = self.needs(subject)
        if beside not in runs:
            return [undecided(self.name, "rate", "the engine refused the perturbed start")]
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "rate", no_truth(subject))]
        axes = ("x", "y")
        places = np.column_stack([truth.value(f"position.{axis}") for axis in axes])
        directions = np.column_stack([truth.value(f"direction.{axis}") for axis in axes])
        dense = int(np.argmin(np.diff(problem.times, append=np.inf) == 1))
        last = min(len(places) - 1, dense)
        beams = list(followed_beams(problem, subject, places[: last + 1], directions[: last + 1]))
        if not beams or beams[-1].bounces < FEWEST:
            why = "the neighbour's path is known well enough for less than two bounces"
            return [undecided(self.name, "rate", why)]
        beam = beams[-1]
        n = beam.bounces
        measured = _separation(runs[plain].trajectory, runs[beside].trajectory, n)
        start = _start_of(problem)
        if isinstance(problem.map, RectangleBilliard):
            return [self._linear(beam, measured, start)]
        return [self._exponential(beam, measured, start, subject.instance.scales.length)]

    def _linear(self, beam: Beam, measured: Array, start: Array) -> Finding:
        """The finding on the growth of the offset per metre of path between straight walls.

        After n bounces and the path s, (-1)^n w_n = w_0 + s phi_0, so that the rate is

            ((-1)^n w_n - w_0)/s = phi_0.
        """
        turned = (-1.0) ** beam.bounces
        rate = (turned * measured[0] - start[0]) / beam.path
        true = (turned * beam.separation[0] - start[0]) / beam.path
        bound = float(beam.bounds[0] / beam.path)
        return judged(
            check=self.name,
            quantity="rate",
            value=abs(rate - true),
            bound=bound,
            unit="1",
            basis=BASIS,
            what=(
                f"Neighbouring paths separate by {rate:.9g} +- {bound:.1g} m per metre in"
                f" {beam.bounces} flights, certified {true:.9g}; the error"
            ),
        )

    def _exponential(self, beam: Beam, measured: Array, start: Array, length: float) -> Finding:
        """The finding on the growth of the separation, in e-folds per bounce, in a table of the
        length L [m].

        With d = sqrt((w/L)^2 + phi^2) the rate is ln(d_n/d_0)/n. A relative error e < 1 of d_n
        changes it by at most -ln(1 - e)/n.
        """
        scale = np.array([length, 1.0])
        size = np.hypot(*(start / scale))
        true = np.hypot(*(beam.separation / scale))
        with np.errstate(divide="ignore"):
            rate = float(np.log(np.hypot(*(measured / scale)) / size)) / beam.bounces
        true_rate = float(np.log(true / size)) / beam.bounces
        relative = float(np.hypot(*(beam.bounds / scale)) / true)
        bound = -float(np.log1p(-relative)) / beam.bounces
        return judged(
            check=self.name,
            quantity="rate",
            value=abs(rate - true_rate),
            bound=bound,
            unit="1",
            basis=BASIS,
            what=(
                f"Neighbouring paths separate as exp({rate:.9g} n) +- {bound:.1g} until bounce"
                f" n = {beam.bounces}, certified exp({true_rate:.9g} n); the error of the exponent"
            ),
        )


def followed_beams(
    problem: Iteration, subject: Subject, places: Array, directions: Array
) -> Iterator[Beam]:
    """The true beam after each bounce of the true path `places`, `directions` (N + 1, 2), as far as
    its separation is known to LARGEST_ERROR and both paths meet the same piece of the wall.
    """
    table = problem.map
    assert isinstance(table, Billiard)
    length = subject.instance.scales.length
    _, normals = wall(table, places)
    rounding = 2.0 * ROUND_OFF_FACTOR * subject.method.round_off
    curvatures = _curvatures(table, places)
    rooms = _rooms(table, places)
    now = _start_of(problem)
    path = 0.0
    # Error added at each bounce so far (n, 2), and the product of the steps since then (n, 2, 2).
    added = np.empty((0, 2))
    grown = np.empty((0, 2, 2))
    for n in range(1, len(places)):
        flight = float(np.hypot(*(places[n] - places[n - 1])))
        path += flight
        # cos(chi) = n . u, and |w| + l |phi| >= |w + l phi|, the offset at the wall.
        along = float(normals[n] @ directions[n - 1])
        offset = abs(now[0]) + flight * abs(now[1])
        # The neighbour meets the wall within offset/cos(chi) of the true path, with a margin of 2.
        if not along > 0 or rooms[n] <= 2.0 * offset / along:
            return
        # (w, phi)_(n+1) = step (w, phi)_n, with power = 2 kappa/cos(chi) and
        #     step = [-1, -l; power, power l - 1].
        power = 2.0 * curvatures[n] / along
        step = np.array([[-1.0, -flight], [power, power * flight - 1.0]])
        # Second order: the changes of the flight, |dl| <= longer, of the angle, |dchi| <= turned,
        # and of the power, |d(2 kappa/cos chi)| <= power |dchi|/cos chi, which change the step by
        #     [0, dl; dpower, power dl + dpower l].
        longer = (abs(now[0]) + offset) / along
        turned = abs(now[1]) + curvatures[n] * offset / along
        stronger = power * turned / along
        change = np.array([[0.0, longer], [stronger, power * longer + stronger * flight]])
        curved = HIGHER_ORDERS * change @ np.abs(now)
        # Rounding of (w, phi) at a bounce: u (1 + L kappa) (L, 1)/cos(chi).
        rounded = rounding * (1.0 + length * curvatures[n]) * np.array([length, 1.0]) / along
        # bounds = sum over bounces k of |step_n ... step_(k+1)| added_k.
        now = step @ now
        grown = np.concatenate((step @ grown, np.eye(2)[None]))
        added = np.concatenate((added, (curved + rounded)[None]))
        bounds = np.einsum("nij,nj->i", np.abs(grown), added)
        scale = np.array([length, 1.0])
        if np.hypot(*(bounds / scale)) > LARGEST_ERROR * np.hypot(*(now / scale)):
            return
        yield Beam(n, now, bounds, path)


def _start_of(problem: Iteration) -> Array:
    """The offset [m] and the angle [rad] of the perturbed start, beside the plain one."""
    moved = problem.perturbed(APART).start - problem.start
    # w = u x (r' - r),   phi = u x (u' - u).
    direction = problem.start[2:]
    return np.array([_cross(direction, moved[:2]), _cross(direction, moved[2:])])


def _separation(plain: Trajectory, beside: Trajectory, n: int) -> Array:
    """The offset [m] and the angle [rad] of the path beside the plain one, after bounce n."""
    # w = u x (r' - r),   phi = u x (u' - u).
    direction = plain.values["direction"][n]
    moved = beside.values["position"][n] - plain.values["position"][n]
    turned = beside.values["direction"][n] - direction
    return np.array([_cross(direction, moved), _cross(direction, turned)])


def _cross(a: Array, b: Array) -> float:
    """The component a_x b_y - a_y b_x of b across a, times the length of a."""
    return float(a[0] * b[1] - a[1] * b[0])


def _curvatures(table: Billiard, places: Array) -> Array:
    """The curvature (T,) [1/m] of the wall at places (T, 2) on it: 2/height on half circles."""
    if isinstance(table, StadiumBilliard):
        is_arc = np.abs(places[:, 0]) > (table.width - table.height) / 2
        return np.where(is_arc, 2.0 / table.height, 0.0)
    return np.zeros(len(places))


def _rooms(table: Billiard, places: Array) -> Array:
    """Distance (T,) [m] of places (T, 2) on the wall from the end of their straight or circular
    piece of it; infinite on a full circle.
    """
    if isinstance(table, StadiumBilliard):
        half = (table.width - table.height) / 2
        if half == 0:
            return np.full(len(places), np.inf)
        return np.abs(np.abs(places[:, 0]) - half)
    # Of both distances from the walls of a rectangle, that from its own wall is 0.
    gaps: Array = np.array([table.width, table.height]) / 2 - np.abs(places)
    return np.maximum(gaps[:, 0], gaps[:, 1])


CHECK = NeighbouringPaths()
