"""Certified events of a scene, and how fast what vanishes at each of them goes through zero: by the
scene's own laws at certified times.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from math import copysign, inf, sin, sqrt

import numpy as np

from refdem.core.check import Array, Subject
from refdem.core.truth import SampledTruth
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.elements.wedge import Wedge

TOUCHING = 8 * 2.0**-53
"""Part of places and radii by which shapes in touch may be apart: these are rounded."""
MOST = 16
"""Bodies of which every pair is looked at; truth knows collisions of three at most."""
ALIKE = 1e-9
"""Part of a speed by which pairs that touch together may close differently, and still have one time
of parting.
"""


@dataclass(frozen=True)
class Crossing:
    """An event at `time` [s], certified to `radius` [s], where a function g of the state vanishes.

    g is in units of the most that it changes by when every quantity is off by its scale. `rate`
    [1/s] is |dg/dt| at the event, on the side on which it is slower, and `bend` [1/s^2] how fast
    that may change: nothing changes in less than tau, the shortest time.
    `growth` [1/s] bounds how fast errors grow from one sample to the next.
    """

    time: float
    radius: float
    rate: float
    bend: float
    growth: float


Crossings = dict[str, list[Crossing]]
"""All crossings of a kind, in order; of a kind that never happens none."""
Pair = tuple[float, float, float, int]
"""Overlap [m], closing and relative speed [m/s], and number of free bodies."""


def has_crossings(scene: Scene) -> bool:
    """Truth may tell when something sticks, slips, stops, touches or parts."""
    return is_belt(scene) or bool(touches(scene)) or is_impact(scene)


def crossings(subject: Subject, truth: SampledTruth) -> Crossings:
    """What is certified of the events of a scene, by kind; nothing where truth has no times of
    them.
    """
    if is_belt(subject.instance.scene):
        return rubbing(subject, truth)
    if "max_overlap" in truth.scalars:
        return parting(subject, truth)
    if "impact_time" in truth.scalars:
        return meeting(subject, truth)
    return {}


def is_belt(scene: Scene) -> bool:
    """One point on a linear spring along x and on a slider, driven or not."""
    springs = scene.all(Spring)
    sliders = scene.all(Slider)
    if (
        len(scene.bodies) != 1
        or len(springs) != 1
        or len(sliders) != 1
        or sliders[0].axis != (1.0, 0.0, 0.0)
    ):
        return False
    spring = springs[0]
    linear = spring.length == 0 and spring.exponent == 1 and not (spring.quadratic or spring.cubic)
    return linear and all(
        isinstance(element, Spring | Slider | Force | UniformGravity) for element in scene.elements
    )


class Belt:
    """Forces on a point that rubs: its pull P [N] is all but friction, which holds up to `limit`
    [N].
    """

    def __init__(self, scene: Scene) -> None:
        self.spring, self.slider, self.drives = (
            scene.all(Spring)[0],
            scene.all(Slider)[0],
            scene.all(Force),
        )
        self.mass = float(scene.bodies.mass[0])
        self.weight = self.mass * sum(gravity.g[0] for gravity in scene.all(UniformGravity))
        self.limit = float(self.slider.coefficient(0.0)) * self.slider.normal_force

    @property
    def weakening(self) -> float:
        """Largest fall of the friction with the speed, per mass [1/s]: that of Stribeck's law at
        speed 0.
        """
        slider = self.slider
        if slider.law != "coulomb":
            falls = (slider.mu0 - slider.mu1) * slider.lambda0
        else:
            falls = 0.0
        return max(0.0, falls) * slider.normal_force / self.mass

    def pull(self, t: float, x: float) -> float:
        """The force P [N] that friction must balance, at a time and a position."""
        driven = sum(float(drive.strength(np.array(t))) * drive.axis[0] for drive in self.drives)
        return driven + self.weight - self.spring.stiffness * (x - self.spring.anchor_b[0])

    def growth(self, t: float) -> float:
        """dP/dt [N/s] while the belt carries the point."""
        driven = sum(
            -d.amplitude * d.frequency * sin(d.frequency * t + d.phase) * d.axis[0]
            for d in self.drives
        )
        return driven - self.spring.stiffness * self.slider.belt_velocity

    def released_at(self, t: float) -> float:
        """The place [m] at which it is let go at t: where P passes the limit."""
        return (self.pull(t, 0.0) - copysign(self.limit, self.growth(t))) / self.spring.stiffness


def rubbing(subject: Subject, truth: SampledTruth) -> Crossings:
    """Sticks and slips of a point on a belt, or its stop.

    At a slip g = limit - |P|, which only the place can falsify; at a stick g is the velocity
    against the belt. A stop is a stick for ever, and may be called so.
    """
    belt = Belt(subject.instance.scene)
    scales = subject.instance.scales
    bend = scales.tau**-2
    growth = 1 / scales.tau + belt.weakening
    named = [(name.partition("_")[0], value) for name, value in truth.scalars.items()]
    told = sorted((*value, kind) for kind, value in named if kind in ("stick", "slip", "cross"))
    if told:
        found: Crossings = {"stick": [], "slip": []}
    else:
        found = {}
    for number, (time, radius, kind) in enumerate(told):
        if kind == "slip":
            found[kind].append(
                Crossing(
                    time,
                    radius,
                    abs(belt.growth(time)) / (belt.spring.stiffness * scales.length),
                    bend,
                    growth,
                )
            )
        elif kind == "stick":
            if number + 1 < len(told):
                following = told[number + 1][0]
            else:
                following = inf
            place = carried(belt, truth, time, following)
            if number:
                since = told[number - 1][0]
            else:
                since = 0.0
            found[kind].append(
                Crossing(
                    time,
                    radius,
                    braking(belt, truth, time, place, since) / scales.speed,
                    bend,
                    growth,
                )
            )
    if "stop_time" in truth.scalars:
        (time, radius) = truth.scalars["stop_time"]
        (place, _) = truth.scalars["stop_position"]
        half = np.pi * sqrt(belt.mass / belt.spring.stiffness)
        found["stop"] = found["stick"] = [
            Crossing(
                time,
                radius,
                braking(belt, truth, time, place, time - half) / scales.speed,
                bend,
                growth,
            )
        ]
    return found


def carried(belt: Belt, truth: SampledTruth, time: float, following: float) -> float:
    """Where [m] the belt takes the point up: from where it lets it go again, or else from the last
    certified sample.
    """
    if following < inf:
        until = following
    else:
        until = truth.t[truth.until - 1]
    if following < inf:
        place = belt.released_at(until)
    else:
        place = truth.value("x")[-1]
    return float(place - belt.slider.belt_velocity * (until - time))


def braking(belt: Belt, truth: SampledTruth, time: float, place: float, since: float) -> float:
    """Size of the acceleration [m/s^2] with which the slip ends at a time and place; `since` [s] it
    has kept its direction.

    The direction is that of a certified sample; where none lies in between, the smaller of both is
    taken.
    """
    pull = belt.pull(time, place)
    sampled = np.flatnonzero(
        (np.array(truth.t[: truth.until]) > since) & (np.array(truth.t[: truth.until]) < time)
    )
    if len(sampled):
        slip = truth.value("v")[sampled[-1]] - belt.slider.belt_velocity
    else:
        slip = 0.0
    if slip:
        driving = copysign(pull, pull * slip)
    else:
        driving = abs(pull)
    against = belt.limit - driving
    return max(0.0, float(against)) / belt.mass


def touches(scene: Scene) -> list[tuple[float, float, int]]:
    """Closing and relative speed [m/s] and number of free bodies of each pair in touch at the
    start, where only contacts act.
    """
    if {element.kind for element in scene.elements} == {"wedge"} and len(scene.bodies) == 1:
        wall = scene.all(Wedge)[0]
        free = scene.bodies
        closing = -float(free.velocity[0] @ np.array(wall.normal))
        pairs: Iterator[Pair] = iter(
            [(float(wall.overlap(free.position)[0]), closing, abs(closing), 1)]
        )
    elif len(scene.bodies) <= MOST and _is_contact_alone(scene):
        pairs = _met(scene)
    else:
        return []
    return [
        (closing, speed, free)
        for overlap, closing, speed, free in pairs
        if abs(overlap) <= rounding(scene) and closing > 0
    ]


def _is_contact_alone(scene: Scene) -> bool:
    """True if the scene has one contact law with an overlap, and planes."""
    laws = scene.all(Contact)
    return (
        len(laws) == 1
        and laws[0].law != "rigid"
        and all(isinstance(element, Contact | Plane) for element in scene.elements)
    )


def rounding(scene: Scene) -> float:
    """The error [m] by which the overlap of shapes in touch may be rounded."""
    return TOUCHING * float(max(np.max(scene.bodies.radius), np.max(np.abs(scene.bodies.position))))


def _met(scene: Scene) -> Iterator[Pair]:
    """Every pair of spheres, and every sphere and plane."""
    bodies = scene.bodies
    spheres = [int(i) for i in np.flatnonzero(bodies.radius > 0)]
    for i, j in combinations(spheres, 2):
        apart: Array = bodies.position[j] - bodies.position[i]
        distance = float(np.linalg.norm(apart))
        relative = bodies.velocity[i] - bodies.velocity[j]
        free = int(2 - bodies.fixed[[i, j]].sum())
        overlap = float(bodies.radius[i] + bodies.radius[j]) - distance
        closing = float(relative @ apart) / distance
        yield overlap, closing, float(np.linalg.norm(relative)), free
    for i in spheres:
        for plane in scene.all(Plane):
            normal = np.array(plane.normal)
            overlap = float(
                bodies.radius[i] - (bodies.position[i] - np.array(plane.point)) @ normal
            )
            yield (
                overlap,
                -float(bodies.velocity[i] @ normal),
                float(np.linalg.norm(bodies.velocity[i])),
                1,
            )


def is_impact(scene: Scene) -> bool:
    """Two free spheres under the rigid law, or one and a plane, and nothing else acts."""
    laws = scene.all(Contact)
    planes = len(scene.all(Plane))
    bodies = scene.bodies
    is_alone = len(scene.elements) == 1 + planes and len(bodies) + planes == 2
    is_free = bool((bodies.radius > 0).all()) and not bodies.fixed.any()
    return is_alone and is_free and len(laws) == 1 and laws[0].law == "rigid"


def closing_speed(scene: Scene) -> tuple[float, float]:
    """The closing speed [m/s] of an impact, by straight lines from the start, and how fast it
    changes before it [m/s^2].

    With d and w the place and velocity of the second sphere against the first, and R the sum of
    radii, w.n at |d + w t| = R is -sqrt(w^2 R^2 - |d x w|^2)/R.
    """
    bodies = scene.bodies
    planes = scene.all(Plane)
    if planes:
        return -float(bodies.velocity[0] @ np.array(planes[0].normal)), 0.0
    reach = float(bodies.radius.sum())
    apart = bodies.position[1] - bodies.position[0]
    relative = bodies.velocity[1] - bodies.velocity[0]
    swept = np.cross(apart, relative)
    squared = float(relative @ relative)
    across = float(swept @ swept) / reach**2
    return sqrt(max(0.0, squared - across)), across / reach


def meeting(subject: Subject, truth: SampledTruth) -> Crossings:
    """The impact of rigid bodies, where their gap closes.

    The gap is off by at most the sum of what the places of both are off by along the normal.
    """
    scene = subject.instance.scene
    closing, bend = closing_speed(scene)
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    reach = subject.instance.scales.length * len(scene.bodies) * sqrt(dimension)
    time, radius = truth.scalars["impact_time"]
    growth = 1 / subject.instance.scales.tau
    return {"contact": [Crossing(time, radius, closing / reach, bend / reach, growth)]}


def parting(subject: Subject, truth: SampledTruth) -> Crossings:
    """The touch at the start, which no error moves, and the parting after the certified duration,
    if there is one.

    g is the overlap d, or the force k d + c d' where the contact ends with that: there d'' is 0, or
    below it where the normal turns, so that |g'| >= k |d'|.
    """
    scene = subject.instance.scene
    scales = subject.instance.scales
    scalars = truth.scalars
    met = touches(scene)
    closing, speed, free = met[0]
    if any(abs(other - closing) > ALIKE * closing for other, *_ in met):
        return {}
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    if "overlap" in subject.instance.quantities:
        reach = scales.length
    else:
        reach = scales.length * (free * sqrt(dimension))
    touch = Crossing(float(subject.instance.times[0]), rounding(scene) / closing, inf, 0.0, 0.0)
    found: Crossings = {"contact": [touch], "release": []}
    if "duration" not in scalars:
        return found
    laws = scene.all(Contact)
    softened = 1.0
    if laws and laws[0].cutoff == "zero_force" and laws[0].law == "linear":
        softened = 1.0 + laws[0].damping / (laws[0].stiffness * scales.tau)
    time, radius = scalars["duration"]
    parting_speed = closing * given_back(subject, truth, closing)
    unit = reach * softened
    found["release"].append(
        Crossing(time, radius, parting_speed / unit, speed / (unit * scales.tau), 1 / scales.tau)
    )
    return found


def given_back(subject: Subject, truth: SampledTruth, closing: float) -> float:
    """Speed at parting over that at touch: certified, or from the certified change of energy, or 1
    where nothing brakes.
    """
    if "restitution" in truth.scalars:
        return truth.scalars["restitution"][0]
    if "energy_change" in truth.scalars:
        energy = float(subject.instance.scene.bodies.mass[0]) * closing**2 / 2
        return sqrt(max(0.0, 1.0 + truth.scalars["energy_change"][0] / energy))
    if any(law.damping for law in subject.instance.scene.all(Contact)):
        return 0.0
    return 1.0
