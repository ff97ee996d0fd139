"""Certified events of a scene (stick, slip, stop, contact, release) and the rate of their event
functions.

An event is a zero of a function g(t) of the state. An error E of the state, in units of its
scales, moves the zero by about E/|g'|; so the check `event-times` needs |g'| and a bound on |g''|
at each certified time. Both follow from the scene's own force laws:

  slip      g = mu0 N - |P|      P is the pull that friction must balance (class `Belt`)
  stick     g = x' - belt        the velocity relative to the belt, or the slip v + R omega
  release   g = d, or k d + c d' where the contact law ends at zero force (d is the overlap)
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from math import copysign, exp, inf, sin, sqrt

import numpy as np

from refdem.checks._impacts import gap_rates, is_sequence, listed
from refdem.checks._sphere_on_plane import slip_at_start, starts_on_plane
from refdem.core.check import Array, Subject
from refdem.core.truth import SampledTruth
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.elements.wedge import Wedge

DOUBLE_ROUNDING = 2.0**-53
"""Unit round-off of binary64."""
TOUCHING = 8 * DOUBLE_ROUNDING
"""Relative error of positions and radii, 8 roundings in binary64: overlaps below it count as zero.
"""
MOST = 16
"""Largest number of bodies of which every pair is searched. Certified collisions have at most three
bodies.
"""
ALIKE = 1e-9
"""Relative difference of closing speeds below which contacts that start together end together."""

MOST_GROWTH = 100.0
"""Largest exponent of an error's growth, exp(100): nothing is predictable beyond."""


@dataclass(frozen=True)
class Crossing:
    """A certified zero of an event function g(state).

    g is scaled so that |g| changes by at most 1 when every quantity of the state changes by its
    scale.

    - `time` +- `radius` [s] is the certified event time.
    - `rate` [1/s] is |g'| at the event, on the side on which it is smaller.
    - `bend` [1/s^2] bounds |g''|: nothing in the scene changes faster than once per tau.
    - `growth` [1/s] bounds the exponential rate at which state errors grow between two samples.
    - `bodies` are the bodies under one of which the event must be reported; empty if any will do.
    - `margin` is the smallest error of the state, in units of its scales, with which this event
      does not happen: a body that should stick slides on.
    """

    time: float
    radius: float
    rate: float
    bend: float
    growth: float
    bodies: tuple[int, ...] = ()
    margin: float = inf

    def is_of(self, body: int) -> bool:
        """True if the event may be reported of this body."""
        return not self.bodies or body in self.bodies


Crossings = dict[str, list[Crossing]]
"""Crossings by kind of event, in order of time. A kind that is certified to be absent is empty."""
Pair = tuple[float, float, float, tuple[int, ...]]
"""Overlap [m], closing speed [m/s], relative speed [m/s], and the bodies, two or one beside a wall.
"""


def has_crossings(scene: Scene) -> bool:
    """True if truth may certify event times of the scene: of a point on a belt, of shapes in
    contact, of impacts, or of a body that begins to roll.
    """
    if is_belt(scene) or starts_on_plane(scene):
        return True
    return bool(touches(scene)) or is_impact(scene) or is_sequence(scene)


def crossings(subject: Subject, truth: SampledTruth) -> Crossings:
    """The certified crossings by kind; empty where truth has no event times."""
    if is_belt(subject.instance.scene):
        return rubbing(subject, truth)
    if "max_overlap" in truth.scalars:
        return parting(subject, truth)
    if "impact_time" in truth.scalars:
        return meeting(subject, truth)
    if starts_on_plane(subject.instance.scene):
        return sticking(subject, truth)
    return in_sequence(subject, truth)


def error_at(crossing: Crossing, bound: Array, times: Array) -> float:
    """The bound on the error of the state at an event at time t:

        E(t) = bound(next sample) exp(growth (t - last sample)).

    `bound` (until,) holds at the samples `times` only, so the growth since the last sample is
    included.
    """
    following = min(int(np.searchsorted(times, crossing.time)), len(bound) - 1)
    last_sample = float(times[max(0, following - 1)])
    elapsed = max(0.0, crossing.time - last_sample)
    return float(bound[following]) * exp(min(crossing.growth * elapsed, MOST_GROWTH))


def shift(error: float, crossing: Crossing) -> float:
    """The smallest t > 0 [s] with rate t - bend t^2/2 = error; infinity without one.

    It is 2 error/(rate + sqrt(rate^2 - 2 bend error)), the root in a form without cancellation.
    """
    discriminant = crossing.rate * crossing.rate - 2 * crossing.bend * error
    if discriminant > 0:
        return 2 * error / (crossing.rate + sqrt(discriminant))
    return inf


