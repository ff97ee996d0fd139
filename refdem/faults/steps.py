"""Methods of the transparent engine: one step each, in the verbs kick, drift, hold.

Notation: r, v place and velocity, q attitude, w omega in body axes, h the step [s]. kick: v += h
F/m, w += h J^-1 torque. drift: r += h v, q turns as a free body does. hold: impulses of rods.
"""

from typing import NamedTuple

from refdem.faults import vectors as vec
from refdem.faults.holding import follow, hold_length, hold_speed
from refdem.faults.parts import Moving
from refdem.faults.state import Loads, State
from refdem.faults.vectors import Number, Quaternion, Vector


def kick(m: Moving, state: State, load: Loads, h: Number) -> State:
    """Velocities after the loads have acted for h; the lists of them are new."""
    kicked = m.parts.kicked
    v = list(state.v)
    w = state.w
    for i in m.free:
        v[i] = kicked(v[i], load.force[i], m.world.mass[i], h)
    if m.world.pairs or m.world.joints:
        w = list(w)
        for i in m.turning:
            w[i] = m.parts.spun_up(w[i], load.torque[i], m.world.inertia[i], h)
    return state.moved(state.r, v, state.q, w, state.t)


def drift(m: Moving, state: State, h: Number) -> State:
    """Positions and attitudes after h: bodies turn as free ones do."""
    r = list(state.r)
    v = state.v
    q = state.q
    w = state.w
    for i in m.free:
        r[i] = m.parts.drifted(r[i], v[i], h)
    if m.turning:
        q = list(q)
        w = list(w)
    for i in m.turning:
        inertia = m.world.inertia[i]
        if inertia[0] == inertia[1] == inertia[2]:
            # A sphere turns about a fixed axis: omega is constant.
            q[i] = m.parts.unit(m.parts.turned(q[i], w[i], h))
            continue
        spin = w[i]
        attitude = q[i]
        # The kinetic energy L_1^2/2J_1 + L_2^2/2J_2 + L_3^2/2J_3 in its three parts, each of which
        # turns the body about one axis exactly; their symmetric composition is of order 2
        # (McLachlan 1993).
        for axis, part in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
            spin, attitude = m.parts.axis_turn(axis, inertia, spin, attitude, part * h)
        w[i] = spin
        q[i] = m.parts.unit(attitude)
    moved = state.moved(r, v, q, w, state.t + float(h))
    if m.tied:
        return follow(m, moved)
    return moved


def verlet(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift, kick (Swope et al. 1982); with rods RATTLE (Andersen 1983); one correction where
    forces depend on velocity.
    """
    first, second = m.parts.verlet_kicks
    kicked = kick(m, state, load, first * h)
    held = hold_length(m, state, kicked, h)
    moved = drift(m, held, h)
    # The lost power by the trapezoidal rule, its second half below.
    moved.work = state.work + 0.5 * h * load.power
    if m.reads_velocity:
        guess = kick(m, moved, load, second * h)
    else:
        guess = moved
    # Loads at the end of the step; where they depend on the velocity there, which is not known
    # before the last kick, they are taken at a velocity predicted by the loads of the begin ...
    after = m.parts.loads(m.world, guess, m.parts, load, h)
    if m.depends_on_velocity:
        # ... and once more at the velocity that this kick gives.
        after = m.parts.loads(m.world, kick(m, moved, after, second * h), m.parts, load, h)
    ended = hold_speed(m, kick(m, moved, after, second * h))
    if m.world.sliders:
        # A slider that sticks balances the loads of the velocity that was reached.
        after = m.parts.loads(m.world, ended, m.parts, load, h)
    ended.stretch = after.stretch
    ended.work = moved.work + 0.5 * h * after.power
    return ended, after


def euler(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift: first order; gyroscopic term explicit."""
    kicked = kick(m, state, load, h)
    spun = list(kicked.w)
    for i in m.turning:
        # w += h J^-1 (-w x J w), with the w that the torques have changed.
        inertia = m.world.inertia[i]
        torque = m.parts.gyroscopic(inertia, spun[i])
        spun[i] = m.parts.spun_up(spun[i], torque, inertia, h)
    moved = kicked.moved(list(kicked.r), kicked.v, list(kicked.q), spun, state.t + float(h))
    moved = hold_length(m, state, moved, h)
    for i in m.free:
        moved.r[i] = m.parts.drifted(moved.r[i], moved.v[i], h)
    for i in m.turning:
        moved.q[i] = m.parts.unit(m.parts.turned(moved.q[i], moved.w[i], h))
    moved = hold_speed(m, moved)
    after = m.parts.loads(m.world, moved, m.parts, load, h)
    moved.stretch = after.stretch
    moved.work = state.work + h * after.power
    return moved, after


def drift_first(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Drift, kick: the other symplectic Euler method, first order."""
    r = list(state.r)
    for i in m.free:
        r[i] = m.parts.drifted(r[i], state.v[i], h)
    moved = state.moved(r, state.v, state.q, state.w, state.t + float(h))
    after = m.parts.loads(m.world, moved, m.parts, load, h)
    return kick(m, moved, after, h), after


def explicit(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Explicit Euler: drift with the old velocity, kick with the old force; first order, and it
    gains energy.
    """
    moved = kick(m, state, load, h)
    r = list(state.r)
    for i in m.free:
        r[i] = m.parts.drifted(r[i], state.v[i], h)
    moved.r = r
    moved.t = state.t + float(h)
    return moved, m.parts.loads(m.world, moved, m.parts, load, h)


def suzuki(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Five steps of Verlet: order 4 (Suzuki 1990)."""
    for part in m.parts.suzuki:
        state, load = verlet(m, state, load, part * h)
    return state, load


STILL: Quaternion = (0.0, 0.0, 0.0, 0.0)
"""q' of a body that has no moments of inertia."""


class Rates(NamedTuple):
    """r', v', q' and omega_body' of every body."""

    r: list[Vector]
    v: list[Vector]
    q: list[Quaternion]
    w: list[Vector]


def rates(m: Moving, state: State) -> Rates:
    """The rates of the state of every body."""
    parts = m.parts
    load = parts.loads(m.world, state, parts)
    derivative = Rates(list(state.v), [], [], [])
    for i, mass in enumerate(m.world.mass):
        # m v' = F
        derivative.v.append(parts.kicked(vec.ZERO, load.force[i], mass, 1.0))
        if not m.world.turns[i]:
            derivative.q.append(STILL)
            derivative.w.append(vec.ZERO)
            continue
        derivative.q.append(parts.turn_rate(state.q[i], state.w[i]))
        # J omega' = -omega x J omega + torque
        inertia = m.world.inertia[i]
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


def rk4(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """The classical method of order 4 (Kutta 1901): y + h sum b_i k_i, k_i = f(y + c_i h k_(i-1)).

    The loads are handed through: stages compute their own.
    """
    stages = [rates(m, state)]
    for node in m.parts.rk4_nodes:
        stages.append(rates(m, onward(state, stages[-1], node * h)))
    for rate, weight in zip(stages, m.parts.rk4_weights, strict=True):
        state = onward(state, rate, weight * h)
    # The method turns no quaternion exactly; its length is put right once a step.
    state.q = [m.parts.unit(q) for q in state.q]
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
