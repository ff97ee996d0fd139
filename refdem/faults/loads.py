"""Loads on the bodies in a state: forces, torques, and the tangential springs of contacts.

Notation of a contact of bodies i and j (or a plane): n the unit normal from i to j, d the overlap
(`depth`), d' its rate, v = v_i - v_j, s the slip of the surfaces that touch, xi the tangential
spring (`stretch`), F_n the normal force. Every function adds to `total`, whose `power` is the rate
[W] at which energy leaves the motion.
"""

from collections.abc import Callable
from typing import Any

from refdem.faults.holding import turned_at_joints
from refdem.faults.parts import Parts
from refdem.faults.positional import force_of_fields, pushed_by_fields, pushed_by_walls, rounded
from refdem.faults.rolling import carried
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import ZERO, Number, Vector


def loads(
    world: World, state: State, parts: Parts, before: Loads | None = None, h: Number = 0.0
) -> Loads:
    """The loads of a state that was reached from one with the loads `before` in a step of h [s]."""
    bodies = len(world.mass)
    pairs = len(world.pairs)
    total = Loads(
        [ZERO] * bodies, [ZERO] * bodies, [ZERO] * pairs, [ZERO] * pairs, list(state.stretch), 0.0
    )
    for source in world.sources:
        SOURCES[source](world, state, parts, total, before, h)
    return total


