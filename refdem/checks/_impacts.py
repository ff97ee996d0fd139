"""Impacts in sequence: the certified list of them in the scalars of the truth, and the samples of a
run between which each comes alone.

Truth has of impact number k, from 1 on, the time `impact_k` [s], the closing speed
`impact_k_closing` [m/s], and the numbers of the bodies, `impact_k_body` and, unless it is a plane,
`impact_k_other` (refdem/truth/impact_scalars.py).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.check import Subject
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
Scalars = Mapping[str, tuple[float, float]]
MOST_BODIES = 16
"""Bodies up to which impacts may be listed: those of a game of billiards. Lists of more are lost
after a few of them, as errors grow from impact to impact.
"""
SAMPLES_A_WAIT = 4
"""Samples in the shortest time between two impacts of a body: one before and one after each are
free of both, however they lie.
"""
MOST_DENSE = 64
"""Samples in place of one, at most: a run must be read."""


@dataclass(frozen=True)
class Impact:
    """A certified impact at `time` +- `radius` [s] of bodies that close with `closing` [m/s]: two,
    or one that meets a plane.
    """

    time: float
    radius: float
    closing: float
    bodies: tuple[int, ...]


def listed(scalars: Scalars) -> list[Impact]:
    """The certified impacts in order of time; none where truth tells of no list."""
    found: list[Impact] = []
    for number in count(1):
        name = f"impact_{number}"
        if name not in scalars:
            return found
        time, radius = scalars[name]
        closing, of_closing = scalars[f"{name}_closing"]
        roles = [f"{name}_{role}" for role in ("body", "other")]
        bodies = tuple(int(scalars[role][0]) for role in roles if role in scalars)
        # The slowest that they may close: rates are bounded from below.
        found.append(Impact(time, radius, closing - of_closing, bodies))
    return found


def is_sequence(scene: Scene) -> bool:
    """A few free spheres under the rigid law, on which nothing but planes and uniform gravity
    acts.
    """
    laws = scene.all(Contact)
    if len(scene.bodies) > MOST_BODIES:
        return False
    if len(laws) != 1 or laws[0].law != "rigid" or scene.bodies.fixed.any():
        return False
    known = all(isinstance(part, Contact | Plane | UniformGravity) for part in scene.elements)
    return known and all(isinstance(shape, Sphere) for shape in scene.bodies.shape)


def falling(scene: Scene) -> Array:
    """The uniform gravity (3,) [m/s^2] of a scene."""
    total: Array = np.zeros(3)
    for field in scene.all(UniformGravity):
        total = total + np.array(field.g)
    return total


def gap_rates(instance: Instance, impact: Impact) -> tuple[float, float]:
    """|g'| [1/s] and a bound on |g''| [1/s^2] of the gap at an impact. The unit of the gap is its
    change when every coordinate changes by its scale.

    For a sphere above a plane |g''| is the acceleration of gravity. Two spheres fall alike: with
    their relative speed w <= 2 V, the closing speed c and the sum R of their radii g'' = (w^2 -
    c^2)/R, which is 0 for a motion on a line.
    """
    scene = instance.scene
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    # The unit of the gap: each body moves by L along each axis.
    reach = instance.scales.length * len(impact.bodies) * sqrt(dimension)
    if len(impact.bodies) == 1:
        bend = float(np.linalg.norm(falling(scene)))
    elif dimension == 1:
        bend = 0.0
    else:
        radii = float(scene.bodies.radius[list(impact.bodies)].sum())
        bend = (2 * instance.scales.speed) ** 2 / radii
    return impact.closing / reach, bend / reach


def growth_across(instance: Instance, impacts: Sequence[Impact]) -> Array:
    """Growth (T,) of an early error of spheres that leads out of the line or the plane of their
    motion, in which truth and its sensitivity S stay; 1 without impacts.

    Spheres that are off by y_1 and y_2 across that plane meet with a normal that leads out of it:

        n = n_0 + (y_2 - y_1)/(R_1 + R_2) e,    dv_k = -+ (1 + e) w m_1 m_2/(m_1 + m_2)/m_k n,

    where w is the speed at which they close. So each impact enlarges the error by the length of the
    flight after it over R_1 + R_2.
    """
    bodies = instance.scene.bodies
    scales = instance.scales
    (law,) = instance.scene.all(Contact)
    # Columns: an error of each place, in units of L, and of each velocity, in units of L/tau.
    place = np.hstack([np.eye(len(bodies)), np.zeros((len(bodies), len(bodies)))])
    velocity = np.roll(place, len(bodies), axis=1)
    now = instance.times[0] / scales.tau
    growth = np.ones(len(instance.times))
    pairs = [impact for impact in impacts if len(impact.bodies) == 2]
    ends = [impact.time for impact in pairs[1:]] + [inf]
    for impact, end in zip(pairs, ends, strict=False):
        place = place + (impact.time / scales.tau - now) * velocity
        now = impact.time / scales.tau
        first, second = impact.bodies
        mass = bodies.mass[[first, second]]
        reach = (bodies.radius[first] + bodies.radius[second]) / scales.length
        slope = (place[second] - place[first]) / reach
        impulse = (1 + law.restitution) * impact.closing / scales.speed * mass.prod() / mass.sum()
        velocity = velocity.copy()
        velocity[first] -= impulse / mass[0] * slope
        velocity[second] += impulse / mass[1] * slope
        after = (instance.times >= impact.time) & (instance.times < end)
        since = instance.times[after] / scales.tau - now
        growth[after] = [_largest(place + t * velocity, velocity) for t in since]
    so_far: Array = np.maximum.accumulate(growth)
    return so_far


def _largest(place: Array, velocity: Array) -> float:
    """The largest error of any place or velocity (N, 2 N) that errors of 1 at the start make."""
    return float(np.abs(np.vstack([place, velocity])).sum(axis=1).max())


@dataclass(frozen=True)
class Window:
    """An impact and two samples, `first` and `last` by number, between which it comes and no other
    one of its bodies does. In the run it comes at another time by `late_by` [s] at most.
    """

    impact: Impact
    first: int
    last: int
    late_by: float


def shortest_wait(impacts: Sequence[Impact]) -> float:
    """The shortest time between two impacts of one body [s]; infinite if none has two."""
    last: dict[int, float] = {}
    waits = [inf]
    for impact in impacts:
        for body in impact.bodies:
            if body in last:
                waits.append(impact.time - last[body])
            last[body] = impact.time
    return min(waits)


def dense_variant(subject: Subject) -> Variant:
    """The finest level with 2^k samples in place of one, so many that every impact comes alone
    between two of them, as far as steps allow.
    """
    plain = subject.finest
    if subject.truth is None:
        return plain
    interval = float(subject.instance.problem.interval)
    end = float(subject.instance.times[-1])
    wait = shortest_wait([impact for impact in listed(subject.truth.scalars) if impact.time <= end])
    dense = 1
    while dense < MOST_DENSE and SAMPLES_A_WAIT * interval > dense * wait:
        if subject.method.control == "step" and interval < 2 * dense * plain.level:
            break
        dense *= 2
    if dense == 1:
        return plain
    return Variant(plain.level, "denser_output", dense)


def windows(truth: SampledTruth, run: Trajectory, late_by: Sequence[float]) -> list[Window]:
    """The impacts of the list that come alone between two samples of the run, in their order, up to
    the last certified one.

    `late_by` [s] is by how much each impact may come earlier or later in the run. Impacts beyond
    the end of `late_by` are only known to come after those before them.
    """
    impacts = listed(truth.scalars)
    known = impacts[: len(late_by)]
    times = run.t
    last = truth.t[truth.until - 1]
    if len(impacts) > len(known):
        last = min(last, impacts[len(known)].time)
    found = []
    for number, impact in enumerate(known):
        begin = float(times[0])
        end = last
        for other, neighbour in enumerate(known):
            if not set(neighbour.bodies) & set(impact.bodies):
                continue
            if other < number:
                begin = max(begin, neighbour.time + late_by[other])
            if other > number:
                end = min(end, neighbour.time - late_by[other])
        late = late_by[number]
        before = np.flatnonzero((times >= begin) & (times < impact.time - late))
        after = np.flatnonzero((times > impact.time + late) & (times <= end))
        if len(before) and len(after):
            found.append(Window(impact, int(before[-1]), int(after[0]), late))
    return found
