"""Steps that are divided at events: a contact begins or ends, friction ends, a slider stops.

Every mode has guards, functions of the state that are positive as long as the mode is valid. An
event is the first zero of a guard within a step.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from refdem.faults import holding, impacts, positional, rolling
from refdem.faults.loads import meeting
from refdem.faults.parts import Moving, Step
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import ZERO, Number, Vector

MOST_EVENTS = 8
"""Largest number of changes of mode in one step. With more of them the modes alternate without end,
as under a faulty rule; the rest of the step is then made without events.
"""


def touch_tolerance(motion: Moving) -> float:
    """Overlap, relative to the radii, of bodies that touch with zero overlap up to rounding."""
    if motion.world.number is float:
        return 1e-12
    return 1e-5


def contact_guards(motion: Moving, state: State, number: int) -> tuple[Number, Number]:
    """The guards of a contact's modes: the first is positive while the contact acts, the second,
    its normal force [N], while it presses.
    """
    law = motion.world.law
    _, depth, rate, _ = meeting(motion.world, state, motion.parts, number)
    push = motion.parts.normal_force(law, depth, rate)
    acts = motion.parts.presses(law, depth, push)
    if motion.world.corners[number] is not None:
        # The contact of a corner ends at zero overlap at the latest, for any cutoff.
        acts = min(acts, law.stiffness * depth)
    return acts, push


def first_modes(motion: Moving, state: State, h: Number) -> None:
    """Sets the modes of the initial state. A pair with zero overlap acts if it closes. A slider at
    rest sticks, or slips in the direction of the other forces.
    """
    for number in motion.world.lying:
        rolling.first_mode(motion, state, number)
    if motion.world.is_rigid:
        return
    for number in range(len(motion.world.pairs)):
        _first_contact_mode(motion, state, number, h)
    for number, slider in enumerate(motion.world.sliders):
        speed = motion.parts.slides_at(slider, state.v[slider.a])
        state.side[number] = motion.parts.side_of(motion, state, number, speed)


def _first_contact_mode(motion: Moving, state: State, number: int, h: Number) -> None:
    """Sets whether a pair acts, presses and slides at the start."""
    world = motion.world
    i, j = world.pairs[number]
    _, _, rate, _ = meeting(world, state, motion.parts, number)
    acts, push = contact_guards(motion, state, number)
    radii = world.radius[i]
    if j >= 0:
        radii = radii + world.radius[j]
    # A smaller guard is zero up to rounding: in m, or in N where the guard is a force.
    tolerance = radii * touch_tolerance(motion)
    if world.law.cutoff == "zero_force":
        tolerance = tolerance * world.law.stiffness
    closes = rate * h > 0
    is_acting = bool(acts > tolerance or (acts > -tolerance and closes))
    state.acting[number] = is_acting
    state.pressing[number] = is_acting
    # With zero normal force any tangential spring is at Coulomb's limit.
    weakest_push = world.law.stiffness * world.radius[i] * touch_tolerance(motion)
    if is_acting and push <= weakest_push:
        load = motion.parts.loads(world, state, motion.parts)
        state.sliding[number] = slides(motion, state, load, number, h)


def side_of(motion: Moving, state: State, number: int, speed: Number) -> int:
    """The direction of slip of a slider, 1 or -1; 0 if it is at rest and friction holds it."""
    if speed:
        if speed > 0:
            return 1
        return -1
    along = pull_along(motion, state, number)
    if motion.parts.holds(motion.world.sliders[number], along):
        return 0
    if along > 0:
        return 1
    return -1


def pull_along(motion: Moving, state: State, number: int) -> Number:
    """The force [N] along a slider's axis of all other elements.

    The friction of a sticking slider balances all other forces, and that of a slipping one is
    known. The loads are therefore computed as if it slipped, and that friction is subtracted.
    """
    slider = motion.world.sliders[number]
    subject = state.copy()
    subject.side[number] = 1
    without = motion.parts.loads(motion.world, subject, motion.parts).force[slider.a]
    speed = abs(motion.parts.slides_at(slider, subject.v[slider.a]))
    friction = motion.parts.slider_force(slider, 1, speed)
    return vec.dot(vec.minus(without, friction), slider.axis)


def slides(motion: Moving, state: State, load: Loads, number: int, h: Number) -> bool:
    """True if a tangential spring at Coulomb's limit stays there."""
    return bool(limit_excess_rate(motion, state, load, number, h) > 0)


