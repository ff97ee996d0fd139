"""Impacts of the rigid law in the transparent engine: of spheres with friction, and of a corner on
a plane without friction.

Notation: n is the unit normal from body i to body j or a plane, c the closing speed, s the slip of
the surfaces in contact. Body i gets the impulse -p n - k s.
"""

from refdem.faults.loads import arm_of, meeting
from refdem.faults.parts import ImpactParts, Moving
from refdem.faults.state import State
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Vector
from refdem.scene.elements.contact import Contact


def normal_impulse(law: Contact, inverse_mass: Number, closing: Number) -> Number:
    """p = (1 + e) c/(1/m_i + 1/m_j) [N s]; `inverse_mass` is 1/m_i + 1/m_j."""
    return (1 + law.restitution) * closing / inverse_mass


def tangential_ease(inverse_mass: Number, turn_i: Number, turn_j: Number) -> Number:
    """1/m_t = 1/m_i + 1/m_j + R_i^2/J_i + R_j^2/J_j [1/kg]; `turn_i` is R_i^2/J_i."""
    return inverse_mass + turn_i + turn_j


def tangential_impulse(
    law: Contact, inverse_mass: Number, slip: Vector, pressing: Number
) -> Vector:
    """The impulse [N s] on body i across the normal: (1 + b) m_t |s| against the slip, at most mu
    p. `inverse_mass` is 1/m_t, `pressing` p.
    """
    # -min((1 + b) m_t, mu p/|s|) s.
    factor = (1 + law.slip_restitution) / inverse_mass
    speed = vec.size(slip)
    limit = law.friction * pressing
    if factor * speed > limit:
        factor = limit / speed
    return vec.times(-factor, slip)


def corner_ease(inverse_mass: Number, lever: Vector, inertia: Vector) -> Number:
    """1/m + (r x n) . J^-1 (r x n) [1/kg] of a corner; `lever` is r x n in body axes."""
    return inverse_mass + vec.dot(lever, vec.over_axis(lever, inertia))


def corner_torque(arm: Vector, impulse: Vector) -> Vector:
    """The change r x P of the angular momentum [N m s] by an impulse at a corner."""
    return vec.cross(arm, impulse)


def meets(closing: Number) -> bool:
    """True if spheres that touch collide, because they close."""
    return bool(closing > 0)


CORRECT_IMPACTS = ImpactParts(
    normal_impulse=normal_impulse,
    tangential_ease=tangential_ease,
    tangential_impulse=tangential_impulse,
    corner_ease=corner_ease,
    corner_torque=corner_torque,
    meets=meets,
)

AS_DEEP = 1e-4
"""Relative difference of the depths of corners of one edge, by rounding in single precision."""
APART = 1.0
"""Guard of a pair that does not close; any positive number."""


def margin(motion: Moving, state: State, number: int, h: Number) -> Number:
    """The guard of a pair: its gap [m] if it closes, below 0 after the impact."""
    _, depth, rate, _ = meeting(motion.world, state, motion.parts, number)
    if motion.parts.impacts.meets(rate * h):
        return -depth
    return APART


def struck(motion: Moving, state: State, number: int) -> None:
    """Applies the impact of pair `number`: changes velocities and spins, and adds the energy lost.

    Body i gets the impulse P = -p n - k s, body j its reaction; the slip is s = v - (v . n) n +
    (R_i omega_i + R_j omega_j) x n. A plane (j < 0) does not move.
    """
    parts = motion.parts
    world = motion.world
    law = world.law
    if world.corners[number] is not None:
        _struck_at_corner(motion, state, number)
        return
    i, j = world.pairs[number]
    normal, _, closing, relative = meeting(world, state, parts, number)
    # 1/m_i + 1/m_j, R_i^2/J_i and R_j^2/J_j, and R_i omega_i + R_j omega_j.
    inverse_mass = 1 / world.mass[i]
    turns = [_turn_ease(motion, i), 0.0]
    spin = vec.times(world.radius[i], parts.to_space(state.q[i], state.w[i]))
    if j >= 0:
        inverse_mass = inverse_mass + 1 / world.mass[j]
        turns[1] = _turn_ease(motion, j)
        spin = vec.moved(spin, world.radius[j], parts.to_space(state.q[j], state.w[j]))
    slip = parts.slip(relative, spin, normal)
    pressing = parts.impacts.normal_impulse(law, inverse_mass, closing)
    tangential_inverse_mass = parts.impacts.tangential_ease(inverse_mass, turns[0], turns[1])
    rubbing = parts.impacts.tangential_impulse(law, tangential_inverse_mass, slip, pressing)
    # P = -p n - k s, `rubbing` being -k s.
    impulse = vec.moved(rubbing, -pressing, normal)
    before = _energy(motion, state, i) + _energy(motion, state, j)
    _push(motion, state, i, normal, impulse, rubbing)
    if j >= 0:
        _push(motion, state, j, normal, parts.reaction(impulse), rubbing)
    # The dissipated work is the loss of kinetic energy.
    state.work = state.work + before - _energy(motion, state, i) - _energy(motion, state, j)
    motion.events.append((state.t, "contact", i))


