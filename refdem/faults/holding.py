"""Constraints of the transparent engine: rods, hooks that catch, strings over wheels without
radius, and bodies on ball joints.
"""

from typing import Any

from refdem.faults.parts import HoldingParts, Moving, Parts
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Vector
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.string_over_wheel import StringOverWheel

SWEEPS = 60
"""Largest number of sweeps over rods and strings. Rods that share a body are coupled, so that one
sweep satisfies them only in part; a chain of a few rods reaches ENOUGH in far fewer sweeps.
"""
ENOUGH = {True: 2e-16, False: 1e-7}
"""Residual, relative to lengths and speeds, at which sweeps end in double (True) or single
precision.
"""
NEAR = {True: 1e-9, False: 1e-5}
"""Relative rounding of a hook's reach in double (True) or single precision."""


def line_caught(hook: Catch, distance: Number, near: float) -> Number:
    """Length [m] of the line between hook and body at closest approach; 0 beyond the hook's
    reach.
    """
    if distance <= hook.radius * (1 + near):
        return distance
    return 0.0


def string_excess(string: StringOverWheel, length: Number, now: Number) -> Number:
    """The excess [m] of the sum `now` of the distances of both bodies from the wheel over the
    length of the string.
    """
    return now - length


def string_speed(string: StringOverWheel, out_a: Number, out_b: Number) -> Number:
    """Rate [m/s] of the sum of the distances of both bodies from the wheel."""
    return out_a + out_b


def tip_torque(arm: Vector, force: Vector) -> Vector:
    """Torque [N m] about the joint of a force at the centre of mass, `arm` [m] from it."""
    return vec.cross(arm, force)


CORRECT_HOLDING = HoldingParts(
    line_caught=line_caught,
    string_excess=string_excess,
    string_speed=string_speed,
    tip_torque=tip_torque,
)


