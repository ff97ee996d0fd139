"""The correct parts of the transparent engine, each a small function or a constant."""

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


def point_forces() -> dict[type[Element], Callable[..., Vector]]:
    """The force on points of every kind of element that defines one, by kind. The functions have
    the arguments of `Field.force` or `Link.force`, after the element.
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
    """The rate q' = q (0, omega_body)/2 of the attitude (1.67)."""
    w, x, y, z = vec.product(q, (0.0, *omega))
    return w / 2, x / 2, y / 2, z / 2


def turned(q: Quaternion, omega: Vector, h: Number) -> Quaternion:
    """Attitude after a rotation with constant omega [rad/s] in body axes for h [s]: q exp(omega
    h/2).
    """
    return vec.product(q, vec.turn_by(vec.times(h, omega)))


def axis_turn(
    axis: int, inertia: Vector, omega: Vector, q: Quaternion, h: Number
) -> tuple[Vector, Quaternion]:
    """omega_body and attitude after the exact rotation of the body about one principal axis for h
    [s].
    """
    # The flow of T = L_k^2/(2 J_k) alone: q+ = q (cos(a/2), sin(a/2) e_k) with a = h omega_k. L is
    # constant in space, so that its body components rotate by -a about e_k.
    angle = h * omega[axis]
    c = cos(angle)
    s = sin(angle)
    momentum: Any = list(vec.per_axis(inertia, omega))
    i = (axis + 1) % 3
    j = (axis + 2) % 3
    # L_i+ = cos(a) L_i + sin(a) L_j, L_j+ = cos(a) L_j - sin(a) L_i.
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
    """Velocity after a constant force for h [s]: v + h F/m."""
    return vec.moved(v, h / mass, force)


def spun_up(omega: Vector, torque: Vector, inertia: Vector, h: Number) -> Vector:
    """omega_body after a constant torque in body axes for h [s]: omega + h J^-1 torque."""
    x = omega[0] + h * torque[0] / inertia[0]
    y = omega[1] + h * torque[1] / inertia[1]
    z = omega[2] + h * torque[2] / inertia[2]
    return x, y, z


def drifted(r: Vector, v: Vector, h: Number) -> Vector:
    """The position after a drift of h [s] at constant velocity: r + h v."""
    return vec.moved(r, h, v)


def reaction(force: Vector) -> Vector:
    """The reaction -F on the other body."""
    return -force[0], -force[1], -force[2]


def away(a: Vector, b: Vector) -> Vector:
    """The vector (3) [m] from the centre of a to that of b."""
    return vec.minus(b, a)


def overlap(radius_a: Number, radius_b: Number, distance: Number) -> Number:
    """The overlap d = R_a + R_b - distance [m] of two spheres, negative if they are apart."""
    return (radius_a + radius_b) - distance


def normal_force(law: Contact, depth: Number, rate: Number) -> Number:
    """F_n = k d + c d' [N], attractive if negative; with k d^(3/2) instead of k d for Hertz's
    law.
    """
    if law.law == "hertz":
        pressed = max(depth, 0.0) ** 1.5
    else:
        pressed = depth
    return law.stiffness * pressed + law.damping * rate


def lever(radius: Number, depth: Number, shortening: Number) -> Number:
    """Lever R - c d [m] of the slip, or of the torque of the tangential force, on a sphere; the law
    sets the `shortening` c.
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
    """A vector of the tangent plane across `old`, rotated into that across `normal` by the smallest
    rotation that takes one normal to the other.
    """
    # x+ = x - (n . x)/(1 + n0 . n) (n0 + n) for x perpendicular to n0 (Rodrigues).
    both = vec.plus(old, normal)
    return vec.moved(stretch, -vec.dot(normal, stretch) / (1.0 + vec.dot(old, normal)), both)


def stretched(stretch: Vector, slip_before: Vector, slip_now: Vector, h: Number) -> Vector:
    """The tangential spring after h [s], xi + h/2 (s0 + s1): the trapezoidal rule for xi' = s."""
    return vec.moved(stretch, h / 2, vec.plus(slip_before, slip_now))


def clipped(law: Contact, stretch: Vector, normal: Number) -> Vector:
    """The spring at Coulomb's limit, |xi| = mu F_n/k_t, with the direction of `stretch`."""
    # xi+ = mu F_n/k_t xi/|xi|.
    longest = law.friction * max(normal, 0.0) / law.tangential_stiffness
    length = vec.size(stretch)
    if length > 0:
        return vec.times(longest / length, stretch)
    return stretch


