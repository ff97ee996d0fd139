"""Right programs for spheres in contact, each a textbook scheme that evaluates the contact law at
states of its own choosing: x and v of the start, the middle or the end of a step, or of different
instants. None of them cuts a step at a touch, so that all are of first order in contacts.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

LEVER = {"R": 0.0, "R-d/2": 0.5, "R-d": 1.0}
FIRST = {"contact": 1, "friction": 1}
PRECISION: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}


@dataclass(frozen=True)
class State:
    """Places r, velocities v and angular velocities w, each (N, 3), all in one precision."""

    r: Any
    v: Any
    w: Any

    def plus(self, h: Any, rate: "State") -> "State":
        """This state and h times a rate."""
        return State(self.r + h * rate.r, self.v + h * rate.v, self.w + h * rate.w)


class Law:
    """Accelerations of spheres under one contact law, planes and gravity."""

    def __init__(self, scene: Scene, number: type[np.floating[Any]]) -> None:
        self.number = number
        self.law = scene.all(Contact)[0]
        self.mass = scene.bodies.mass.astype(number)
        self.radius = scene.bodies.radius.astype(number)
        self.inertia = scene.bodies.inertia[:, 0].astype(number)
        self.walls = [
            (np.array(plane.point, number), np.array(plane.normal, number))
            for plane in scene.all(Plane)
        ]
        weights = [np.array(field.g, number) for field in scene.all(UniformGravity)]
        self.gravity = sum(weights, np.zeros(3, number))

    def rate(self, r: Any, v: Any, w: Any) -> State:
        """The rate of change (v, F/m, M/J) of a state, with forces at places r, velocities v and
        spins w, which may be those of different instants.
        """
        force = np.tile(self.gravity, (len(r), 1)) * self.mass[:, None]
        torque = np.zeros_like(force)
        for i in range(len(r)):
            for j in range(i):
                self._pair(j, i, r, v, w, force, torque)
            for point, normal in self.walls:
                self._wall(i, point, normal, r, v, w, force, torque)
        turning = np.where(self.inertia > 0, self.inertia, self.number(1))
        return State(v, force / self.mass[:, None], torque / turning[:, None])

    def _pair(self, i: int, j: int, r: Any, v: Any, w: Any, force: Any, torque: Any) -> None:
        apart = r[j] - r[i]
        distance = np.sqrt(apart @ apart)
        depth = self.radius[i] + self.radius[j] - distance
        if depth <= 0:
            return
        normal = apart / distance
        arms = [radius - self.number(LEVER[self.law.branch]) * depth for radius in self.radius]
        spin = arms[i] * w[i] + arms[j] * w[j]
        on_first = self._force(depth, v[i] - v[j], spin, normal)
        force[i] += on_first
        force[j] -= on_first
        torque[i] += arms[i] * np.cross(normal, on_first)
        torque[j] += arms[j] * np.cross(normal, on_first)

    def _wall(
        self, i: int, point: Any, outward: Any, r: Any, v: Any, w: Any, force: Any, torque: Any
    ) -> None:
        depth = self.radius[i] - (r[i] - point) @ outward
        if depth <= 0:
            return
        arm = self.radius[i] - self.number(LEVER[self.law.branch]) * depth
        on_sphere = self._force(depth, v[i], arm * w[i], -outward)
        force[i] += on_sphere
        torque[i] += arm * np.cross(-outward, on_sphere)

    def _force(self, depth: Any, velocity: Any, spin: Any, normal: Any) -> Any:
        """The force on the first body; its velocity is against the second, `normal` towards it."""
        closing = velocity @ normal
        stretch = depth ** self.number(self.law.exponent)
        push = self.number(self.law.stiffness) * stretch + self.number(self.law.damping) * closing
        if self.law.cutoff == "zero_force":
            push = max(push, self.number(0))
        slip = velocity - closing * normal + np.cross(spin, normal)
        speed = np.sqrt(slip @ slip)
        on_first = -push * normal
        if speed > 0:
            limit = self.number(self.law.friction) * max(push, self.number(0))
            on_first = on_first - limit / speed * slip
        return on_first


Step = Callable[[Law, State, Any, dict[str, Any]], State]


def kick_drift(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Symplectic Euler: v += h a(x, v), then x += h v."""
    rate = law.rate(s.r, s.v, s.w)
    v = s.v + h * rate.v
    return State(s.r + h * v, v, s.w + h * rate.w)