def turned_at_joints(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the torques arm x F of all forces on bodies about their joints."""
    for joint in world.joints:
        i = joint.a
        arm = vec.times(-1.0, parts.to_space(state.q[i], joint.anchor_a))
        torque = parts.holding.tip_torque(arm, total.force[i])
        total.torque[i] = vec.plus(total.torque[i], parts.to_body(state.q[i], torque))


def follow(motion: Moving, state: State) -> State:
    """The state with positions and velocities of jointed bodies from their attitudes: r = joint +
    arm, v = omega x arm.
    """
    if motion.world.joints:
        state.r = list(state.r)
        state.v = list(state.v)
    for joint in motion.world.joints:
        i = joint.a
        arm = vec.times(-1.0, motion.parts.to_space(state.q[i], joint.anchor_a))
        omega = motion.parts.to_space(state.q[i], state.w[i])
        state.r[i] = vec.plus(joint.anchor_b, arm)
        # v = omega x arm
        state.v[i] = vec.cross(omega, arm)
    return state


def rods_of(world: World, state: State) -> list[Rod]:
    """Rods, and the lines to hooks that have caught a body."""
    if world.hooks:
        return [*world.rods, *(line for line in state.caught if line is not None)]
    return world.rods


def _ends(motion: Moving, rod: Rod, state: State) -> tuple[Vector, Vector, Number]:
    """The branch vector r_a - r_b [m] of a rod, its rate [m/s], and 1/m_a + 1/m_b [1/kg]: the
    change of that rate by a unit impulse. The world has an infinite mass.
    """
    a = rod.a
    b = rod.b
    if b < 0:
        return vec.minus(state.r[a], rod.anchor_b), state.v[a], 1.0 / motion.world.mass[a]
    inverse_mass = 1.0 / motion.world.mass[a] + 1.0 / motion.world.mass[b]
    branch = vec.minus(state.r[a], state.r[b])
    relative = vec.minus(state.v[a], state.v[b])
    return branch, relative, inverse_mass


def _pull(motion: Moving, rod: Rod, state: State, along: Vector, amount: Number) -> None:
    """Adds an impulse P = amount along to end b of a rod and its opposite to end a: v -= P/m_a, v
    += P/m_b.
    """
    a = rod.a
    b = rod.b
    state.v[a] = vec.moved(state.v[a], -amount / motion.world.mass[a], along)
    if b >= 0:
        reaction = motion.parts.reaction(vec.times(-amount, along))
        state.v[b] = vec.moved(state.v[b], 1.0 / motion.world.mass[b], reaction)


def _sides(string: StringOverWheel, r: list[Vector]) -> list[tuple[int, Vector, Number]]:
    """The two bodies of a string, their directions from the wheel and their distances."""
    sides = []
    for i in (string.a, string.b):
        branch = vec.minus(r[i], string.centre)
        distance = vec.size(branch)
        sides.append((i, vec.times(1.0 / distance, branch), distance))
    return sides


def _haul(
    motion: Moving, state: State, sides: list[tuple[int, Vector, Number]], amount: Number
) -> None:
    """Adds the impulse `amount` [N s] of a string on both bodies, towards the wheel."""
    for i, direction, _ in sides:
        state.v[i] = vec.moved(state.v[i], -amount / motion.world.mass[i], direction)


def _hold_string(
    motion: Moving, string: StringOverWheel, length: Number, state: State, sides: Any, h: Number
) -> Number:
    """Makes one Newton step for a string's length at the end of a drift of h, and returns the
    excess of the length before it [m].

    With the directions n_i from the wheel to the bodies at the start and n_i' at the end, an
    impulse P reduces the length by h P sum n_i . n_i'/m_i.
    """
    # P = excess/(h sum n_i . n_i'/m_i).
    drifted = [vec.moved(r, h, v) for r, v in zip(state.r, state.v, strict=True)]
    reached = _sides(string, drifted)
    reached_length = sum(distance for _, _, distance in reached)
    excess = motion.parts.holding.string_excess(string, length, reached_length)
    inverse_mass = 0.0
    for (i, old, _), (_, new, _) in zip(sides, reached, strict=True):
        inverse_mass = inverse_mass + vec.dot(old, new) / motion.world.mass[i]
    _haul(motion, state, sides, excess / (h * inverse_mass))
    return excess


def hold_length(motion: Moving, before: State, state: State, h: Number) -> State:
    """Velocities with which a drift of h ends at the lengths of rods and strings (RATTLE, Andersen
    1983).

    Impulses act along the rods of the start (`before`). One Newton step for each rod makes the
    length at the end of the drift correct to first order; sweeps over all rods are repeated until
    every length is correct.
    """
    if not motion.tied:
        return state
    # For each rod its vector at the start, its vector before the drift, and 1/m_a + 1/m_b: impulses
    # change velocities alone, so that sweeps share them.
    rods = []
    for rod in rods_of(motion.world, before):
        along, _, inverse_mass = _ends(motion, rod, before)
        rods.append((rod, along, rod.branch(state.r), inverse_mass))
    rod_position = motion.parts.rod_position
    enough = ENOUGH[motion.world.number is float]
    strings = [(string, _sides(string, before.r)) for string in motion.world.strings]
    for _ in range(SWEEPS):
        largest = 0.0
        for rod, along, branch, inverse_mass in rods:
            # The branch vector at the end of the drift, with the velocities so far.
            reached = vec.moved(branch, h, rod.approach(state.v))
            amount = rod_position(rod, reached, along, inverse_mass) / h
            _pull(motion, rod, state, along, amount)
            # The error of the length before this step, relative to the length.
            largest = max(largest, abs(amount * h * inverse_mass))
        for (string, sides), length in zip(strings, motion.world.string_lengths, strict=True):
            largest = max(
                largest, abs(_hold_string(motion, string, length, state, sides, h)) / length
            )
        if largest <= enough:
            break
    return state


def hold_speed(motion: Moving, state: State) -> State:
    """The state without velocities along rods and strings, and with v = omega x arm on joints."""
    if not motion.tied:
        return state
    rods = rods_of(motion.world, state)
    # A single rod needs one sweep; several rods are coupled.
    sweeps = len(rods)
    if len(rods) > 1:
        sweeps = SWEEPS
    # Impulses change velocities alone, so that sweeps share vectors and 1/m_a + 1/m_b.
    held = []
    for rod in rods:
        branch, _, inverse_mass = _ends(motion, rod, state)
        held.append((rod, branch, inverse_mass))
    enough = ENOUGH[motion.world.number is float]
    rod_velocity = motion.parts.rod_velocity
    for _ in range(sweeps):
        largest = 0.0
        for rod, branch, inverse_mass in held:
            relative = rod.approach(state.v)
            amount = rod_velocity(rod, branch, relative, inverse_mass)
            _pull(motion, rod, state, branch, amount)
            # The velocity along the rod that this sweep removed, relative to the speed, or in m/s
            # for a rod at rest.
            speed = vec.size(relative)
            if speed == 0:
                speed = 1.0
            largest = max(largest, abs(amount) * inverse_mass * rod.length / speed)
        if largest <= enough:
            break
    for string in motion.world.strings:
        sides = _sides(string, state.r)
        out_a, out_b = (vec.dot(state.v[i], direction) for i, direction, _ in sides)
        # An impulse P reduces the rate of the length by P (1/m_a + 1/m_b).
        speed = motion.parts.holding.string_speed(string, out_a, out_b)
        inverse_mass = sum(1.0 / motion.world.mass[i] for i, _, _ in sides)
        _haul(motion, state, sides, speed / inverse_mass)
    return follow(motion, state)


def rod_forces(motion: Moving, state: State) -> list[Number]:
    """Force [N] in every rod that ends at the world."""
    load = motion.parts.loads(motion.world, state, motion.parts)
    forces = []
    for rod in motion.world.rods:
        branch, relative, inverse_mass = _ends(motion, rod, state)
        acceleration = vec.times(1.0 / motion.world.mass[rod.a], load.force[rod.a])
        forces.append(motion.parts.rod_tension(rod, branch, relative, acceleration, inverse_mass))
    return forces


def margins(
    world: World, before: State, after: State, h: Number
) -> list[tuple[Number, tuple[str, int]]]:
    """Guards -r . v of bodies that approach a hook; negative after closest approach."""
    distances = []
    for number, hook in enumerate(world.hooks):
        was = _leaving(hook, before) * h
        now = _leaving(hook, after) * h
        if before.caught[number] is None and was < 0:
            distances.append((-now, ("catch", number)))
    return distances


def _leaving(hook: Catch, state: State) -> Number:
    """r . v [m^2/s] of a body against a hook: negative until closest approach."""
    return vec.dot(vec.minus(state.r[hook.a], hook.anchor_b), state.v[hook.a])


def catch(motion: Moving, state: State, number: int) -> None:
    """Joins a body to a hook by a line, at closest approach, if it is within reach."""
    hook = motion.world.hooks[number]
    distance = vec.size(vec.minus(state.r[hook.a], hook.anchor_b))
    length = motion.parts.holding.line_caught(hook, distance, NEAR[motion.world.number is float])
    if length > 0:
        state.caught = list(state.caught)
        state.caught[number] = Rod(a=hook.a, length=length, anchor_b=hook.anchor_b)
