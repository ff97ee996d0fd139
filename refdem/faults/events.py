"""Steps that are cut where a contact begins or ends, where friction ends, and where a slider
stops.
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
"""Changes of mode in one step. More in one step mean that the modes flip without end, as with a
faulty rule; the rest of the step is then made without events.
"""


def touch_tolerance(motion: Moving) -> float:
    """Overlap, relative to the radii, that rounding alone may leave where bodies only touch."""
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
        # A corner parts at zero overlap at the latest, whatever the cutoff.
        acts = min(acts, law.stiffness * depth)
    return acts, push


def first_modes(motion: Moving, state: State, h: Number) -> None:
    """Sets the modes of a start; a pair that only touches acts if it closes, a slider at rest
    starts towards what pulls it.
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
    # A guard this near to 0 is a touch: in m, or in N where the guard is a force.
    tolerance = radii * touch_tolerance(motion)
    if world.law.cutoff == "zero_force":
        tolerance = tolerance * world.law.stiffness
    closes = rate * h > 0
    is_acting = bool(acts > tolerance or (acts > -tolerance and closes))
    state.acting[number] = is_acting
    state.pressing[number] = is_acting
    # Without a force to press, any slip is beyond Coulomb's limit.
    weakest_push = world.law.stiffness * world.radius[i] * touch_tolerance(motion)
    if is_acting and push <= weakest_push:
        load = motion.parts.loads(world, state, motion.parts)
        state.sliding[number] = slides(motion, state, load, number, h)


def side_of(motion: Moving, state: State, number: int, speed: Number) -> int:
    """Towards where a slider moves: 0 if it is at rest and friction holds it."""
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
    """The force [N] along a slider's axis of all else, where it does not slip.

    A slider at rest would balance whatever pulls it; one that slips adds a known friction. So the
    loads are taken as if it slipped, less that friction.
    """
    slider = motion.world.sliders[number]
    subject = state.copy()
    subject.side[number] = 1
    without = motion.parts.loads(motion.world, subject, motion.parts).force[slider.a]
    speed = abs(motion.parts.slides_at(slider, subject.v[slider.a]))
    friction = motion.parts.slider_force(slider, 1, speed)
    return vec.dot(vec.minus(without, friction), slider.axis)


def slides(motion: Moving, state: State, load: Loads, number: int, h: Number) -> bool:
    """Whether a tangential spring at Coulomb's limit stays there."""
    return bool(limit_excess_rate(motion, state, load, number, h) > 0)


def limit_excess_rate(motion: Moving, state: State, load: Loads, number: int, h: Number) -> Number:
    """The rate at which a tangential spring xi at Coulomb's limit would exceed it, k_t |xi|' - mu
    F_n' [N/s]; 0 without a spring. Its sign is that of a run forwards: above 0 the contact slips.
    """
    law = motion.world.law
    if not (_law_has_spring(law) and state.pressing[number]):
        return 0.0
    i, j = motion.world.pairs[number]
    _, _, rate, relative = meeting(motion.world, state, motion.parts, number)
    stretch = load.stretch[number]
    slip = load.slip[number]
    length = vec.size(stretch)
    # xi' is the slip: |xi|' = xi . xi'/|xi|, and |xi'| for a spring that is not stretched yet.
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
    """The pair's tangential spring is at work."""
    touches = state.acting[number] and state.pressing[number]
    return touches and _law_has_spring(motion.world.law)


def slide_margin(
    motion: Moving, before: State, after: State, load: Loads, number: int, h: Number, push: Number
) -> Number:
    """What keeps a spring that slid sliding, and one that stuck within Coulomb's limit."""
    if before.sliding[number]:
        # It slides on while the limit would be exceeded; exactly 0 counts as below 0, and sticks.
        excess_rate = limit_excess_rate(motion, after, load, number, h)
        if excess_rate == 0:
            return -positional.TINY
        return excess_rate
    # It sticks on while k_t |xi| <= mu F_n.
    law = motion.world.law
    return law.friction * push - law.tangential_stiffness * vec.size(load.stretch[number])