def limit_excess_rate(motion: Moving, state: State, load: Loads, number: int, h: Number) -> Number:
    """The rate at which a tangential spring xi at Coulomb's limit would exceed it, k_t |xi|' - mu
    F_n' [N/s]; 0 without a spring. The sign is reversed for h < 0, so that the contact slips where
    it is above 0.
    """
    law = motion.world.law
    if not (_law_has_spring(law) and state.pressing[number]):
        return 0.0
    i, j = motion.world.pairs[number]
    _, _, rate, relative = meeting(motion.world, state, motion.parts, number)
    stretch = load.stretch[number]
    slip = load.slip[number]
    length = vec.size(stretch)
    # xi' is the slip s: |xi|' = xi . s/|xi|, and |s| where xi = 0.
    if length > 0:
        stretching = vec.dot(stretch, slip) / length
    else:
        stretching = vec.size(slip)
    # F_n' = k d' + c d''.
    normal_rate = law.stiffness * rate
    if law.damping > 0:
        acceleration = vec.times(1.0 / motion.world.mass[i], load.force[i])
        if j >= 0:
            acceleration = vec.moved(acceleration, -1.0 / motion.world.mass[j], load.force[j])
        d_second = second_rate(motion, state, number, relative, rate, acceleration)
        normal_rate += law.damping * d_second
    excess_rate = law.tangential_stiffness * stretching - law.friction * normal_rate
    if h > 0:
        return excess_rate
    return -excess_rate


def second_rate(
    motion: Moving,
    state: State,
    number: int,
    relative: Vector,
    rate: Number,
    acceleration: Vector,
) -> Number:
    """d'' [m/s^2] of a pair, from its relative acceleration a = a_i - a_j (3), its relative
    velocity v and the rate d' of its overlap.

    d = R_i + R_j - rho has d' = v . n; the normal turns with n' = -(v - (v . n) n)/rho, so that d''
    = a . n - (|v|^2 - d'^2)/rho. The normal of a plane does not turn.
    """
    i, j = motion.world.pairs[number]
    normal, depth, _, _ = meeting(motion.world, state, motion.parts, number)
    along_normal = vec.dot(acceleration, normal)
    if j < 0:
        return along_normal
    distance = motion.world.radius[i] + motion.world.radius[j] - depth
    return along_normal - (vec.dot(relative, relative) - rate * rate) / distance


def _law_has_spring(law: Any) -> bool:
    """The contact law, None without contacts, has friction with a tangential spring."""
    return law is not None and bool(law.friction > 0 and law.tangential_stiffness > 0)


def has_spring(motion: Moving, state: State, number: int) -> bool:
    """True if the pair presses and has a tangential spring."""
    touches = state.acting[number] and state.pressing[number]
    return touches and _law_has_spring(motion.world.law)


def slide_margin(
    motion: Moving, before: State, after: State, load: Loads, number: int, h: Number, push: Number
) -> Number:
    """The guard of sliding or of sticking: k_t |xi|' - mu F_n' or mu F_n - k_t |xi|."""
    if before.sliding[number]:
        # It slides while k_t |xi|' - mu F_n' > 0; exactly 0 counts as negative, and it sticks.
        excess_rate = limit_excess_rate(motion, after, load, number, h)
        if excess_rate == 0:
            return -positional.TINY
        return excess_rate
    # It sticks while k_t |xi| <= mu F_n.
    law = motion.world.law
    return law.friction * push - law.tangential_stiffness * vec.size(load.stretch[number])


Change = tuple[str, int]
"""A kind of change of mode, and the number of the pair, hook, wall or slider that changes."""
Margins = list[tuple[Number, Change]]
"""Guards, each with the change of mode that is due where the guard is below 0."""


def margins(motion: Moving, before: State, after: State, load: Loads, h: Number) -> Margins:
    """The guards of all modes at the end of a step, each with its change of mode.

    A guard below 0 means that the mode of the start of the step is not valid any more.
    """
    world = motion.world
    pairs = range(len(world.pairs))
    if world.lying:
        return [(rolling.margin(motion, after, n), ("roll", n)) for n in world.lying]
    if world.is_rigid:
        return [(impacts.margin(motion, after, n, h), ("impact", n)) for n in pairs]
    guards: Margins = []
    for number in pairs:
        guards += _contact_margins(motion, before, after, load, number, h)
    if world.hooks:
        guards += holding.margins(world, before, after, h)
    if world.tents or world.walls:
        guards += positional.margins(world, before, after, motion.parts, h)
    return guards + _stop_margins(motion, before, after)