def drift_kick(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Symplectic Euler: x += h v, then v += h a(x, v)."""
    r = s.r + h * s.v
    rate = law.rate(r, s.v, s.w)
    return State(r, s.v + h * rate.v, s.w + h * rate.w)


def explicit_euler(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Euler: all of the rate at the start."""
    return s.plus(h, law.rate(s.r, s.v, s.w))


def verlet_half(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Velocity Verlet whose force is stored: the dashpot sees the velocity of the half step."""
    half = h / law.number(2)
    rate = kept.get("rate") or law.rate(s.r, s.v, s.w)
    v = s.v + half * rate.v
    w = s.w + half * rate.w
    r = s.r + h * v
    kept["rate"] = after = law.rate(r, v, w)
    return State(r, v + half * after.v, w + half * after.w)


def verlet_predicted(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Velocity Verlet whose dashpot sees v + h a, predicted with the acceleration of the start."""
    half = h / law.number(2)
    rate = law.rate(s.r, s.v, s.w)
    r = s.r + h * (s.v + half * rate.v)
    after = law.rate(r, s.v + h * rate.v, s.w + h * rate.w)
    return State(r, s.v + half * (rate.v + after.v), s.w + half * (rate.w + after.w))


def verlet_iterated(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Velocity Verlet whose dashpot sees the velocity of the end, found by iteration."""
    half = h / law.number(2)
    rate = law.rate(s.r, s.v, s.w)
    r = s.r + h * (s.v + half * rate.v)
    v = s.v + h * rate.v
    w = s.w + h * rate.w
    for _ in range(8):
        after = law.rate(r, v, w)
        v = s.v + half * (rate.v + after.v)
        w = s.w + half * (rate.w + after.w)
    return State(r, v, w)


def midpoint(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Explicit midpoint rule."""
    middle = s.plus(h / law.number(2), law.rate(s.r, s.v, s.w))
    return s.plus(h, law.rate(middle.r, middle.v, middle.w))


def adams_bashforth(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Adams and Bashforth's second-order rule, 3/2 of this rate less 1/2 of the one before."""
    rate = law.rate(s.r, s.v, s.w)
    before = kept.get("rate", rate)
    kept["rate"] = rate
    half = h / law.number(2)
    return s.plus(3 * half, rate).plus(-half, before)


TABLEAU = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
)
WEIGHTS = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)


def dormand_prince(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Dormand and Prince's fifth-order rule with fixed steps; one of its weights is negative."""
    rates: list[State] = []
    for row in TABLEAU:
        stage = s
        for weight, rate in zip(row, rates, strict=True):
            stage = stage.plus(law.number(weight) * h, rate)
        rates.append(law.rate(stage.r, stage.v, stage.w))
    for weight, rate in zip(WEIGHTS, rates, strict=True):
        s = s.plus(law.number(weight) * h, rate)
    return s


def rk4(law: Law, s: State, h: Any, kept: dict[str, Any]) -> State:
    """Classical Runge-Kutta rule."""
    number = law.number
    first = law.rate(s.r, s.v, s.w)
    a = s.plus(h / number(2), first)
    second = law.rate(a.r, a.v, a.w)
    b = s.plus(h / number(2), second)
    third = law.rate(b.r, b.v, b.w)
    c = s.plus(h, third)
    fourth = law.rate(c.r, c.v, c.w)
    for weight, rate in ((1 / 6, first), (1 / 3, second), (1 / 3, third), (1 / 6, fourth)):
        s = s.plus(number(weight) * h, rate)
    return s


STEPS: dict[str, tuple[Step, int]] = {
    "kick-drift": (kick_drift, 1),
    "drift-kick": (drift_kick, 1),
    "explicit-euler": (explicit_euler, 1),
    "verlet-half": (verlet_half, 2),
    "verlet-predicted": (verlet_predicted, 2),
    "verlet-iterated": (verlet_iterated, 2),
    "midpoint": (midpoint, 2),
    "adams-bashforth": (adams_bashforth, 2),
    "rk4": (rk4, 4),
    "dormand-prince": (dormand_prince, 5),
}
DOUBLE = tuple(
    Method(
        name=name,
        summary=(step.__doc__ or "").strip(),
        control="step",
        order=order,
        order_with=FIRST,
        conserves=frozenset({"momentum"}),
    )
    for name, (step, order) in STEPS.items()
)
SINGLE = tuple(
    replace(method, name=f"{method.name}-single", precision="single")
    for method in DOUBLE
    if method.name in ("kick-drift", "verlet-half", "rk4")
)


class RightSpheres(Engine):
    """Spheres in contact by each scheme of STEPS, in double and in single precision."""

    name = "right-spheres"
    title = "Right programs for spheres"
    methods = DOUBLE + SINGLE
    licence = "BSD-3-Clause"

    def missing(self) -> str | None:
        """None: it is part of the tests."""
        return None

    def version(self) -> str:
        """It has one version."""
        return "1"

    def fingerprint(self, method: Method) -> str:
        """Its runs are never stored."""
        return "right-spheres"

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None for free spheres under one contact law with an overlap and without memory."""
        scene = problem.scene
        laws = scene.all(Contact)
        if not all(isinstance(e, Contact | Plane | UniformGravity) for e in scene.elements):
            return "contacts, planes and gravity alone"
        if len(laws) != 1 or laws[0].law == "rigid" or laws[0].tangential_stiffness > 0:
            return "one contact law without tangential springs"
        if not all(isinstance(shape, Sphere) for shape in scene.bodies.shape):
            return "spheres alone"
        if scene.bodies.fixed.any():
            return "no fixed body"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Fixed steps; a row of numbers after every `stride` of them."""
        assert isinstance(request.problem, Motion)
        method = self.method(request.method)
        number = PRECISION[method.precision]
        scene = request.problem.scene
        law = Law(scene, number)
        bodies = scene.bodies
        state = State(
            bodies.position.astype(number),
            bodies.velocity.astype(number),
            bodies.omega.astype(number),
        )
        step, _ = STEPS[request.method.removesuffix("-single")]
        h = number(request.signed_step)
        kept: dict[str, Any] = {}
        rows = [state]
        for _ in range(len(request.problem.times) - 1):
            for _ in range(request.stride):
                state = step(law, state, h, kept)
            rows.append(state)
        samples, count = len(rows), len(bodies)
        attitude = np.zeros((samples, count, 4))
        attitude[..., 0] = 1.0
        trajectory = Trajectory(
            t=np.array(request.problem.times),
            position=np.array([row.r for row in rows], float),
            velocity=np.array([row.v for row in rows], float),
            attitude=attitude,
            omega=np.array([row.w for row in rows], float),
        )
        return trajectory, Cost(seconds=1e-9, steps=request.stride * (samples - 1))
