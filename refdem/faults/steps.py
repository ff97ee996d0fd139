"""Methods of the transparent engine: one step each, in the verbs kick, drift, hold.

Notation: r, v place and velocity, q attitude, w omega in body axes, h the step [s]. kick: v += h
F/m, w += h J^-1 torque. drift: r += h v, q turns as a free body does. hold: impulses of rods.
"""

from typing import NamedTuple

from refdem.faults.holding import follow, hold_length, hold_speed
from refdem.faults.parts import Moving
from refdem.faults.state import Loads, State
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Quaternion, Vector


def kick(motion: Moving, state: State, load: Loads, h: Number) -> State:
    """Velocities after the loads have acted for h; the lists of them are new."""
    kicked = motion.parts.kicked
    v = list(state.v)
    w = state.w
    for i in motion.free:
        v[i] = kicked(v[i], load.force[i], motion.world.mass[i], h)
    if motion.world.pairs or motion.world.joints:
        w = list(w)
        for i in motion.turning:
            w[i] = motion.parts.spun_up(w[i], load.torque[i], motion.world.inertia[i], h)
    return state.moved(state.r, v, state.q, w, state.t)


def drift(motion: Moving, state: State, h: Number) -> State:
    """Positions and attitudes after h: bodies turn as free ones do."""
    r = list(state.r)
    v = state.v
    q = state.q
    w = state.w
    for i in motion.free:
        r[i] = motion.parts.drifted(r[i], v[i], h)
    if motion.turning:
        q = list(q)
        w = list(w)
    for i in motion.turning:
        inertia = motion.world.inertia[i]
        if inertia[0] == inertia[1] == inertia[2]:
            # A sphere turns about a fixed axis: omega is constant.
            q[i] = motion.parts.unit(motion.parts.turned(q[i], w[i], h))
            continue
        spin = w[i]
        attitude = q[i]
        # The kinetic energy L_1^2/2J_1 + L_2^2/2J_2 + L_3^2/2J_3 in its three parts, each of which
        # turns the body about one axis exactly; their symmetric composition is of order 2
        # (McLachlan 1993).
        for axis, part in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
            spin, attitude = motion.parts.axis_turn(axis, inertia, spin, attitude, part * h)
        w[i] = spin
        q[i] = motion.parts.unit(attitude)
    moved = state.moved(r, v, q, w, state.t + float(h))
    if motion.tied:
        return follow(motion, moved)
    return moved


