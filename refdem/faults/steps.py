"""Methods of the transparent engine: one step each, in the verbs kick, drift, hold.

Notation: r, v position and velocity, q attitude, w omega in body axes, h the step [s].

kick: v += h F/m, w += h J^-1 torque. drift: r += h v, and rotation of a free body for h. hold:
impulses of constraints.
"""

from typing import NamedTuple

from refdem.faults.holding import follow, hold_length, hold_speed
from refdem.faults.parts import Moving
from refdem.faults.state import Loads, State
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Quaternion, Vector


def kick(motion: Moving, state: State, load: Loads, h: Number) -> State:
    """The state after the loads have acted for h, with new lists of velocities."""
    # v+ = v + h F/m, w+ = w + h J^-1 torque.
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
    """The state after free motion for h: r + h v, and the rotation of a free body."""
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
            # Equal moments: omega is constant, q+ = q exp(w h/2).
            q[i] = motion.parts.unit(motion.parts.turned(q[i], w[i], h))
            continue
        spin = w[i]
        attitude = q[i]
        # T = L_1^2/(2 J_1) + L_2^2/(2 J_2) + L_3^2/(2 J_3). The flow of each term is a rotation
        # about one principal axis; their symmetric composition has order 2 (McLachlan 1993).
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
    # v' = v + h/2 F(r)/m, r+ = r + h v', v+ = v' + h/2 F(r+)/m, and alike for omega and attitude.
    first, second = motion.parts.verlet_kicks
    kicked = kick(motion, state, load, first * h)
    held = hold_length(motion, state, kicked, h)
    moved = drift(motion, held, h)
    # Dissipated work by the trapezoidal rule, W+ = W + h/2 (P + P+); the second half is added
    # below.
    moved.work = state.work + 0.5 * h * load.power
    if motion.reads_velocity:
        guess = kick(motion, moved, load, second * h)
    else:
        guess = moved
    # Loads at the end of the step. If they depend on the velocity there, which is known only after
    # the last kick, they are evaluated at the velocity v' + h/2 F(r)/m predicted from the start ...
    after = motion.parts.loads(motion.world, guess, motion.parts, load, h)
    if motion.depends_on_velocity:
        # ... and again at the velocity that results.
        after = motion.parts.loads(
            motion.world, kick(motion, moved, after, second * h), motion.parts, load, h
        )
    ended = hold_speed(motion, kick(motion, moved, after, second * h))
    if motion.world.sliders:
        # A sticking slider balances the loads at the final velocity.
        after = motion.parts.loads(motion.world, ended, motion.parts, load, h)
    ended.stretch = after.stretch
    ended.work = moved.work + 0.5 * h * after.power
    return ended, after


def euler(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Symplectic Euler, kick then drift: first order; gyroscopic term explicit."""
    # v+ = v + h F(r)/m, r+ = r + h v+.
    kicked = kick(motion, state, load, h)
    spun = list(kicked.w)
    for i in motion.turning:
        # w+ = w + h J^-1 (-w x J w), with w after the kick by the torques.
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
    """The other symplectic Euler method, drift then kick: first order."""
    # r+ = r + h v, v+ = v + h F(r+)/m.
    r = list(state.r)
    for i in motion.free:
        r[i] = motion.parts.drifted(r[i], state.v[i], h)
    moved = state.moved(r, state.v, state.q, state.w, state.t + float(h))
    after = motion.parts.loads(motion.world, moved, motion.parts, load, h)
    return kick(motion, moved, after, h), after


def explicit(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Explicit Euler, with the velocity and force of the start: first order, energy grows."""
    # r+ = r + h v, v+ = v + h F(r)/m.
    moved = kick(motion, state, load, h)
    r = list(state.r)
    for i in motion.free:
        r[i] = motion.parts.drifted(r[i], state.v[i], h)
    moved.r = r
    moved.t = state.t + float(h)
    return moved, motion.parts.loads(motion.world, moved, motion.parts, load, h)


def suzuki(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Five steps of Verlet's method: order 4 (Suzuki 1990)."""
    # Lengths s4 h, s4 h, (1 - 4 s4) h, s4 h, s4 h with s4 = 1/(4 - 4^(1/3)).
    for part in motion.parts.suzuki:
        state, load = verlet(motion, state, load, part * h)
    return state, load


STILL: Quaternion = (0.0, 0.0, 0.0, 0.0)
"""The rate q' = 0 of a body without moments of inertia."""


class Rates(NamedTuple):
    """The derivatives r', v', q' and omega_body' of every body."""

    r: list[Vector]
    v: list[Vector]
    q: list[Quaternion]
    w: list[Vector]


def rates(motion: Moving, state: State) -> Rates:
    """The derivatives of the state: r' = v, m v' = F, q' = q omega/2, J omega' = J omega x omega +
    torque.
    """
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
    """The state y + h y' with the rates y'."""
    r = [vec.moved(place, h, by) for place, by in zip(state.r, rate.r, strict=True)]
    v = [vec.moved(velocity, h, by) for velocity, by in zip(state.v, rate.v, strict=True)]
    q = [vec.moved_turn(attitude, h, by) for attitude, by in zip(state.q, rate.q, strict=True)]
    w = [vec.moved(omega, h, by) for omega, by in zip(state.w, rate.w, strict=True)]
    return state.moved(r, v, q, w, state.t + float(h))


def rk4(motion: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """The classical method of order 4 (Kutta 1901): y + h sum b_i k_i, k_i = f(y + c_i h k_(i-1)).

    The loads are returned unchanged, because every stage computes its own.
    """
    stages = [rates(motion, state)]
    for node in motion.parts.rk4_nodes:
        stages.append(rates(motion, onward(state, stages[-1], node * h)))
    for rate, weight in zip(stages, motion.parts.rk4_weights, strict=True):
        state = onward(state, rate, weight * h)
    # The method does not conserve |q|; attitudes are normalised once a step.
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