def _links(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of links, and the power F . w of those that have no potential."""
    for link in world.links:
        relative = link.approach(state.v)
        tell = parts.forces[type(link)]
        force = tell(link, state.t, link.branch(state.r), relative)
        if link.reads_clock:
            force = rounded(force, world)
        _add(total, link.a, link.b, force, parts)
        if not link.conservative:
            total.power -= vec.dot(force, relative)


def _fields(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of fields on all bodies."""
    for i in range(len(world.mass)):
        total.force[i] = vec.plus(total.force[i], force_of_fields(world, state, parts, i, total))


def _contacts(
    world: World, state: State, parts: Parts, total: Loads, before: Loads | None, h: Number
) -> None:
    """Adds the forces and torques of the contacts that act."""
    for number, acts in enumerate(state.acting):
        if not acts:
            continue
        if world.corners[number] is not None:
            _corner(world, state, parts, total, number, h)
        else:
            _sphere(world, state, parts, total, number, before, h)


def _sliders(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the dry friction of sliders. They come last, because a sticking slider balances all
    other forces.
    """
    for slider, side in zip(world.sliders, state.side, strict=True):
        speed = abs(parts.slides_at(slider, state.v[slider.a]))
        force = parts.slider_force(slider, side, speed)
        # A sticking slider balances the component of all other forces along its axis.
        if side == 0:
            force = vec.times(-vec.dot(total.force[slider.a], slider.axis), slider.axis)
        total.force[slider.a] = vec.plus(total.force[slider.a], force)
        total.power -= vec.dot(force, state.v[slider.a])


SOURCES = {
    "links": _links,
    "fields": _fields,
    "pairs": _contacts,
    "lying": carried,
    "tents": pushed_by_fields,
    "walls": pushed_by_walls,
    "joints": turned_at_joints,
    "sliders": _sliders,
}
"""Functions that add loads, by the field of a world from which they come."""


def _add(total: Loads, a: int, b: int, force: Vector, parts: Parts) -> None:
    """Adds a force on body a, and its reaction on body b unless that is the world (-1)."""
    total.force[a] = vec.plus(total.force[a], force)
    if b >= 0:
        total.force[b] = vec.plus(total.force[b], parts.reaction(force))


def meeting(
    world: World, state: State, parts: Parts, number: int
) -> tuple[Vector, Number, Number, Vector]:
    """Normal (3) from i to j, overlap d [m], its rate d' [m/s], and velocity (3) [m/s] of i against
    j, of pair `number`.

    A corner of body i may touch a plane; a sphere may touch a plane or another sphere.
    """
    i, j = world.pairs[number]
    if world.corners[number] is not None:
        # Corner x = r + arm, x' = v + omega x arm; plane through p: d = (x - p) . n, d' = x' . n.
        arm = arm_of(world, state, parts, number)
        plane = world.planes[-1 - j]
        normal = vec.times(-1.0, plane.normal)
        omega = parts.to_space(state.q[i], state.w[i])
        velocity = vec.plus(state.v[i], vec.cross(omega, arm))
        corner = vec.plus(state.r[i], arm)
        depth = vec.dot(vec.minus(corner, plane.point), normal)
        return normal, depth, vec.dot(velocity, normal), velocity
    if j < 0:
        # d = R - distance of the centre from the plane, d' = v . n.
        plane = world.planes[-1 - j]
        normal = vec.times(-1.0, plane.normal)
        distance = -vec.dot(vec.minus(state.r[i], plane.point), normal)
        depth = parts.overlap(world.radius[i], 0.0, distance)
        return normal, depth, vec.dot(state.v[i], normal), state.v[i]
    # d = R_i + R_j - |r_j - r_i|, d' = (v_i - v_j) . n.
    branch = parts.away(state.r[i], state.r[j])
    distance = vec.size(branch)
    normal = vec.times(1.0 / distance, branch)
    relative = vec.minus(state.v[i], state.v[j])
    depth = parts.overlap(world.radius[i], world.radius[j], distance)
    return normal, depth, vec.dot(relative, normal), relative


def arm_of(world: World, state: State, parts: Parts, number: int) -> Vector:
    """The vector (3) [m] from the centre of a body to the corner of a pair, in space axes."""
    i, _ = world.pairs[number]
    corner = world.corners[number]
    assert corner is not None
    return parts.to_space(state.q[i], corner)


def _corner(world: World, state: State, parts: Parts, total: Loads, number: int, h: Number) -> None:
    """Adds force and torque on a corner that presses on a plane: F = -F_n n - mu F_n s/|s|, without
    tangential spring.
    """
    law = world.law
    i, j = world.pairs[number]
    normal, depth, rate, velocity = meeting(world, state, parts, number)
    push = parts.normal_force(law, depth, rate)
    force = vec.times(-push, normal)
    if law.friction > 0:
        slip = parts.slip(velocity, ZERO, normal)
        total.slip[number] = slip
        friction = parts.sliding_friction(law, push, slip, _stopping(world, i, j, h))
        force = vec.plus(force, friction)
        total.power = total.power - vec.dot(friction, slip)
    # The dashpot dissipates the power c d'^2, and friction -f . s.
    total.power += law.damping * rate * rate
    total.force[i] = vec.plus(total.force[i], force)
    # The torque arm x F, in body axes.
    torque = vec.cross(arm_of(world, state, parts, number), force)
    total.torque[i] = vec.plus(total.torque[i], parts.to_body(state.q[i], torque))


def _sphere(
    world: World,
    state: State,
    parts: Parts,
    total: Loads,
    number: int,
    before: Loads | None,
    h: Number,
) -> None:
    """Adds the contact forces and torques of a sphere on a plane or on another sphere, pair
    `number`.

    `before` are the loads at the start of a step of h [s], over which its tangential spring is
    integrated; None without a step, where the spring is that of the state.
    """
    law = world.law
    i, j = world.pairs[number]
    normal, depth, rate, relative = meeting(world, state, parts, number)
    push = parts.normal_force(law, depth, rate)
    # F = -F_n n on body i, with F_n = k d + c d' of the linear law.
    _add(total, i, j, vec.times(-push, normal), parts)
    # The dashpot dissipates the power c d'^2.
    total.power += law.damping * rate * rate
    has_friction = law.friction > 0 and state.pressing[number]
    if not has_friction:
        return
    arms = _arms(world, parts, number, depth, law.slip_shortening)
    # s = v - (v . n) n + (arm_i omega_i + arm_j omega_j) x n.
    slip = parts.slip(relative, _surface_spin(state, parts, arms), normal)
    total.normal[number] = normal
    total.slip[number] = slip
    if law.tangential_stiffness > 0:
        stretch = _stretch(world, state, parts, total, number, before, h, push)
        total.stretch[number] = stretch
        friction = parts.spring_friction(law, stretch)
    else:
        friction = parts.sliding_friction(law, push, slip, _stopping(world, i, j, h))
    _add(total, i, j, friction, parts)
    # Friction and its torques dissipate the power -f . u, where u is the slip computed with the
    # levers of the torque.
    glide = slip
    if law.has_two_levers:
        arms = _arms(world, parts, number, depth, law.torque_shortening)
        glide = parts.slip(relative, _surface_spin(state, parts, arms), normal)
    total.power -= vec.dot(friction, glide)
    # The torque of the tangential force is arm n x F on each body, with the same direction.
    for body, arm in arms.items():
        torque = parts.to_body(state.q[body], parts.torque_on(arm, normal, friction))
        total.torque[body] = vec.plus(total.torque[body], torque)


def _arms(
    world: World, parts: Parts, number: int, depth: Number, shortening: Number
) -> dict[int, Number]:
    """The arm [m] of each body of pair `number` at an overlap `depth` [m]."""
    bodies = [body for body in world.pairs[number] if body >= 0]
    return {body: parts.lever(world.radius[body], depth, shortening) for body in bodies}


def _surface_spin(state: State, parts: Parts, arms: dict[int, Number]) -> Vector:
    """The sum (3) [m/s] of arm omega over the bodies of a contact, with their arms [m]: its cross
    product with the normal is what their rotation adds to the slip.
    """
    spin = ZERO
    for body, arm in arms.items():
        spin = vec.moved(spin, arm, parts.to_space(state.q[body], state.w[body]))
    return spin


def _stretch(
    world: World,
    state: State,
    parts: Parts,
    total: Loads,
    number: int,
    before: Loads | None,
    h: Number,
    push: Number,
) -> Vector:
    """The tangential spring (3) [m] of pair `number`: that of the state, or integrated over a step
    of h [s] from the loads `before`; at Coulomb's limit while the contact slides.
    """
    stretch = state.stretch[number]
    if before is not None:
        stretch = _grown(world, state, parts, total, number, before, h, push)
    if state.sliding[number]:
        return parts.clipped(world.law, stretch, push)
    return stretch


def _grown(
    world: World,
    state: State,
    parts: Parts,
    total: Loads,
    number: int,
    before: Loads,
    h: Number,
    push: Number,
) -> Vector:
    """The tangential spring xi of pair `number` after a step of h [s]: xi' = s, with the slips s of
    `before` and of `total`; `push` is the normal force [N] at the end.
    """
    normal = total.normal[number]
    slip = total.slip[number]
    # Spring and slip of the start are rotated into the tangent plane of the end.
    old_normal = before.normal[number]
    stretch = parts.transported(state.stretch[number], old_normal, normal)
    old_slip = parts.transported(before.slip[number], old_normal, normal)
    # A spring that sticks changes by the slip, xi' = s. So does one at its limit that is shorter
    # than the slip distance of a step, so that it takes the direction of the slip.
    if not state.sliding[number] or not vec.size(stretch) > abs(h) * vec.size(slip):
        return parts.stretched(stretch, old_slip, slip, h)
    # At Coulomb's limit the spring keeps the length of the limit, and only the slip perpendicular
    # to it changes its direction. Its length is the mean of those at the start and at the end.
    stretch = vec.times(0.5, vec.plus(stretch, parts.clipped(world.law, stretch, push)))
    across_spring = _turning(stretch, vec.plus(old_slip, slip), h)
    return parts.stretched(stretch, across_spring(old_slip), across_spring(slip), h)


def _turning(stretch: Vector, slips: Vector, h: Number) -> Callable[[Vector], Vector]:
    """The component of a slip perpendicular to a spring at its limit, as a function of the slip;
    `slips` is the sum of those at both ends of h.

    s - (s . xi) xi/|xi|^2, with xi at the middle of the step: xi + h/4 times the perpendicular
    component of `slips`. With xi at the start the direction of friction would be of first order
    only.
    """

    def across(spring: Vector, slip: Vector) -> Vector:
        return vec.moved(slip, -vec.dot(slip, spring) / vec.dot(spring, spring), spring)

    middle = vec.moved(stretch, h / 4, across(stretch, slips))
    return lambda slip: across(middle, slip)


def _stopping(world: World, i: int, j: int, h: Number) -> Number:
    """The factor m_t/|h| [kg/s]: friction m_t |s|/|h| would stop the slip s of solid spheres within
    one step. It is larger than any force without a step, h = 0.
    """
    # 1/m_t = sum of 1/m + R^2/J = (1 + 5/2)/m over the bodies: J = (2/5) m R^2.
    inverse_mass = sum(3.5 / world.mass[body] for body in (i, j) if body >= 0)
    if h:
        return 1.0 / (abs(h) * inverse_mass)
    # A number larger than any force over a speed, in this precision.
    if world.number is float:
        return world.number(1e300)
    return world.number(1e30)