def is_belt(scene: Scene) -> bool:
    """True for one point on a linear spring along x and on a slider along x, driven or not."""
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
    """Forces on a point of mass m on a spring and a belt: m x'' = P - F, with friction F.

    P(t, x) = drive + weight - k (x - x_anchor) is the pull. While the point sticks F = P, which
    needs |P| <= `limit` = mu0 N.
    """

    def __init__(self, scene: Scene) -> None:
        self.spring = scene.all(Spring)[0]
        self.slider = scene.all(Slider)[0]
        self.drives = scene.all(Force)
        self.mass = float(scene.bodies.mass[0])
        self.weight = self.mass * sum(gravity.g[0] for gravity in scene.all(UniformGravity))
        self.limit = float(self.slider.coefficient(0.0)) * self.slider.normal_force

    @property
    def weakening(self) -> float:
        """Largest decrease of the friction force with sliding speed, per mass [1/s].

        Stribeck's law mu(u) = (mu0 - mu1)/(1 + lambda0 |u|) + mu1 + ... falls fastest at u = 0,
        with slope -(mu0 - mu1) lambda0. Errors of a velocity grow at this rate at most.
        """
        slider = self.slider
        if slider.law != "coulomb":
            slope = (slider.mu0 - slider.mu1) * slider.lambda0
        else:
            slope = 0.0
        return max(0.0, slope) * slider.normal_force / self.mass

    def pull(self, t: float, x: float) -> float:
        """The pull P [N] at time t [s] and position x [m]."""
        # P(t, x) = F(t) + m g_x - k (x - x_anchor), F = sum A cos(w t + phase) axis_x
        driven = sum(float(drive.strength(np.array(t))) * drive.axis[0] for drive in self.drives)
        return driven + self.weight - self.spring.stiffness * (x - self.spring.anchor_b[0])

    def margin(self, t: float, x: float) -> float:
        """Error [m] of the place x at time t [s] with which the point no longer sticks, (limit -
        |P|)/k, at least 0.
        """
        return max(0.0, self.limit - abs(self.pull(t, x))) / self.spring.stiffness

    def growth(self, t: float) -> float:
        """The rate dP/dt [N/s] at time t [s] while the belt carries the point, so x' is the belt
        velocity.
        """
        # dP/dt = F'(t) - k v_belt, F' = -sum A w sin(w t + phase) axis_x
        driven = sum(
            -d.amplitude * d.frequency * sin(d.frequency * t + d.phase) * d.axis[0]
            for d in self.drives
        )
        return driven - self.spring.stiffness * self.slider.belt_velocity

    def released_at(self, t: float) -> float:
        """The position [m] at which the point starts to slip at time t: |P(t, x)| = limit with P
        growing.
        """
        # P(t, x) = P(t, 0) - k x = limit sgn(P').
        return (self.pull(t, 0.0) - copysign(self.limit, self.growth(t))) / self.spring.stiffness


def rubbing(subject: Subject, truth: SampledTruth) -> Crossings:
    """Crossings of a point on a belt: its sticks and slips, or its final stop.

    At a slip g = limit - |P|: of the state only x enters, with |g'| = |P'| and scale k L. At a
    stick g is the velocity relative to the belt, with |g'| = |x''| and scale V. A stop is a stick
    that lasts forever, and a run may report it as either kind.
    """
    belt = Belt(subject.instance.scene)
    scales = subject.instance.scales
    # Nothing changes faster than once per tau, so |g''| <= 1/tau^2 in units of the scales.
    bend = scales.tau**-2
    # A friction force that falls with the speed lets errors of the velocity grow.
    growth = 1 / scales.tau + belt.weakening
    # The scalars stick_1, slip_1, cross_1, ... of truth hold (time, radius).
    named = [(name.partition("_")[0], value) for name, value in truth.scalars.items()]
    events = sorted((*value, kind) for kind, value in named if kind in ("stick", "slip", "cross"))
    if events:
        known: Crossings = {"stick": [], "slip": []}
    else:
        known = {}
    for index, (time, radius, kind) in enumerate(events):
        if kind == "slip":
            # rate = |P'|/(k L)
            rate = abs(belt.growth(time)) / (belt.spring.stiffness * scales.length)
            known[kind].append(Crossing(time, radius, rate, bend, growth))
        elif kind == "stick":
            if index + 1 < len(events):
                following = events[index + 1][0]
            else:
                following = inf
            position = carried(belt, truth, time, following)
            if index:
                previous = events[index - 1][0]
            else:
                previous = 0.0
            # rate = |x''|/V
            rate = braking(belt, truth, time, position, previous) / scales.speed
            margin = belt.margin(time, position) / scales.length
            known[kind].append(Crossing(time, radius, rate, bend, growth, margin=margin))
    if "stop_time" in truth.scalars:
        (time, radius) = truth.scalars["stop_time"]
        (position, _) = truth.scalars["stop_position"]
        # The slip before the stop lasts half a period, pi sqrt(m/k).
        half_period = np.pi * sqrt(belt.mass / belt.spring.stiffness)
        rate = braking(belt, truth, time, position, time - half_period) / scales.speed
        # With s = limit/k and positions counted from that where P = 0, a half cycle leads from Y to
        # -sgn(Y) (|Y| - 2 s). From |Y| = s + delta, delta < s, it ends at the distance s - delta:
        # the margin delta at its end is also the amount by which its start exceeds s.
        margin = belt.margin(time, position) / scales.length
        stop = [Crossing(time, radius, rate, bend, growth, margin=margin)]
        known["stop"] = stop
        known["stick"] = stop
    return known