def verlet(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift, kick (Swope et al. 1982); with rods RATTLE (Andersen 1983); one correction where
    forces depend on velocity.
    """
    first, second = motion.parts.verlet_kicks
    kicked = kick(motion, state, load, first * h)
    held = hold_length(motion, state, kicked, h)
    moved = drift(motion, held, h)
    # The lost power by the trapezoidal rule, its second half below.
    moved.work = state.work + 0.5 * h * load.power
    if motion.reads_velocity:
        guess = kick(motion, moved, load, second * h)
    else:
        guess = moved
    # Loads at the end of the step; where they depend on the velocity there, which is not known
    # before the last kick, they are taken at a velocity predicted by the loads of the start ...
    after = motion.parts.loads(motion.world, guess, motion.parts, load, h)
    if motion.depends_on_velocity:
        # ... and once more at the velocity that this kick gives.
        after = motion.parts.loads(
            motion.world, kick(motion, moved, after, second * h), motion.parts, load, h
        )
    ended = hold_speed(motion, kick(motion, moved, after, second * h))
    if motion.world.sliders:
        # A slider that sticks balances the loads of the velocity that was reached.
        after = motion.parts.loads(motion.world, ended, motion.parts, load, h)
    ended.stretch = after.stretch
    ended.work = moved.work + 0.5 * h * after.power
    return ended, after


def euler(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift: first order; gyroscopic term explicit."""
    kicked = kick(motion, state, load, h)
    spun = list(kicked.w)
    for i in motion.turning:
        # w += h J^-1 (-w x J w), with the w that the torques have changed.
        inertia = motion.world.inertia[i]
        torque = motion.parts.gyroscopic(inertia, spun[i])
        spun[i] = motion.parts.spun_up(spun[i], torque, inertia, h)
    moved = kicked.moved(list(kicked.r), kicked.v, list(kicked.q), spun, state.t + float(h))
    moved = hold_length(motion, state, moved, h)
    for i in motion.free:
        moved.r[i] = motion.parts.drifted(moved.r[i], moved.v[i], h)
    for i in motion.turning:
        moved.q[i] = motion.parts.unit(motion.parts.turned(moved.q[i], moved.w[i], h))
    moved = hold_speed(motion, moved)
    after = motion.parts.loads(motion.world, moved, motion.parts, load, h)
    moved.stretch = after.stretch
    moved.work = state.work + h * after.power
    return moved, after


def drift_first(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Drift, kick: the other symplectic Euler method, first order."""
    r = list(state.r)
    for i in motion.free:
        r[i] = motion.parts.drifted(r[i], state.v[i], h)
    moved = state.moved(r, state.v, state.q, state.w, state.t + float(h))
    after = motion.parts.loads(motion.world, moved, motion.parts, load, h)
    return kick(motion, moved, after, h), after


def explicit(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Explicit Euler: drift with the old velocity, kick with the old force; first order, and it
    gains energy.
    """
    moved = kick(motion, state, load, h)
    r = list(state.r)
    for i in motion.free:
        r[i] = motion.parts.drifted(r[i], state.v[i], h)
    moved.r = r
    moved.t = state.t + float(h)
    return moved, motion.parts.loads(motion.world, moved, motion.parts, load, h)


def suzuki(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Five steps of Verlet: order 4 (Suzuki 1990)."""
    for part in motion.parts.suzuki:
        state, load = verlet(motion, state, load, part * h)
    return state, load


STILL: Quaternion = (0.0, 0.0, 0.0, 0.0)
"""q' of a body that has no moments of inertia."""


class Rates(NamedTuple):
    """r', v', q' and omega_body' of every body."""

    r: list[Vector]
    v: list[Vector]
    q: list[Quaternion]
    w: list[Vector]


def rates(motion: Moving, state: State) -> Rates:
    """The rates of the state of every body."""
    parts = motion.parts
    load = parts.loads(motion.world, state, parts)
    derivative = Rates(list(state.v), [], [], [])
    for i, mass in enumerate(motion.world.mass):
        # m v' = F
        derivative.v.append(parts.kicked(vec.ZERO, load.force[i], mass, 1.0))
        if not motion.world.turns[i]:
            derivative.q.append(STILL)
            derivative.w.append(vec.ZERO)
            continue
        derivative.q.append(parts.turn_rate(state.q[i], state.w[i]))
        # J omega' = -omega x J omega + torque
        inertia = motion.world.inertia[i]
        torque = vec.plus(parts.gyroscopic(inertia, state.w[i]), load.torque[i])
        derivative.w.append(parts.spun_up(vec.ZERO, torque, inertia, 1.0))
    return derivative


def onward(state: State, rate: Rates, h: Number) -> State:
    """The state after h at constant rates."""
    r = [vec.moved(place, h, by) for place, by in zip(state.r, rate.r, strict=True)]
    v = [vec.moved(velocity, h, by) for velocity, by in zip(state.v, rate.v, strict=True)]
    q = [vec.moved_turn(attitude, h, by) for attitude, by in zip(state.q, rate.q, strict=True)]
    w = [vec.moved(omega, h, by) for omega, by in zip(state.w, rate.w, strict=True)]
    return state.moved(r, v, q, w, state.t + float(h))


def rk4(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """The classical method of order 4 (Kutta 1901): y + h sum b_i k_i, k_i = f(y + c_i h k_(i-1)).

    The loads are handed through: stages compute their own.
    """
    stages = [rates(motion, state)]
    for node in motion.parts.rk4_nodes:
        stages.append(rates(motion, onward(state, stages[-1], node * h)))
    for rate, weight in zip(stages, motion.parts.rk4_weights, strict=True):
        state = onward(state, rate, weight * h)
    # The method turns no quaternion exactly; its length is put right once a step.
    state.q = [motion.parts.unit(q) for q in state.q]
    return state, load


STEPS = {
    "euler": euler,
    "drift-first": drift_first,
    "explicit-euler": explicit,
    "verlet": verlet,
    "suzuki": suzuki,
    "rk4": rk4,
    "verlet-single": verlet,
}