Change = tuple[str, int]
"""A kind of change of mode, and the number of the pair, hook, wall or slider that changes."""
Margins = list[tuple[Number, Change]]
"""The guard of every mode with the change of mode that it stands for: below 0 it is due."""


def margins(motion: Moving, before: State, after: State, load: Loads, h: Number) -> Margins:
    """The guard of every mode at the end of a step, each with the change of mode it stands for.

    A guard below 0 says that the mode of the step's start does not fit any more.
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
    """The guards of a pair: it parts (contact), it ceases to press (press), its tangential spring
    comes to its limit or leaves it (slide).
    """
    acts, push = contact_guards(motion, after, number)
    if not before.acting[number]:
        return [(-acts, ("contact", number))]
    guards: Margins = [(acts, ("contact", number))]
    # "press" and "slide" mean nothing for a pair that parts or has no friction.
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
    """How far every slider is from its stop, and from letting go."""
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
    """A pair that does not act begins to; one that acts ends."""
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
    """A pair whose force begins or ceases to press starts with a new tangential spring."""
    state.pressing[number] = not state.pressing[number]
    state.stretch[number] = ZERO


def _slide_or_stick(motion: Moving, state: State, number: int) -> None:
    """A tangential spring comes to Coulomb's limit, or leaves it."""
    state.sliding[number] = not state.sliding[number]


def _turn_wedge(motion: Moving, state: State, number: int) -> None:
    """A wedge that has come to its stop in a wall turns round."""
    positional.turned(motion.world, state, motion.parts, number)


def _pass_edge(motion: Moving, state: State, number: int) -> None:
    """A force has a corner here, and a step ends; nothing else changes."""


def _stop_slider(motion: Moving, state: State, number: int) -> None:
    """A slider is at rest: its slip is set to exactly 0, and it sticks or slips to where all else
    pulls it.
    """
    slider = motion.world.sliders[number]
    v = state.v[slider.a]
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
    """Energy [J] of the normal spring at an overlap [m]; lost if the contact ends before the bodies
    are apart.
    """
    # k d^(n+1)/(n+1), the work against k d^n.
    power = world.law.exponent + 1
    if depth > 0:
        return world.law.stiffness * depth**power / power
    return 0.0


def advance(
    motion: Moving, step: Step, state: State, load: Loads, h: Number
) -> tuple[State, Loads]:
    """One step of h [s], in pieces between changes of mode: the state and its loads at the end.

    A trial step over the rest of h is accepted if all modes of its start still fit at its end.
    Otherwise it is cut where the first of them has just ceased to fit, and that mode is changed.
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
    """Where a step ends early: after this part of it, in [0, 1], a mode has just ceased to fit; the
    state there, and its guards.
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
    """Where a step of h [s] is to be cut, from the state and the guards at its end."""
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
    # The next interval may be as wide at most, twice as wide as that of bisection: no more than one
    # evaluation is lost.
    allowed_width = 1.0
    while high - low > 2 * resolution:
        middle = (low + high) / 2
        width = high - low
        # Interpolate: the zero of the chord through both ends.
        chord = (below * low - above * high) / (below - above)
        # Truncate: move it towards the middle by k1 width^k2, at least by the resolution, so that a
        # chord that creeps along one end comes to the other side of the zero.
        shift = max(0.2 * width * width, resolution)
        side = -1.0
        if middle > chord:
            side = 1.0
        truncated = middle
        if shift <= abs(middle - chord):
            truncated = chord + side * shift
        # Project: stay as near to the middle as the allowed width demands.
        radius = allowed_width - width / 2
        part = truncated
        if abs(truncated - middle) > radius:
            part = middle - side * radius
        # Rounding may have put it on an end.
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