def _struck_at_corner(motion: Moving, state: State, number: int) -> None:
    """Applies the impact of a corner and a plane: v += P/m, J omega += r x P with P = -p n.

    Corners at equal depth belong to one edge, and the impulse acts at its middle. The second of
    them does not close any more. In steps back in time the closing velocity has the opposite sign.
    """
    parts = motion.parts
    world = motion.world
    i, _ = world.pairs[number]
    normal, depth, closing, _ = meeting(world, state, parts, number)
    if not parts.impacts.meets(closing * motion.sense):
        return
    arms = []
    for other, pair in enumerate(world.pairs):
        _, other_depth, _, _ = meeting(world, state, parts, other)
        arm = arm_of(world, state, parts, other)
        if pair == world.pairs[number] and abs(other_depth - depth) < AS_DEEP * vec.size(arm):
            arms.append(arm)
    # The mean of the arms of all corners of the edge.
    arm = vec.ZERO
    for each in arms:
        arm = vec.moved(arm, 1 / len(arms), each)
    # p = (1 + e) c/(1/m + (r x n) . J^-1 (r x n)).
    lever = parts.to_body(state.q[i], vec.cross(arm, normal))
    inverse_mass = parts.impacts.corner_ease(1 / world.mass[i], lever, world.inertia[i])
    pressing = parts.impacts.normal_impulse(world.law, inverse_mass, closing)
    impulse = vec.times(-pressing, normal)
    before = _energy(motion, state, i)
    state.v[i] = parts.kicked(state.v[i], impulse, world.mass[i], 1.0)
    turning = parts.to_body(state.q[i], parts.impacts.corner_torque(arm, impulse))
    state.w[i] = parts.spun_up(state.w[i], turning, world.inertia[i], 1.0)
    state.work = state.work + before - _energy(motion, state, i)
    motion.events.append((state.t, "contact", i))


def _turn_ease(motion: Moving, i: int) -> Number:
    """R^2/J [1/kg] of a sphere."""
    return motion.world.radius[i] * motion.world.radius[i] / motion.world.inertia[i][0]


def _push(
    motion: Moving, state: State, i: int, normal: Vector, impulse: Vector, rubbing: Vector
) -> None:
    """Adds an impulse to a sphere: v += P/m, J omega += R n x P_t. The torque has the same
    direction on both bodies.
    """
    state.v[i] = motion.parts.kicked(state.v[i], impulse, motion.world.mass[i], 1.0)
    torque = motion.parts.torque_on(motion.world.radius[i], normal, rubbing)
    turning = motion.parts.to_body(state.q[i], torque)
    state.w[i] = motion.parts.spun_up(state.w[i], turning, motion.world.inertia[i], 1.0)


def _energy(motion: Moving, state: State, i: int) -> Number:
    """Kinetic energy [J] of a sphere; 0 of a plane."""
    if i < 0:
        return 0.0
    # (m v^2 + omega . J omega)/2, in body axes.
    moving = motion.world.mass[i] * vec.dot(state.v[i], state.v[i])
    turning = vec.dot(vec.per_axis(motion.world.inertia[i], state.w[i]), state.w[i])
    return (moving + turning) / 2
