"""Methods of the transparent engine: one step each, in the verbs kick, drift, hold."""

from typing import TYPE_CHECKING

from refdem.faults import vectors as vec
from refdem.faults.holding import follow, hold_length, hold_speed
from refdem.faults.loads import Loads
from refdem.faults.vectors import Number, Vector
from refdem.faults.world import State, World

if TYPE_CHECKING:
    from refdem.faults.parts import Parts


class Moving:
    """A world, the parts that move it, and the events so far: time, kind, body."""

    def __init__(self, world: World, parts: "Parts") -> None:
        self.world = world
        self.parts = parts
        self.told: list[tuple[float, str, int]] = []
        self.turning = [i for i, turns in enumerate(world.turns) if turns and not world.fixed[i]]
        jointed = {joint.a for joint in world.joints}
        self.free = [i for i, fixed in enumerate(world.fixed) if not fixed and i not in jointed]
        self.tied = bool(world.rods or world.hooks or world.strings or world.joints)
        self.depends_on_velocity = bool(
            world.dashpots
            or any(s.law != "coulomb" for s in world.sliders)
            or (world.pairs and (world.law.damping > 0 or world.law.friction > 0))
        )
        self.reads_velocity = self.depends_on_velocity or bool(world.drives or not world.is_smooth)


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
            q[i] = m.parts.unit(m.parts.turned(q[i], w[i], h))
            continue
        spin = w[i]
        attitude = q[i]
        for axis, part in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
            spin, attitude = m.parts.axis_turn(axis, inertia, spin, attitude, part * h)
        w[i], q[i] = spin, m.parts.unit(attitude)
    moved = state.moved(r, v, q, w, state.t + float(h))
    if m.tied:
        return follow(m, moved)
    return moved


def verlet(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift, kick (Swope et al. 1982); with rods RATTLE (Andersen 1983); one correction where
    forces depend on velocity.
    """
    first, second = m.parts.verlet_kicks
    moved = drift(m, hold_length(m, state, kick(m, state, load, first * h), h), h)
    moved.work = state.work + 0.5 * h * load.power
    if m.reads_velocity:
        guess = kick(m, moved, load, second * h)
    else:
        guess = moved
    after = m.parts.loads(m.world, guess, m.parts, load, h)
    if m.depends_on_velocity:
        after = m.parts.loads(m.world, kick(m, moved, after, second * h), m.parts, load, h)
    ended = hold_speed(m, kick(m, moved, after, second * h))
    if m.world.sliders:
        after = m.parts.loads(m.world, ended, m.parts, load, h)
    ended.stretch = after.stretch
    ended.work = moved.work + 0.5 * h * after.power
    return ended, after


def euler(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Kick, drift: first order; gyroscopic term explicit."""
    moved = kick(m, state, load, h)
    moved.r, moved.q, moved.w, moved.t = (
        list(moved.r),
        list(moved.q),
        list(moved.w),
        state.t + float(h),
    )
    for i in m.turning:
        moved.w[i] = m.parts.spun_up(
            moved.w[i], m.parts.gyroscopic(m.world.inertia[i], moved.w[i]), m.world.inertia[i], h
        )
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
    moved.r, moved.t = r, state.t + float(h)
    return moved, m.parts.loads(m.world, moved, m.parts, load, h)


def suzuki(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """Five steps of Verlet: order 4 (Suzuki 1990)."""
    for part in m.parts.suzuki:
        state, load = verlet(m, state, load, part * h)
    return state, load


Rates = tuple[list[Vector], list[Vector], list[vec.Quaternion], list[Vector]]


def rates(m: Moving, state: State) -> Rates:
    """r', v', q', omega_body' of every body."""
    load = m.parts.loads(m.world, state, m.parts)
    parts = m.parts
    bodies = range(len(m.world.mass))

    def spun(i: int) -> Vector:
        torque = vec.plus(parts.gyroscopic(m.world.inertia[i], state.w[i]), load.torque[i])
        rate: Vector = parts.spun_up(vec.ZERO, torque, m.world.inertia[i], 1.0)
        return rate

    still = (0.0, 0.0, 0.0, 0.0)
    return (
        [state.v[i] for i in bodies],
        [parts.kicked(vec.ZERO, load.force[i], m.world.mass[i], 1.0) for i in bodies],
        [parts.turn_rate(state.q[i], state.w[i]) if m.world.turns[i] else still for i in bodies],
        [spun(i) if m.world.turns[i] else vec.ZERO for i in bodies],
    )


def onward(state: State, rate: Rates, h: Number) -> State:
    """The state after h at constant rates."""
    r = [vec.moved(place, h, by) for place, by in zip(state.r, rate[0], strict=True)]
    v = [vec.moved(velocity, h, by) for velocity, by in zip(state.v, rate[1], strict=True)]
    q: list[vec.Quaternion] = [
        (w + h * a, x + h * b, y + h * c, z + h * d)
        for (w, x, y, z), (a, b, c, d) in zip(state.q, rate[2], strict=True)
    ]
    w = [vec.moved(omega, h, by) for omega, by in zip(state.w, rate[3], strict=True)]
    return state.moved(r, v, q, w, state.t + float(h))


def rk4(m: Moving, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """The classical method of order 4 (Kutta 1901)."""
    stages = [rates(m, state)]
    for node in m.parts.rk4_nodes:
        stages.append(rates(m, onward(state, stages[-1], node * h)))
    for rate, weight in zip(stages, m.parts.rk4_weights, strict=True):
        state = onward(state, rate, weight * h)
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
