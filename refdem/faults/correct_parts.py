"""The sound parts of the transparent engine, each a small plain function or constant."""

from collections.abc import Callable
from math import cos, sin
from typing import Any

from refdem.errors import UnsupportedError
from refdem.faults.events import side_of, sign_change
from refdem.faults.holding import CORRECT_HOLDING
from refdem.faults.impacts import CORRECT_IMPACTS
from refdem.faults.iterating import CORRECT_MAPS
from refdem.faults.loads import loads
from refdem.faults.outlines import linear_flow
from refdem.faults.parts import Parts
from refdem.faults.positional import CORRECT_POSITIONAL
from refdem.faults.rolling import CORRECT_ROLLING
from refdem.faults.tangent import CORRECT_TANGENT
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Quaternion, Vector
from refdem.scene.element import Element, Field, Link
from refdem.scene.elements import KINDS
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider


def told_forces() -> dict[type[Element], Callable[..., Vector]]:
    """The force of every kind of element that tells it for points, as a function of an element of
    that kind and of what `Field.force` or `Link.force` is given.
    """
    forces: dict[type[Element], Callable[..., Vector]] = {}
    for kind in KINDS.values():
        if issubclass(kind, Field) or (issubclass(kind, Link) and kind.has_force):
            forces[kind] = kind.force
    return forces


def gyroscopic(inertia: Vector, omega: Vector) -> Vector:
    """The torque -omega x J omega [N m] in body axes."""
    return vec.cross(vec.per_axis(inertia, omega), omega)


def turn_rate(q: Quaternion, omega: Vector) -> Quaternion:
    """The rate q' = q omega_body / 2 of the attitude."""
    w, x, y, z = vec.product(q, (0.0, *omega))
    return w / 2, x / 2, y / 2, z / 2


def turned(q: Quaternion, omega: Vector, h: Number) -> Quaternion:
    """Attitude after turning with omega [rad/s] in body axes for h [s]."""
    return vec.product(q, vec.turn_by(vec.times(h, omega)))


def axis_turn(
    axis: int, inertia: Vector, omega: Vector, q: Quaternion, h: Number
) -> tuple[Vector, Quaternion]:
    """omega_body and attitude after the exact rotation of the body about one principal axis for h
    [s].
    """
    # With T = L_axis^2/(2 J_axis) alone, L in space and omega along the axis stay as they are.
    angle = h * omega[axis]
    c = cos(angle)
    s = sin(angle)
    momentum: Any = list(vec.per_axis(inertia, omega))
    i = (axis + 1) % 3
    j = (axis + 2) % 3
    # The momentum stays in space, so that its components in the body turn backwards.
    turned_i = c * momentum[i] + s * momentum[j]
    turned_j = c * momentum[j] - s * momentum[i]
    momentum[i] = turned_i
    momentum[j] = turned_j
    half: Any = [cos(angle / 2), 0.0, 0.0, 0.0]
    half[1 + axis] = sin(angle / 2)
    return vec.over_axis(momentum, inertia), vec.product(q, half)


def to_body(q: Quaternion, a: Vector) -> Vector:
    """A space vector in body axes."""
    return vec.rotated(vec.conjugate(q), a)


def to_space(q: Quaternion, a: Vector) -> Vector:
    """A body vector in space axes."""
    return vec.rotated(q, a)


def kicked(v: Vector, force: Vector, mass: Number, h: Number) -> Vector:
    """Velocity after a force for h [s]."""
    return vec.moved(v, h / mass, force)


def spun_up(omega: Vector, torque: Vector, inertia: Vector, h: Number) -> Vector:
    """omega_body after a torque in body axes for h [s]."""
    x = omega[0] + h * torque[0] / inertia[0]
    y = omega[1] + h * torque[1] / inertia[1]
    z = omega[2] + h * torque[2] / inertia[2]
    return x, y, z


def drifted(r: Vector, v: Vector, h: Number) -> Vector:
    """The position after a drift of h [s]."""
    return vec.moved(r, h, v)


def reaction(force: Vector) -> Vector:
    """The force that the other body feels: the reaction."""
    return -force[0], -force[1], -force[2]


def away(a: Vector, b: Vector) -> Vector:
    """The vector (3) [m] from the centre of a to that of b."""
    return vec.minus(b, a)


def overlap(radius_a: Number, radius_b: Number, distance: Number) -> Number:
    """The overlap [m] of two spheres in contact."""
    return (radius_a + radius_b) - distance


def normal_force(law: Contact, depth: Number, rate: Number) -> Number:
    """k d + c d' [N], pulls when negative; k d^(3/2) for Hertz's law."""
    if law.law == "hertz":
        pressed = max(depth, 0.0) ** 1.5
    else:
        pressed = depth
    return law.stiffness * pressed + law.damping * rate


def lever(radius: Number, depth: Number, shortening: Number) -> Number:
    """Arm R - c d [m] of slip, or of the torque of the tangential force, on a sphere: its
    `shortening` c is the law's.
    """
    return radius - shortening * depth


def slip(velocity: Vector, spin: Vector, normal: Vector) -> Vector:
    """Tangential velocity of surface a against b [m/s], v - (v . n) n + spin x n, with spin = arm_a
    omega_a + arm_b omega_b.
    """
    return vec.plus(
        vec.moved(velocity, -vec.dot(velocity, normal), normal), vec.cross(spin, normal)
    )


def transported(stretch: Vector, old: Vector, normal: Vector) -> Vector:
    """A vector of one tangent plane turned into another, by the least rotation from normal to
    normal.
    """
    # x - (n . x)/(1 + n0 . n) (n0 + n) for x in the plane across n0 (Rodrigues).
    both = vec.plus(old, normal)
    return vec.moved(stretch, -vec.dot(normal, stretch) / (1.0 + vec.dot(old, normal)), both)


