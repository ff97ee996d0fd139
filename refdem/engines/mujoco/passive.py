"""Forces that MuJoCo has no element for: its callback for passive forces (mjcb_passive), called in
every stage of an integrator at that stage's time, places and velocities.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, sqrt
from typing import Any

from refdem.core.refusal import adapter_lacks
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.spring import Spring

Vector = tuple[float, float, float]
Places = tuple[list[int], list[int]]
"""Where the coordinates of a body and its velocities lie in MuJoCo's state; a missing third or
second one is 0."""
ForceLaw = Callable[[float, Vector, Vector], Vector]
"""The force [N] on a body at a time [s], place [m] and velocity [m/s]."""


@dataclass(frozen=True)
class Push:
    """A force law that acts on body `a`, and with the opposite sign on body `b` unless that is the
    world (-1); the law is given the place and the velocity of a relative to b.
    """

    a: int
    b: int
    law: ForceLaw


@contextmanager
def acting(mujoco: Any, scene: Scene, places: Sequence[Places]) -> Iterator[None]:
    """While a run lasts the scene's forces act on its bodies, whose coordinates are at `places`.

    The callback is the process's, not a model's.
    """
    kept = mujoco.get_mjcb_passive()
    pushes = list(_pushes(scene))
    if pushes:
        mujoco.set_mjcb_passive(_passive(pushes, places))
    try:
        yield
    finally:
        if pushes:
            mujoco.set_mjcb_passive(kept)


def is_passive(element: Any, scene: Scene) -> bool:
    """True if the callback says the element, for MuJoCo has none that does."""
    if isinstance(element, Force | CentralField | PiecewiseField):
        return True
    if isinstance(element, Spring):
        # MuJoCo's spring is a polynomial, linear or odd and cubic.
        return element.exponent not in (1, 3) or bool(element.quadratic)
    if isinstance(element, Dashpot):
        depends = bool(element.van_der_pol) or element.damping < 0
        turns = "rotation" in scene.features and bool(scene.bodies.inertia[element.a].any())
        return depends or element.b >= 0 or turns
    return False


def of_passive(scene: Scene) -> str | None:
    """None if every force of the callback acts at the centre of a body that moves along the axes of
    space; else why not.
    """
    elements = [element for element in scene.elements if is_passive(element, scene)]
    linked = [element for element in elements if isinstance(element, Force | Spring | Dashpot)]
    for link in linked:
        if any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)):
            return adapter_lacks(f"a {link.kind} by mjcb_passive off the centre of a body")
        if any(scene.bodies.fixed[end] for end in (link.a, link.b) if end >= 0):
            return adapter_lacks(f"a {link.kind} by mjcb_passive on a fixed body")
    if elements and any(element.kind in ("rod", "ball_joint") for element in scene.elements):
        return adapter_lacks(
            "a force by mjcb_passive beside rotating joints, whose coordinates are not positions"
        )
    return None


def _pushes(scene: Scene) -> Iterator[Push]:
    """The forces of the callback, element by element."""
    moving = [number for number, fixed in enumerate(scene.bodies.fixed) if not fixed]
    for element in scene.elements:
        if not is_passive(element, scene):
            continue
        if isinstance(element, Force):
            yield Push(element.a, element.b, _periodic(element))
        elif isinstance(element, Spring):
            yield Push(element.a, element.b, _spring(element))
        elif isinstance(element, Dashpot):
            yield Push(element.a, element.b, _dashpot(element))
        elif isinstance(element, CentralField):
            for number in moving:
                yield Push(number, -1, _attraction(element, float(scene.bodies.mass[number])))
        elif isinstance(element, PiecewiseField):
            for number in moving:
                yield Push(number, -1, _slope(element))


def _passive(pushes: Sequence[Push], places: Sequence[Places]) -> Any:
    """The callback that applies the forces."""

    def state(values: Any, columns: list[int]) -> Vector:
        numbers = [float(values[column]) for column in columns[:3]]
        x, y, z = (*numbers, *(0.0,) * (3 - len(numbers)))
        return x, y, z

    def passive(model: Any, data: Any) -> None:
        time = data.time
        q = data.qpos
        v = data.qvel
        felt = data.qfrc_passive
        for push in pushes:
            place = state(q, places[push.a][0])
            velocity = state(v, places[push.a][1])
            if push.b >= 0:
                place = _difference(place, state(q, places[push.b][0]))
                velocity = _difference(velocity, state(v, places[push.b][1]))
            force = push.law(time, place, velocity)
            for body, sign in ((push.a, 1.0), (push.b, -1.0)):
                if body < 0:
                    continue
                for column, component in zip(places[body][1][:3], force, strict=False):
                    felt[column] += sign * component

    return passive


def _difference(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _periodic(drive: Force) -> ForceLaw:
    """F = amplitude cos(frequency t + phase) along the axis."""
    (x, y, z) = drive.axis

    def force(t: float, place: Vector, velocity: Vector) -> Vector:
        size = drive.amplitude * cos(drive.frequency * t + drive.phase)
        return size * x, size * y, size * z

    return force


def _spring(spring: Spring) -> ForceLaw:
    """F = -(k |s|^n sgn(s) + a s^2 + b s^3) e in the stretch s = |d| - length, d = |d| e being the
    way from the spring's other end.
    """
    anchor = spring.anchor_b

    def force(t: float, place: Vector, velocity: Vector) -> Vector:
        (x, y, z) = _difference(place, anchor)
        distance = sqrt(x * x + y * y + z * z)
        if distance == 0:  # a spring of no length has no direction
            return 0.0, 0.0, 0.0
        stretch = distance - spring.length
        power = spring.stiffness * abs(stretch) ** spring.exponent
        if stretch < 0:
            power = -power
        pull = power + (spring.quadratic + spring.cubic * stretch) * stretch * stretch
        per_length = -pull / distance
        return per_length * x, per_length * y, per_length * z

    return force


def _dashpot(dashpot: Dashpot) -> ForceLaw:
    """F = -(damping + van_der_pol d^2) v, where d is the distance from the dashpot's other end."""
    anchor = dashpot.anchor_b

    def force(t: float, place: Vector, velocity: Vector) -> Vector:
        (x, y, z) = _difference(place, anchor)
        coefficient = dashpot.damping + dashpot.van_der_pol * (x * x + y * y + z * z)
        return -coefficient * velocity[0], -coefficient * velocity[1], -coefficient * velocity[2]

    return force


def _attraction(field: CentralField, mass: float) -> ForceLaw:
    """F = -gm m r/|r|^3 towards the origin."""

    def force(t: float, place: Vector, velocity: Vector) -> Vector:
        (x, y, z) = place
        square = x * x + y * y + z * z
        pull = -field.gm * mass / (square * sqrt(square))
        return pull * x, pull * y, pull * z

    return force


def _slope(field: PiecewiseField) -> ForceLaw:
    """F(s) along the axis, s = (r - point).axis: k1 (s - x1) up to s = 0, then k2 (s - x2)."""
    (e_x, e_y, e_z) = field.axis

    def force(t: float, place: Vector, velocity: Vector) -> Vector:
        (x, y, z) = _difference(place, field.point)
        s = x * e_x + y * e_y + z * e_z
        if s <= 0:
            size = field.k1 * max(s - field.x1, 0.0)
        else:
            size = field.k2 * min(s - field.x2, 0.0)
        return size * e_x, size * e_y, size * e_z

    return force
