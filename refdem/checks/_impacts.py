"""Impacts in sequence: the certified list of them in the scalars of the truth, and for each impact
the two samples of a run between which its bodies have no other impact.

For impact number k = 1, 2, ... the truth gives the time `impact_k` [s], the closing speed
`impact_k_closing` [m/s], and the numbers of the bodies, `impact_k_body` and, unless the body meets
a plane, `impact_k_other` (refdem/truth/impact_scalars.py).
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
"""Largest number of bodies with a list of impacts: that of a game of billiards. With more bodies
only the first few impacts can be certified, since errors grow from impact to impact.
"""
SAMPLES_A_WAIT = 4
"""Samples in the shortest time between two impacts of a body: whatever their phase, there is a
sample before and one after each impact that no other impact of the body separates from it.
"""
MOST_DENSE = 64
"""Largest number of samples in place of one, which limits the size of the output."""


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
    """The certified impacts in order of time; empty where truth has no list."""
    found: list[Impact] = []
    for number in count(1):
        name = f"impact_{number}"
        if name not in scalars:
            return found
        time, radius = scalars[name]
        closing, of_closing = scalars[f"{name}_closing"]
        roles = [f"{name}_{role}" for role in ("body", "other")]
        bodies = tuple(int(scalars[role][0]) for role in roles if role in scalars)
        # The lower end of the certified interval, since event rates are bounded from below.
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

    For a sphere above a plane |g''| = |a.n| <= |a|, with the acceleration of gravity a. Gravity
    cancels between two spheres: with their relative speed w <= 2 V, the closing speed c and the sum
    R of their radii, g'' = (w^2 - c^2)/R <= (2 V)^2/R, which is 0 for a motion on a line.
    """
    scene = instance.scene
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    # The unit of the gap: each of N bodies moves by L along each of n axes, N sqrt(n) L in all.
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

        n = n_0 + (y_2 - y_1)/(R_1 + R_2) z,    dv_k = -+ (1 + e) w m_1 m_2/(m_1 + m_2)/m_k n,

    where z is the unit vector across the plane, e the restitution and w the closing speed. So each
    impact enlarges the error by the length of the flight after it over R_1 + R_2.
    """
    bodies = instance.scene.bodies
    scales = instance.scales
    (law,) = instance.scene.all(Contact)
    # Row i is the error y_i of body i (below, of its velocity y_i'), in units of L and L/tau. The
    # columns are the initial errors of 1 in each y_j and in each y_j' from which it follows.
    place = np.hstack([np.eye(len(bodies)), np.zeros((len(bodies), len(bodies)))])
    velocity = np.roll(place, len(bodies), axis=1)
    now = instance.times[0] / scales.tau
    growth = np.ones(len(instance.times))
    pairs = [impact for impact in impacts if len(impact.bodies) == 2]
    ends = [impact.time for impact in pairs[1:]] + [inf]
    for impact, end in zip(pairs, ends, strict=False):
        # Free flight: y(t) = y + y' t
        place = place + (impact.time / scales.tau - now) * velocity
        now = impact.time / scales.tau
        first, second = impact.bodies
        mass = bodies.mass[[first, second]]
        reach = (bodies.radius[first] + bodies.radius[second]) / scales.length
        # y_k' -+= (1 + e) w m_1 m_2/(m_1 + m_2)/m_k (y_2 - y_1)/(R_1 + R_2)
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
    """The largest error of any position or velocity (N, 2 N) that initial errors of 1 cause: the
    infinity norm, max_i sum_j |A_ij|, of both matrices together.
    """
    return float(np.abs(np.vstack([place, velocity])).sum(axis=1).max())


@dataclass(frozen=True)
class Window:
    """An impact and the numbers `first` and `last` of two samples between which it is the only
    impact of its bodies. Its time in the run differs from the certified one by at most `late_by`
    [s].
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
    """The finest level with 2^k samples in place of one, so many that two samples isolate each
    impact, as far as the step of the method allows.
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
    """The impacts of the list that two samples of the run isolate from all other impacts of the
    same bodies, in order of time, up to the last certified sample.

    `late_by` [s] bounds the difference between the time of each impact in the run and in the list.
    Of impacts beyond the end of `late_by` only their order is known.
    """
    impacts = listed(truth.scalars)
    known = impacts[: len(late_by)]
    times = run.t
    last = truth.t[truth.until - 1]
    if len(impacts) > len(known):
        last = min(last, impacts[len(known)].time)
    found = []
    for number, impact in enumerate(known):
        # begin = max over earlier impacts j of the same bodies of t_j + late_j;
        # end = min over later ones of t_j - late_j.
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
        # begin <= t < t_i - late_i and t_i + late_i < t <= end.
        before = np.flatnonzero((times >= begin) & (times < impact.time - late))
        after = np.flatnonzero((times > impact.time + late) & (times <= end))
        if len(before) and len(after):
            found.append(Window(impact, int(before[-1]), int(after[0]), late))
    return found