def stretched(stretch: Vector, slip_before: Vector, slip_now: Vector, h: Number) -> Vector:
    """The tangential spring after h [s] of slip, by the trapezoidal rule for xi' = s."""
    return vec.moved(stretch, h / 2, vec.plus(slip_before, slip_now))


def clipped(law: Contact, stretch: Vector, normal: Number) -> Vector:
    """The spring as long as Coulomb's limit allows, |xi| = mu F_n/k_t, along its direction."""
    longest = law.friction * max(normal, 0.0) / law.tangential_stiffness
    length = vec.size(stretch)
    if length > 0:
        return vec.times(longest / length, stretch)
    return stretch


def spring_friction(law: Contact, stretch: Vector) -> Vector:
    """Force [N] of the tangential spring on a."""
    return vec.times(-law.tangential_stiffness, stretch)


def sliding_friction(law: Contact, normal: Number, slide: Vector, stopping: Number) -> Vector:
    """Friction of full size against the slip; raises UnsupportedError where a step of it
    (`stopping` [kg/s]) would stop the slip.
    """
    speed = vec.size(slide)
    limit = law.friction * max(normal, 0.0)
    if limit > stopping * speed:
        raise UnsupportedError("a contact without a tangential spring that comes to stick")
    if speed > 0:
        return vec.times(-limit / speed, slide)
    return vec.ZERO


def torque_on(arm: Number, normal: Vector, force: Vector) -> Vector:
    """Torque [N m] of the tangential force on a; the reaction turns b the same way with its own
    arm.
    """
    return vec.times(arm, vec.cross(normal, force))


def presses(law: Contact, depth: Number, force: Number) -> Number:
    """Positive while the contact acts."""
    if law.cutoff == "zero_overlap":
        return depth
    return force


def slides_at(slider: Slider, velocity: Vector) -> Number:
    """Velocity [m/s] along a slider's axis against its belt."""
    return vec.dot(velocity, slider.axis) - slider.belt_velocity


def slider_force(slider: Slider, side: int, speed: Number) -> Vector:
    """Dry friction [N] on a body that slips towards `side` along the axis with this speed."""
    return vec.times(-side * slider.coefficient(speed) * slider.normal_force, slider.axis)


def holds(slider: Slider, along: Number) -> bool:
    """Dry friction balances a force [N] along its axis at rest."""
    limit = slider.coefficient(0.0) * slider.normal_force
    return bool(abs(along) <= limit)


def rod_position(rod: Rod, apart: Vector, direction: Vector, ease: Number) -> Number:
    """Impulse over time [kg] along `direction` that brings the ends to the rod's length (one Newton
    step). `ease` is 1/m_a + 1/m_b.
    """
    # |apart|^2 - l^2 = 0, whose slope by the impulse is 2 ease apart . direction.
    excess = vec.dot(apart, apart) - rod.length * rod.length
    slope = 2 * ease * vec.dot(apart, direction)
    return excess / slope


def rod_velocity(rod: Rod, apart: Vector, relative: Vector, ease: Number) -> Number:
    """Impulse over length [kg/s] that takes the relative velocity along the rod away.

    r . (v - lambda ease r) = 0; `ease` is 1/m_a + 1/m_b.
    """
    return vec.dot(apart, relative) / (ease * vec.dot(apart, apart))


def rod_tension(rod: Rod, apart: Vector, relative: Vector, pull: Vector, ease: Number) -> Number:
    """Rod force [N], positive in tension: (|v|^2 + r.a)/(r ease).

    `pull` is the relative acceleration without it.
    """
    needed = vec.dot(relative, relative) + vec.dot(apart, pull)
    return needed / (ease * rod.length)


def clock(start: Number, count: int, interval: Number) -> Number:
    """Time [s] of sample `count`."""
    return start + count * interval


def fresh(kept: dict[str, Any]) -> None:
    """What is done with the memory of earlier runs: it is thrown away."""
    kept.clear()


def output(state: Any) -> Any:
    """The state with which the run goes on after a sample was written: it is read, never
    changed.
    """
    return state


S4 = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
"""Suzuki 1990: five steps of a symmetric method of order 2 make one of order 4."""


CORRECT = Parts(
    forces=told_forces(),
    gyroscopic=gyroscopic,
    turn_rate=turn_rate,
    turned=turned,
    axis_turn=axis_turn,
    to_body=to_body,
    to_space=to_space,
    unit=vec.unit,
    kicked=kicked,
    spun_up=spun_up,
    drifted=drifted,
    reaction=reaction,
    away=away,
    overlap=overlap,
    normal_force=normal_force,
    lever=lever,
    slip=slip,
    transported=transported,
    stretched=stretched,
    clipped=clipped,
    spring_friction=spring_friction,
    sliding_friction=sliding_friction,
    torque_on=torque_on,
    presses=presses,
    slides_at=slides_at,
    slider_force=slider_force,
    holds=holds,
    rod_position=rod_position,
    rod_velocity=rod_velocity,
    rod_tension=rod_tension,
    clock=clock,
    fresh=fresh,
    output=output,
    loads=loads,
    side_of=side_of,
    located=sign_change,
    maps=CORRECT_MAPS,
    flow=linear_flow,
    positional=CORRECT_POSITIONAL,
    holding=CORRECT_HOLDING,
    impacts=CORRECT_IMPACTS,
    rolling=CORRECT_ROLLING,
    tangent=CORRECT_TANGENT,
    verlet_kicks=(0.5, 0.5),
    suzuki=(S4, S4, 1.0 - 4.0 * S4, S4, S4),
    rk4_nodes=(0.5, 0.5, 1.0),
    rk4_weights=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
)
"""All of them: the engine without any fault."""