def _contact_margins(
    motion: Moving, before: State, after: State, load: Loads, number: int, h: Number
) -> Margins:
    """The guards of a pair: the contact ends (contact), the normal force changes its sign (press),
    or the tangential spring reaches Coulomb's limit or leaves it (slide).
    """
    acts, push = contact_guards(motion, after, number)
    if not before.acting[number]:
        return [(-acts, ("contact", number))]
    guards: Margins = [(acts, ("contact", number))]
    # "press" and "slide" do not apply to a contact that ends or has no friction.
    if acts < 0 or not motion.world.law.friction > 0:
        return guards
    if before.pressing[number]:
        press_margin = push
    elif push == 0:
        # A force of exactly 0 begins to press.
        press_margin = -positional.TINY
    else:
        press_margin = -push
    guards.append((press_margin, ("press", number)))
    if press_margin >= 0 and has_spring(motion, before, number):
        margin = slide_margin(motion, before, after, load, number, h, push)
        guards.append((margin, ("slide", number)))
    return guards


def _stop_margins(motion: Moving, before: State, after: State) -> Margins:
    """The guards of sliders: the slip velocity of one that slips, and +-1 for one that sticks or
    is released.
    """
    guards: Margins = []
    for number, slider in enumerate(motion.world.sliders):
        side = before.side[number]
        if side != 0:
            margin = motion.parts.slides_at(slider, after.v[slider.a]) * side
        elif motion.parts.holds(slider, pull_along(motion, after, number)):
            margin = 1.0
        else:
            margin = -1.0
        guards.append((margin, ("stop", number)))
    return guards


def least(guards: Margins) -> Number:
    """The smallest of all margins."""
    return min((margin for margin, _ in guards), default=1.0)


def _meet_or_part(motion: Moving, state: State, number: int) -> None:
    """Begins or ends the contact of a pair, with its event.

    A contact that ends at an overlap d > 0 loses its stored energy, which is added to the work.
    """
    _, depth, _, _ = meeting(motion.world, state, motion.parts, number)
    begins = not state.acting[number]
    if begins:
        state.work -= stored_energy(motion.world, depth)
        kind = "contact"
    else:
        state.work += stored_energy(motion.world, depth)
        kind = "release"
    state.acting[number] = begins
    state.pressing[number] = begins
    state.stretch[number] = ZERO
    state.sliding[number] = False
    body, _ = motion.world.pairs[number]
    motion.events.append((state.t, kind, body))


def _press_or_lift(motion: Moving, state: State, number: int) -> None:
    """Changes the sign of the normal force of a pair, whose tangential spring is reset to 0."""
    state.pressing[number] = not state.pressing[number]
    state.stretch[number] = ZERO


def _slide_or_stick(motion: Moving, state: State, number: int) -> None:
    """Changes a tangential spring between sticking and sliding at Coulomb's limit."""
    state.sliding[number] = not state.sliding[number]


def _turn_wedge(motion: Moving, state: State, number: int) -> None:
    """Rotates a wedge that has come to rest in a wall by pi."""
    positional.turned(motion.world, state, motion.parts, number)


def _pass_edge(motion: Moving, state: State, number: int) -> None:
    """Changes nothing: a step ends here because the force has a kink."""


def _stop_slider(motion: Moving, state: State, number: int) -> None:
    """Stops a slider: its slip velocity is set to exactly 0, and it sticks or slips in the
    direction of the other forces.
    """
    slider = motion.world.sliders[number]
    v = state.v[slider.a]
    # v+ = v - u axis, with the slip velocity u.
    speed = motion.parts.slides_at(slider, v)
    state.v[slider.a] = vec.moved(v, -speed, slider.axis)
    side_before = state.side[number]
    side = motion.parts.side_of(motion, state, number, 0.0)
    state.side[number] = side
    if side_before == 0:
        motion.events.append((state.t, "slip", slider.a))
    elif side == 0:
        motion.events.append((state.t, "stick", slider.a))


CHANGES: Mapping[str, Callable[[Moving, State, int], None]] = {
    "contact": _meet_or_part,
    "press": _press_or_lift,
    "slide": _slide_or_stick,
    "impact": impacts.struck,
    "roll": rolling.ended,
    "catch": holding.catch,
    "turn": _turn_wedge,
    "edge": _pass_edge,
    "stop": _stop_slider,
}
"""Changes of mode by their kinds; each changes the state in place."""


