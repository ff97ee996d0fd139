"""Velocity Verlet with forward differentiation by dual numbers, through smooth motion and impacts.

Notation: a dual number x has the value x and the derivatives `slopes` x_k = dx/ds_k by the
parameters s_k of the scene that a request names. Sums, products and roots follow the chain rule.

An impact is a zero of the gap g(s) = c + b s + a s^2 within a step. The dual root has the
derivative ds = -dg/g' of the impact time. The step up to the impact and the rest of the step
therefore have dual lengths, which yields the saltation of the tangent: after an impact of
restitution e on a plane of normal n,

    dr+ = dr- - (1 + e) n (n . dr-) + ...
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.faults.parts import Parts, TangentParts
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import ZERO, Number, Quaternion, Vector
from refdem.scene import Point, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

MOST_IMPACTS = 64
"""Largest number of impacts in one step; with more the rest of the step is made without them."""
POSITION = slice(0, 3)
VELOCITY = slice(3, 6)
ATTITUDE = slice(6, 10)
OMEGA = slice(10, 13)
"""Where the 13 state variables of a body stand in their row."""
STILL_SMALL = 1e-8
"""Square of half an angle below which two terms of the series of sin(x)/x are exact in binary64."""


@dataclass(frozen=True, slots=True)
class Dual:
    """A dual number: a value, and its derivatives `slopes` (K,) by K parameters of the scene."""

    value: float
    slopes: Array

    def __neg__(self) -> "Dual":
        return Dual(-self.value, -self.slopes)

    def __add__(self, other: Number) -> "Dual":
        return Dual(self.value + value_of(other), self.slopes + slopes_of(other))

    __radd__ = __add__

    def __sub__(self, other: Number) -> "Dual":
        return Dual(self.value - value_of(other), self.slopes - slopes_of(other))

    def __rsub__(self, other: float) -> "Dual":
        return Dual(other - self.value, -self.slopes)

    def __mul__(self, other: Number) -> "Dual":
        value = value_of(other)
        # (a b)' = b a' + a b'.
        return Dual(self.value * value, value * self.slopes + self.value * slopes_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> "Dual":
        value = value_of(other)
        quotient = self.value / value
        # (a/b)' = (a' - (a/b) b')/b.
        return Dual(quotient, (self.slopes - quotient * slopes_of(other)) / value)

    def __rtruediv__(self, other: float) -> "Dual":
        quotient = other / self.value
        # (c/b)' = -(c/b) b'/b.
        return Dual(quotient, -quotient * self.slopes / self.value)


def value_of(number: Number) -> float:
    """The value of a number, dual or not."""
    if isinstance(number, Dual):
        return number.value
    return float(number)


def slopes_of(number: Number) -> Any:
    """The derivatives (K,) of a number; 0 for one that is not dual."""
    if isinstance(number, Dual):
        return number.slopes
    return 0.0


def root(square: Number) -> Dual:
    """The square root of a dual number above 0: (sqrt x)' = x'/(2 sqrt x)."""
    value = math.sqrt(square.value)
    return Dual(value, square.slopes / (2 * value))


def turn_by(angles: Vector) -> Quaternion:
    """The quaternion of the rotation by |angles| [rad] about `angles`, in dual numbers, also at 0.

    With x = |angles|^2/4 it is (cos sqrt(x), S(x) angles/2), S(x) = sin(sqrt x)/sqrt(x). Their
    derivatives by x are -S/2 and S' = (cos sqrt(x) - S)/(2 x).
    """
    square = vec.dot(angles, angles) / 4.0
    half = math.sqrt(square.value)
    cosine = math.cos(half)
    if square.value < STILL_SMALL:
        # S = 1 - x/6 + ..., S' = -1/6 + x/60 - ...
        sinc = 1.0 - square.value / 6.0
        sinc_rate = -1.0 / 6.0 + square.value / 60.0
    else:
        sinc = math.sin(half) / half
        sinc_rate = (cosine - sinc) / (2 * square.value)
    w = Dual(cosine, -sinc / 2 * square.slopes)
    factor = Dual(sinc, sinc_rate * square.slopes) / 2.0
    return w, factor * angles[0], factor * angles[1], factor * angles[2]


def refused(scene: Scene) -> str | None:
    """None for what the method differentiates, else the reason: points and spheres with equal
    moments of inertia on linear springs and in gravity, and one sphere that collides with planes
    under the rigid law without friction.
    """
    known = (Spring, UniformGravity, Plane, Contact)
    for element in scene.elements:
        if not isinstance(element, known):
            return f"the method does not differentiate a {element.kind}"
    for spring in scene.all(Spring):
        if spring.features() != {"spring"} or not spring.has_central_anchors():
            return "the method differentiates linear springs between centres only"
    return _bodies_refused(scene) or _contact_refused(scene)


def _bodies_refused(scene: Scene) -> str | None:
    """None for free points and spheres whose moments of inertia are equal, else the reason."""
    bodies = scene.bodies
    if bodies.fixed.any():
        return "the method moves every body"
    if not all(isinstance(shape, Point | Sphere) for shape in bodies.shapes):
        return "the method differentiates points and spheres only"
    if np.any(bodies.inertia != bodies.inertia[:, :1]):
        return "the method differentiates bodies with equal moments only"
    return None


def _contact_refused(scene: Scene) -> str | None:
    """None without contacts, or for one sphere that collides with planes without friction."""
    laws = scene.all(Contact)
    if not laws:
        return None
    if laws[0].law != "rigid" or laws[0].friction != 0:
        return "the method differentiates impacts without friction only"
    if len(scene.bodies) > 1:
        return "the method differentiates impacts of one sphere only"
    return None


def seeded(key: str, value: Any, asked: Sequence[str]) -> Any:
    """A value of the document of a scene with every float as a dual number. Its derivative by a
    requested parameter is 1 if the parameter has its key, else 0.
    """
    if isinstance(value, dict):
        return {name: seeded(f"{key}.{name}", entry, asked) for name, entry in value.items()}
    if isinstance(value, list):
        return [seeded(f"{key}.{place}", entry, asked) for place, entry in enumerate(value)]
    if isinstance(value, float):
        return Dual(value, np.array([float(key == name) for name in asked]))
    return value


@dataclass(frozen=True)
class TangentWorld:
    """The constants of a scene as dual numbers; `springs`, `fields` and `planes` are the elements
    as documents.
    """

    mass: list[Dual]
    radius: list[Any]
    springs: list[Any]
    fields: list[Any]
    planes: list[Any]
    restitution: Any


@dataclass(frozen=True)
class TangentState:
    """Positions `r` and velocities `v` of all bodies as dual numbers."""

    r: list[Vector]
    v: list[Vector]


def world_of(document: Any) -> TangentWorld:
    """The world of the document of a scene, with dual numbers as made by `seeded`."""
    bodies = document["bodies"]
    by_kind: dict[str, list[Any]] = {}
    for element in document["elements"]:
        by_kind.setdefault(element["kind"], []).append(element)
    laws = by_kind.get("contact", [{}])
    return TangentWorld(
        mass=[body["mass"] for body in bodies],
        radius=[body["shape"].get("radius", 0.0) for body in bodies],
        springs=by_kind.get("spring", []),
        fields=by_kind.get("uniform_gravity", []),
        planes=by_kind.get("plane", []) if "contact" in by_kind else [],
        restitution=laws[0].get("restitution", 0.0),
    )


def forces(world: TangentWorld, r: list[Vector]) -> list[Vector]:
    """The force (3) [N] on every body: gravity m g, and springs -k (|d| - l) d/|d|."""
    total = [ZERO for _ in r]
    for field in world.fields:
        for i, mass in enumerate(world.mass):
            total[i] = vec.moved(total[i], mass, tuple(field["g"]))
    for spring in world.springs:
        a = spring["a"]
        b = spring["b"]
        if b >= 0:
            other = r[b]
        else:
            other = tuple(spring["anchor_b"])
        # F = -k d with d = r_a - r_b for a natural length of 0, else -k (|d| - l) d/|d|.
        apart = vec.minus(r[a], other)
        factor = -spring["stiffness"]
        if spring["length"].value or np.any(spring["length"].slopes):
            distance = root(vec.dot(apart, apart))
            factor = factor * (distance - spring["length"]) / distance
        total[a] = vec.moved(total[a], factor, apart)
        if b >= 0:
            total[b] = vec.moved(total[b], -factor, apart)
    return total


def verlet(world: TangentWorld, state: TangentState, h: Number) -> TangentState:
    """Kick, drift, kick (Swope et al. 1982) over a step of dual length."""
    # v' = v + h/2 F(r)/m, r+ = r + h v', v+ = v' + h/2 F(r+)/m.
    before = forces(world, state.r)
    r = []
    halfway = []
    for place, velocity, force, mass in zip(state.r, state.v, before, world.mass, strict=True):
        kicked = vec.moved(velocity, h / mass * 0.5, force)
        halfway.append(kicked)
        r.append(vec.moved(place, h, kicked))
    v = []
    for velocity, force, mass in zip(halfway, forces(world, r), world.mass, strict=True):
        v.append(vec.moved(velocity, h / mass * 0.5, force))
    return TangentState(r, v)


def impact_time(world: TangentWorld, state: TangentState, plane: Any, most: float) -> Dual | None:
    """The time [s] within a step of `most` at which the only sphere hits a plane; None without.

    g(s) = c + b s + a s^2 = 0 with g' < 0, where a = F . n/(2 m), b = v . n, c = (r - p) . n - R.
    """
    normal = tuple(plane["normal"])
    (force,) = forces(world, state.r)
    a = vec.dot(force, normal) / world.mass[0] * 0.5
    b = vec.dot(state.v[0], normal)
    c = vec.dot(vec.minus(state.r[0], tuple(plane["point"])), normal) - world.radius[0]
    discriminant = b * b - 4.0 * (a * c)
    if discriminant.value <= 0:
        return None
    fall = root(discriminant)
    # The root with g' = -sqrt(b^2 - 4 a c) < 0, in the form without cancellation: (b + sqrt)/(-2 a)
    # for b > 0, and 2 c/(sqrt - b) else.
    if b.value > 0:
        if a.value >= 0:
            return None
        time: Dual = (b + fall) / (-2.0 * a)
    else:
        time = 2.0 * c / (fall - b)
    if 0 <= time.value < most:
        return time
    return None


def struck(world: TangentWorld, state: TangentState, plane: Any) -> TangentState:
    """The state after an impact: v+ = v - (1 + e) (v . n) n."""
    normal = tuple(plane["normal"])
    closing = vec.dot(state.v[0], normal)
    velocity = vec.moved(state.v[0], -(1.0 + world.restitution) * closing, normal)
    return TangentState(state.r, [velocity])


def advance(
    world: TangentWorld, parts: Parts, state: TangentState, h: float, t: float
) -> tuple[TangentState, list[Event]]:
    """One step of h [s] from the time t, divided at its impacts; the state and the events."""
    left: Number = h
    events: list[Event] = []
    for _ in range(MOST_IMPACTS):
        first: Dual | None = None
        met: Any = None
        for plane in world.planes:
            time = impact_time(world, state, plane, value_of(left))
            if time is not None and (first is None or time.value < first.value):
                first = time
                met = plane
        if first is None:
            break
        state = verlet(world, state, parts.tangent.time_to_impact(first))
        state = struck(world, state, met)
        left = parts.tangent.time_left(left, first)
        elapsed = h - value_of(left)
        events.append(Event(time=t + elapsed, kind="contact", body=0))
    return verlet(world, state, left), events


def run(request: Request, parts: Parts) -> tuple[Trajectory, Cost]:
    """The trajectory by fixed steps, with states and derivatives after every `stride` of them."""
    begun = perf_counter()
    problem = request.problem
    assert isinstance(problem, Motion)
    document = msgspec.json.decode(problem.scene.to_json())
    document = seeded("scene", document, request.sensitivities)
    world = world_of(document)
    bodies = document["bodies"]
    state = TangentState(
        [tuple(body["position"]) for body in bodies], [tuple(body["velocity"]) for body in bodies]
    )
    h = request.signed_step
    start = float(problem.times[0])
    t = [parts.clock(start, count, problem.interval) for count in range(len(problem.times))]
    rows = [_row(bodies, state, state, 0.0)]
    events: list[Event] = []
    for count in range(1, len(t)):
        for step in range(request.stride):
            before = state
            reached = t[count - 1] + step * h
            state, told = advance(world, parts, before, h, reached)
            events += told
        carried = parts.tangent.reported_state(before, state)
        rows.append(_row(bodies, state, carried, t[count] - start))
    numbers = np.array([[[entry.value for entry in body] for body, _ in row] for row in rows])
    slopes = np.array([[[entry.slopes for entry in body] for _, body in row] for row in rows])
    derivatives = {key: slopes[..., k] for k, key in enumerate(request.sensitivities)}
    trajectory = Trajectory(
        t=np.array(t),
        position=numbers[..., POSITION],
        velocity=numbers[..., VELOCITY],
        attitude=numbers[..., ATTITUDE],
        omega=numbers[..., OMEGA],
        events=tuple(events),
        derivatives=derivatives,
    )
    steps = request.stride * (len(t) - 1)
    return trajectory, Cost(seconds=perf_counter() - begun, steps=steps)


def _row(
    bodies: list[Any], state: TangentState, carried: TangentState, elapsed: float
) -> list[tuple[list[Dual], list[Dual]]]:
    """The 13 state variables of every body at a sample, and those whose derivatives are reported.

    Without friction omega is constant: the attitude is exp(omega t/2) times that of the start.
    """
    row = []
    for i, body in enumerate(bodies):
        omega = tuple(body["omega"])
        # q = exp(omega t/2) q0, with omega in space axes.
        turn = turn_by(vec.times(elapsed, omega))
        attitude = vec.product(turn, tuple(body["attitude"]))
        now = [*state.r[i], *state.v[i], *attitude, *omega]
        told = [*carried.r[i], *carried.v[i], *attitude, *omega]
        row.append((now, told))
    return row


def time_to_impact(time: Any) -> Any:
    """The time [s] from the start of a piece to the impact, with its derivatives."""
    return time


def time_left(left: Any, time: Any) -> Any:
    """The rest of a step [s] after an impact, with its derivatives."""
    return left - time


def reported_state(before: Any, after: Any) -> Any:
    """The state whose derivatives are reported at a sample: that after the last step."""
    return after


CORRECT_TANGENT = TangentParts(
    time_to_impact=time_to_impact, time_left=time_left, reported_state=reported_state
)