def spring_friction(law: Contact, stretch: Vector) -> Vector:
    """Force -k_t xi [N] of the tangential spring on a."""
    return vec.times(-law.tangential_stiffness, stretch)


def sliding_friction(law: Contact, normal: Number, slide: Vector, stopping: Number) -> Vector:
    """Sliding friction -mu F_n s/|s| [N].

    Raises UnsupportedError where mu F_n > `stopping` |s|: with `stopping` = m_t/h [kg/s] the
    friction would then stop the slip within one step.
    """
    speed = vec.size(slide)
    limit = law.friction * max(normal, 0.0)
    if limit > stopping * speed:
        raise UnsupportedError("a contact without a tangential spring that comes to stick")
    if speed > 0:
        return vec.times(-limit / speed, slide)
    return vec.ZERO


def torque_on(arm: Number, normal: Vector, force: Vector) -> Vector:
    """Torque arm n x F [N m] of the tangential force on a. The torque of the reaction on b has the
    same direction, with the lever of b.
    """
    return vec.times(arm, vec.cross(normal, force))


def presses(law: Contact, depth: Number, force: Number) -> Number:
    """A guard that is positive while the contact acts: its overlap, or its force for the cutoff
    `zero_force`.
    """
    if law.cutoff == "zero_overlap":
        return depth
    return force


def slides_at(slider: Slider, velocity: Vector) -> Number:
    """Velocity u = v . axis - belt [m/s] of a body along the axis of its slider, relative to the
    belt.
    """
    return vec.dot(velocity, slider.axis) - slider.belt_velocity


def slider_force(slider: Slider, side: int, speed: Number) -> Vector:
    """Dry friction -side mu(|u|) N [N] on a body that slips towards `side` along the axis."""
    return vec.times(-side * slider.coefficient(speed) * slider.normal_force, slider.axis)


def holds(slider: Slider, along: Number) -> bool:
    """True if dry friction can balance a force [N] along its axis at rest: |F| <= mu(0) N."""
    limit = slider.coefficient(0.0) * slider.normal_force
    return bool(abs(along) <= limit)


def rod_position(rod: Rod, apart: Vector, direction: Vector, ease: Number) -> Number:
    """Multiplier [kg] of `direction` that brings the ends to the rod's length, by one Newton step;
    over the step h it is an impulse. `ease` is 1/m_a + 1/m_b.
    """
    # |x|^2 - l^2 = 0 for x = apart - P ease direction: P = (|apart|^2 - l^2)/(2 ease apart .
    # direction).
    excess = vec.dot(apart, apart) - rod.length * rod.length
    slope = 2 * ease * vec.dot(apart, direction)
    return excess / slope


def rod_velocity(rod: Rod, apart: Vector, relative: Vector, ease: Number) -> Number:
    """Multiplier lambda [kg/s] of the rod vector r that removes the relative velocity along the
    rod.

    r . (v - lambda ease r) = 0, so that lambda = r . v/(ease |r|^2); `ease` is 1/m_a + 1/m_b.
    """
    return vec.dot(apart, relative) / (ease * vec.dot(apart, apart))


def rod_tension(rod: Rod, apart: Vector, relative: Vector, pull: Vector, ease: Number) -> Number:
    """Rod force [N], positive in tension: (|v|^2 + r . a)/(l ease).

    `pull` is the relative acceleration a without the rod force; r . r'' + |v|^2 = 0 keeps the
    length l.
    """
    needed = vec.dot(relative, relative) + vec.dot(apart, pull)
    return needed / (ease * rod.length)


def clock(start: Number, count: int, interval: Number) -> Number:
    """Time [s] of sample `count`."""
    return start + count * interval


def fresh(kept: dict[str, Any]) -> None:
    """Clears the memory of earlier runs."""
    kept.clear()


def output(state: Any) -> Any:
    """The state with which the run continues after a sample was written, unchanged."""
    return state


S4 = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
"""Suzuki 1990: five steps s4, s4, 1 - 4 s4, s4, s4 of a symmetric method of order 2 have order 4.
"""


CORRECT = Parts(
    forces=point_forces(),
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
"""The correct parts, with which the engine has no fault."""