def stored_energy(world: World, depth: Number) -> Number:
    """Energy k d^(n+1)/(n+1) [J] of the normal spring at an overlap d [m], which is lost if the
    contact ends at this overlap.
    """
    # The integral of the force k d^n from 0 to d.
    power = world.law.exponent + 1
    if depth > 0:
        return world.law.stiffness * depth**power / power
    return 0.0


def advance(
    motion: Moving, step: Step, state: State, load: Loads, h: Number
) -> tuple[State, Loads]:
    """One step of h [s], in pieces between changes of mode: the state and its loads at the end.

    A trial step over the rest of h is accepted if all guards are positive at its end. Otherwise it
    is shortened to just beyond the first zero of a guard, and that mode is changed.
    """
    if motion.world.is_smooth:
        return step(motion, state, load, h)
    left = h
    for _ in range(MOST_EVENTS):
        after, load_after = step(motion, state, load, left)
        guards = margins(motion, state, after, load_after, left)
        if least(guards) >= 0:
            return after, load_after
        cut = _cut(motion, step, state, load, left, (after, guards))
        state = cut.state.copy()
        for margin, (kind, number) in cut.guards:
            if margin < 0:
                CHANGES[kind](motion, state, number)
        load = motion.parts.loads(motion.world, state, motion.parts)
        left = left - cut.part * left
        if not left:
            return state, load
    return step(motion, state, load, left)


class Cut(NamedTuple):
    """The end of a shortened step: the part of the step in [0, 1] just beyond the first zero of a
    guard, the state there, and its guards.
    """

    part: float
    state: State
    guards: Margins


def _cut(
    motion: Moving,
    step: Step,
    state: State,
    load: Loads,
    h: Number,
    end: tuple[State, Margins],
) -> Cut:
    """The point at which a step of h [s] is divided, from the state and the guards at its end."""
    end_state, end_guards = end

    def margin(part: float) -> float:
        """The least guard after a part of the step; the last one below 0 is kept as the end."""
        nonlocal end_state, end_guards
        trial, load_trial = step(motion, state, load, part * h)
        guards = margins(motion, state, trial, load_trial, h)
        if least(guards) < 0:
            end_state = trial
            end_guards = guards
        return float(least(guards))

    resolution = 2.0**-24
    if motion.world.number is float:
        resolution = 2.0**-53
    first = float(least(margins(motion, state, state, load, h)))
    last = float(least(end_guards))
    part = motion.parts.located(margin, first, last, resolution)
    return Cut(part, end_state, end_guards)


def sign_change(
    margin: Callable[[float], float], first: float, last: float, resolution: float
) -> float:
    """The upper end of an interval of 2 x resolution in [0, 1] in which a margin falls below 0, by
    the ITP method.

    Oliveira and Takahashi 2021, ACM TOMS 47(1) 5, with k1 = 0.2, k2 = 2, n0 = 1: never more than
    one evaluation beyond those of bisection, and few where the margin is smooth. `first` and `last`
    are the margins at 0 and 1.
    """
    low = 0.0
    high = 1.0
    above = max(first, positional.TINY)
    below = last
    # Largest allowed width of the next interval, twice that of bisection: at most one evaluation
    # more than bisection is needed.
    allowed_width = 1.0
    while high - low > 2 * resolution:
        middle = (low + high) / 2
        width = high - low
        # Interpolate: the zero of the chord through both ends.
        chord = (below * low - above * high) / (below - above)
        # Truncate: move it towards the middle by k1 width^k2, but at least by the resolution, so
        # that the next point is on the other side of the zero if the chord converges from one side.
        shift = max(0.2 * width * width, resolution)
        side = -1.0
        if middle > chord:
            side = 1.0
        truncated = middle
        if shift <= abs(middle - chord):
            truncated = chord + side * shift
        # Project: |part - middle| <= allowed_width - width/2, so that neither interval is wider
        # than allowed.
        radius = allowed_width - width / 2
        part = truncated
        if abs(truncated - middle) > radius:
            part = middle - side * radius
        # Rounding may have moved it to an end.
        if not low < part < high:
            part = middle
        if not low < part < high:
            break
        allowed_width /= 2
        value = margin(part)
        if value < 0:
            high = part
            below = value
        else:
            low = part
            above = max(value, positional.TINY)
    return high