def carried(belt: Belt, truth: SampledTruth, time: float, following: float) -> float:
    """Position [m] at the stick at `time`, found backwards along the belt's uniform motion.

    x(time) = x(until) - belt (until - time). The end is the next slip, at `following` [s], where
    `Belt.released_at` gives x; without one (infinity) it is the last certified sample.
    """
    if following < inf:
        until = following
    else:
        until = truth.t[truth.until - 1]
    if following < inf:
        end = belt.released_at(until)
    else:
        end = truth.value("x")[-1]
    return float(end - belt.slider.belt_velocity * (until - time))


def braking(belt: Belt, truth: SampledTruth, time: float, position: float, since: float) -> float:
    """Deceleration |x''| [m/s^2] relative to the belt just before a stick, at least 0.

    m |x''| = limit - P sgn(u), where u is the slip velocity. Its sign is that of the last certified
    sample between `since`, when this slip began, and `time` [s]; where no sample lies in between,
    the smaller deceleration of both signs is returned.
    """
    pull = belt.pull(time, position)
    certified_times = np.array(truth.t[: truth.until])
    samples = np.flatnonzero((certified_times > since) & (certified_times < time))
    if len(samples):
        slip = truth.value("v")[samples[-1]] - belt.slider.belt_velocity
    else:
        slip = 0.0
    # The component of the pull along the slip, P sgn(u); |P| where the sign is unknown.
    if slip:
        along_slip = copysign(pull, pull * slip)
    else:
        along_slip = abs(pull)
    # m |x''| = limit - P sgn(u)
    net = belt.limit - along_slip
    return max(0.0, float(net)) / belt.mass


