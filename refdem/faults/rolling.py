"""A rigid sphere that lies on a plane in the transparent engine, and slides or rolls.

Notation: n is the unit normal into the plane, s the slip of the point of contact, F friction, N the
normal force of the plane. The direction of the slip belongs to the mode. `State.stretch`, which for
other laws is the tangential spring, holds it as a unit vector; it is 0 while the sphere rolls.
"""

from typing import Any

from refdem.faults.parts import Moving, Parts, RollingParts
from refdem.faults.positional import force_of_fields
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Vector
from refdem.scene.elements.contact import Contact

NEAR = {True: 1e-12, False: 1e-5}
"""Part of its speeds that rounding in double (True) or single precision may leave of a slip."""


def pressing(force: Vector, normal: Vector) -> Number:
    """N = F_other . n [N], which balances the other forces normal to the plane."""
    return vec.dot(force, normal)


def rubbing(law: Contact, force: Number, direction: Vector) -> Vector:
    """F = -mu N s/|s| [N], with the unit `direction` s/|s|."""
    return vec.times(-law.friction * force, direction)


def holding(along: Vector, inverse_mass: Number, turn: Number) -> Vector:
    """F [N] with which the slip stays 0 while the force `along` [N] acts at the centre.

    s' = (along + F)/m + F R^2/J = 0, so that F = -along (1/m)/(1/m + R^2/J); `inverse_mass` is 1/m,
    `turn` R^2/J.
    """
    return vec.times(-inverse_mass / (inverse_mass + turn), along)


def grips(law: Contact, force: Number, needed: Number) -> bool:
    """True if rolling needs a friction of at most mu N [N]; `force` is N."""
    return bool(needed <= law.friction * force)


def slips_on(slip: Vector, direction: Vector) -> Number:
    """The slip [m/s] along its initial direction, negative after the slip has ended."""
    return vec.dot(slip, direction)


CORRECT_ROLLING = RollingParts(
    pressing=pressing, rubbing=rubbing, holding=holding, grips=grips, slips_on=slips_on
)


def normal_of(world: World, number: int) -> Vector:
    """The unit normal n (3) from the sphere into the plane."""
    _, j = world.pairs[number]
    into: Vector = vec.times(-1.0, world.planes[-1 - j].normal)
    return into


def slip_of(world: World, state: State, parts: Parts, number: int) -> Vector:
    """The velocity (3) [m/s] of the point of contact: v - (v . n) n + R omega x n."""
    i, _ = world.pairs[number]
    spin = vec.times(world.radius[i], parts.to_space(state.q[i], state.w[i]))
    return parts.slip(state.v[i], spin, normal_of(world, number))


def needed_of(
    world: World, parts: Parts, number: int, force: Vector
) -> tuple[Number, Vector, Vector]:
    """N, the other forces along the plane, and the friction that rolling requires [N]."""
    i, _ = world.pairs[number]
    normal = normal_of(world, number)
    push = parts.rolling.pressing(force, normal)
    along = vec.moved(force, -vec.dot(force, normal), normal)
    radius = world.radius[i]
    # R^2/J.
    turn = radius * radius / world.inertia[i][0]
    return push, along, parts.rolling.holding(along, 1 / world.mass[i], turn)


def carried(world: World, state: State, parts: Parts, total: Loads, *others: Any) -> None:
    """Adds the normal force, friction and its torque of the plane on a sphere that lies on it."""
    for number in world.lying:
        i, _ = world.pairs[number]
        normal = normal_of(world, number)
        push, _, needed = needed_of(world, parts, number, total.force[i])
        total.slip[number] = slip_of(world, state, parts, number)
        if state.sliding[number]:
            friction = parts.rolling.rubbing(world.law, push, state.stretch[number])
            total.power -= vec.dot(friction, total.slip[number])
        else:
            friction = needed
        # The plane balances the normal component of all other forces, whatever N a faulty part of
        # the friction uses.
        support = vec.times(-vec.dot(total.force[i], normal), normal)
        total.force[i] = vec.plus(total.force[i], vec.plus(support, friction))
        # R n x F of the friction F.
        torque = parts.torque_on(world.radius[i], normal, friction)
        total.torque[i] = vec.plus(total.torque[i], parts.to_body(state.q[i], torque))


def first_mode(motion: Moving, state: State, number: int) -> None:
    """Sets the mode at the start: the sphere slides if the point of contact slips, or if rolling
    needs more than Coulomb's limit.
    """
    i, _ = motion.world.pairs[number]
    slip = slip_of(motion.world, state, motion.parts, number)
    speeds = vec.size(state.v[i]) + motion.world.radius[i] * vec.size(state.w[i])
    if vec.size(slip) > NEAR[motion.world.number is float] * speeds:
        state.sliding[number] = True
        state.stretch[number] = vec.times(1 / vec.size(slip), slip)
    else:
        _released(motion, state, number)


def margin(motion: Moving, state: State, number: int) -> Number:
    """The guard of sliding, s along its initial direction [m/s]; 1 for a sphere that rolls, whose
    mode does not end.
    """
    if not state.sliding[number]:
        return 1.0
    slip = slip_of(motion.world, state, motion.parts, number)
    return motion.parts.rolling.slips_on(slip, state.stretch[number])


def ended(motion: Moving, state: State, number: int) -> None:
    """Sets the mode after the end of the slip: the sphere rolls, or slides on down the slope."""
    i, _ = motion.world.pairs[number]
    _released(motion, state, number)
    if not state.sliding[number]:
        motion.events.append((state.t, "stick", i))


def _released(motion: Moving, state: State, number: int) -> None:
    """Sets the mode of a sphere whose point of contact is at rest."""
    i, _ = motion.world.pairs[number]
    weight = force_of_fields(motion.world, state, motion.parts, i)
    push, along, needed = needed_of(motion.world, motion.parts, number, weight)
    size = vec.size(needed)
    if motion.parts.rolling.grips(
        motion.world.law, push * (1 + NEAR[motion.world.number is float]), size
    ):
        state.sliding[number] = False
        state.stretch[number] = vec.ZERO
    else:
        state.sliding[number] = True
        state.stretch[number] = vec.times(1 / vec.size(along), along)