def touches(scene: Scene) -> list[tuple[float, float, tuple[int, ...]]]:
    """Pairs in touch and closing at the start, of scenes in which only contacts act.

    Each is (closing speed [m/s], relative speed [m/s], bodies).
    """
    if {element.kind for element in scene.elements} == {"wedge"} and len(scene.bodies) == 1:
        wall = scene.all(Wedge)[0]
        free = scene.bodies
        closing = -float(free.velocity[0] @ np.array(wall.normal))
        pairs: Iterator[Pair] = iter(
            [(float(wall.overlap(free.position)[0]), closing, abs(closing), (0,))]
        )
    elif len(scene.bodies) <= MOST and _is_contact_alone(scene):
        pairs = _met(scene)
    else:
        return []
    return [
        (closing, speed, bodies)
        for overlap, closing, speed, bodies in pairs
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
    """Bound [m] on the rounding error of the overlap of shapes in touch."""
    return TOUCHING * float(max(np.max(scene.bodies.radius), np.max(np.abs(scene.bodies.position))))


def _met(scene: Scene) -> Iterator[Pair]:
    """Every pair of spheres, then every sphere and plane, with overlap and speeds at the start."""
    bodies = scene.bodies
    spheres = [int(i) for i in np.flatnonzero(bodies.radius > 0)]
    for i, j in combinations(spheres, 2):
        # d = R_i + R_j - |r|,  d' = (v_i - v_j).r/|r|,  r = r_j - r_i
        branch: Array = bodies.position[j] - bodies.position[i]
        distance = float(np.linalg.norm(branch))
        relative = bodies.velocity[i] - bodies.velocity[j]
        overlap = float(bodies.radius[i] + bodies.radius[j]) - distance
        closing = float(relative @ branch) / distance
        yield overlap, closing, float(np.linalg.norm(relative)), (i, j)
    for i in spheres:
        for plane in scene.all(Plane):
            normal = np.array(plane.normal)
            # d = R - (r - p).n,  d' = -v.n
            overlap = float(
                bodies.radius[i] - (bodies.position[i] - np.array(plane.point)) @ normal
            )
            yield (
                overlap,
                -float(bodies.velocity[i] @ normal),
                float(np.linalg.norm(bodies.velocity[i])),
                (i,),
            )


def is_impact(scene: Scene) -> bool:
    """Two free spheres under the rigid law, or one and a plane, and nothing else acts."""
    laws = scene.all(Contact)
    planes = len(scene.all(Plane))
    bodies = scene.bodies
    is_alone = len(scene.elements) == 1 + planes and len(bodies) + planes == 2
    is_free = bool((bodies.radius > 0).all()) and not bodies.fixed.any()
    return is_alone and is_free and len(laws) == 1 and laws[0].law == "rigid"


def is_impacts_alone(scene: Scene) -> bool:
    """True if nothing but impacts of spheres acts, with each other and with planes, and gravity if
    all spheres start above the planes.
    """
    kinds: tuple[type, ...] = (Contact, Plane)
    if _is_above_planes(scene):
        kinds = (Contact, Plane, UniformGravity)
    is_alone = all(isinstance(element, kinds) for element in scene.elements)
    return is_alone and bool((scene.bodies.radius > 0).all())


def is_corner_impact(scene: Scene) -> bool:
    """One polyhedron that does not turn comes down on one smooth plane, and nothing else acts."""
    laws = scene.all(Contact)
    bodies = scene.bodies
    if len(bodies) != 1 or len(scene.all(Plane)) != 1 or len(scene.elements) != 2:
        return False
    is_free = not bodies.fixed.any() and not np.any(bodies.omega)
    is_polyhedron = isinstance(bodies.shape[0], Polyhedron)
    return is_free and is_polyhedron and laws[0].law == "rigid" and laws[0].friction == 0


def _is_above_planes(scene: Scene) -> bool:
    """True if no sphere touches a plane at the start (one that rests there carries a load)."""
    bodies = scene.bodies
    for plane in scene.all(Plane):
        height = (bodies.position - np.array(plane.point)) @ np.array(plane.normal)
        if np.any(height <= bodies.radius + rounding(scene)):
            return False
    return True


def closing_speed(scene: Scene) -> tuple[float, float]:
    """The closing speed [m/s] of an impact, by straight lines from the start, and how fast it
    changes before it [m/s^2].

    With d and w the position and velocity of the second sphere relative to the first, and R the sum
    of radii, w.n at |d + w t| = R is -sqrt(w^2 R^2 - |d x w|^2)/R. Before the impact its rate of
    change, the second derivative of |d|, is |d x w|^2/|d|^3 <= |d x w|^2/R^3.
    """
    bodies = scene.bodies
    planes = scene.all(Plane)
    if planes:
        return -float(bodies.velocity[0] @ np.array(planes[0].normal)), 0.0
    reach = float(bodies.radius.sum())
    apart = bodies.position[1] - bodies.position[0]
    relative = bodies.velocity[1] - bodies.velocity[0]
    swept = np.cross(apart, relative)
    # c = sqrt(w^2 - |d x w|^2/R^2),  |c'| <= |d x w|^2/R^3
    squared = float(relative @ relative)
    across = float(swept @ swept) / reach**2
    return sqrt(max(0.0, squared - across)), across / reach


def meeting(subject: Subject, truth: SampledTruth) -> Crossings:
    """The impact of rigid bodies, where their gap closes.

    An error of L in each of the n coordinates of each of N bodies changes the gap by at most N
    sqrt(n) L, which is the scale of the gap.
    """
    scene = subject.instance.scene
    closing, bend = closing_speed(scene)
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    reach = subject.instance.scales.length * len(scene.bodies) * sqrt(dimension)
    time, radius = truth.scalars["impact_time"]
    growth = 1 / subject.instance.scales.tau
    bodies = tuple(range(len(scene.bodies)))
    return {"contact": [Crossing(time, radius, closing / reach, bend / reach, growth, bodies)]}


def sticking(subject: Subject, truth: SampledTruth) -> Crossings:
    """The time at which a body begins to roll: g is the slip v + R omega, which falls uniformly.
    There is no event if the slip is 0 at the start or never falls.

    One scale of v and of omega changes the slip by V + R W.
    """
    if "roll_time" not in truth.scalars:
        return {"stick": []}
    scene = subject.instance.scene
    quantities = subject.instance.quantities
    _, braking = slip_at_start(scene)
    reach = quantities["vx"].scale + float(scene.bodies.radius[0]) * quantities["omega"].scale
    time, radius = truth.scalars["roll_time"]
    # rate = |s'|/(V + R W)
    rate = float(np.linalg.norm(braking)) / reach
    growth = 1 / subject.instance.scales.tau
    return {"stick": [Crossing(time, radius, rate, 0.0, growth)]}


def in_sequence(subject: Subject, truth: SampledTruth) -> Crossings:
    """The impacts of the certified list, each where the gap of its bodies closes; {} without a
    list.
    """
    growth = 1 / subject.instance.scales.tau
    known = []
    for impact in listed(truth.scalars):
        rate, bend = gap_rates(subject.instance, impact)
        known.append(Crossing(impact.time, impact.radius, rate, bend, growth, impact.bodies))
    if known:
        return {"contact": known}
    return {}


def parting(subject: Subject, truth: SampledTruth) -> Crossings:
    """Contact at the start and release after the certified duration, of bodies in touch at the
    start.

    The contact is at the initial time exactly: no error of the state moves it. At the release
    g = d, the overlap, or g = k d + c d' where the contact law ends at zero force. There d'' = 0,
    or d'' < 0 where the normal turns, so that |g'| >= k |d'|. One scale of every quantity changes d
    by at most `reach`, and g by at most k reach (1 + c/(k tau)), so

        rate = |d'|/(reach (1 + c/(k tau))).
    """
    scene = subject.instance.scene
    scales = subject.instance.scales
    scalars = truth.scalars
    pairs = touches(scene)
    closing, speed, _ = pairs[0]
    if any(abs(other - closing) > ALIKE * closing for other, *_ in pairs):
        return {}
    # Pairs with equal closing speeds have one event, which may be reported of any of their bodies.
    bodies = tuple(sorted({body for _, _, pair in pairs for body in pair}))
    # One scale of every coordinate of every free body of a pair changes d by up to free sqrt(n) L.
    n_dimensions = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    if "overlap" in subject.instance.quantities:
        reach = scales.length
    else:
        free = int(np.count_nonzero(~scene.bodies.fixed[list(pairs[0][-1])]))
        reach = scales.length * (free * sqrt(n_dimensions))
    # In the precision of the method the overlap at the start is 0 up to one rounding, which moves
    # the touch by rounding/closing.
    touch_rounding = rounding(scene) * subject.method.round_off / DOUBLE_ROUNDING
    start = float(subject.instance.times[0])
    touch = Crossing(start, touch_rounding / closing, inf, 0.0, 0.0, bodies)
    known: Crossings = {"contact": [touch], "release": []}
    if "duration" not in scalars:
        return known
    laws = scene.all(Contact)
    damping_share = 1.0
    if laws and laws[0].cutoff == "zero_force" and laws[0].law == "linear":
        damping_share = 1.0 + laws[0].damping / (laws[0].stiffness * scales.tau)
    # rate = |d'|/(reach (1 + c/(k tau))),  bend = |v|/(reach (1 + c/(k tau)) tau)
    time, radius = scalars["duration"]
    parting_speed = closing * given_back(subject, truth, closing)
    unit = reach * damping_share
    rate = parting_speed / unit
    bend = speed / (unit * scales.tau)
    known["release"].append(Crossing(time, radius, rate, bend, 1 / scales.tau, bodies))
    return known


def given_back(subject: Subject, truth: SampledTruth, closing: float) -> float:
    """Ratio of the speed at release to that at contact (a lower bound).

    It is the certified restitution e; or sqrt(1 + dE/E) from the certified change of energy; or 1
    where nothing dissipates; else 0.
    """
    if "restitution" in truth.scalars:
        return truth.scalars["restitution"][0]
    if "energy_change" in truth.scalars:
        # sqrt(1 + dE/E),  E = m v^2/2
        energy = float(subject.instance.scene.bodies.mass[0]) * closing**2 / 2
        return sqrt(max(0.0, 1.0 + truth.scalars["energy_change"][0] / energy))
    if any(law.damping for law in subject.instance.scene.all(Contact)):
        return 0.0
    return 1.0
