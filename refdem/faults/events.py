"""Steps that are cut where a contact begins or ends, where friction ends, and where a slider
stops.
"""

from collections.abc import Callable, Mapping
from typing import Any

from refdem.faults import holding, impacts, positional, rolling
from refdem.faults import vectors as vec
from refdem.faults.loads import meeting
from refdem.faults.parts import Moving, Step
from refdem.faults.state import Loads, State
from refdem.faults.vectors import ZERO, Number, Vector
from refdem.faults.world import World

MOST_EVENTS = 8
"""Changes of mode in one step. More in one step mean that the modes flip without end, as with a
faulty rule; the rest of the step is then made without events.
"""


def touch(m: Moving) -> float:
    """Relative overlap that rounding alone may leave of a touch."""
    if m.world.number is float:
        return 1e-12
    return 1e-5


def values(m: Moving, state: State, number: int) -> tuple[Number, Number, Number]:
    """The guards of a contact's modes, and the rate of its overlap [m/s]: the first is positive
    while the contact acts, the second, its normal force [N], while it presses.
    """
    _, depth, rate, _ = meeting(m.world, state, m.parts, number)
    push = m.parts.normal_force(m.world.law, depth, rate)
    acts = m.parts.presses(m.world.law, depth, push)
    if m.world.corners[number] is not None:
        # A corner parts at zero overlap at the latest, whatever the cutoff.
        acts = min(acts, m.world.law.stiffness * depth)
    return acts, push, rate


def first_modes(m: Moving, state: State, h: Number) -> None:
    """Sets the modes of a start; a pair that only touches acts if it closes, a slider at rest
    starts towards what pulls it.
    """
    for number in m.world.lying:
        rolling.first_mode(m, state, number)
    if m.world.is_rigid:
        return
    for number, (i, j) in enumerate(m.world.pairs):
        acts, push, rate = values(m, state, number)
        radii = m.world.radius[i]
        if j >= 0:
            radii = radii + m.world.radius[j]
        # A guard this near to 0 is a touch: in m, or in N where the guard is a force.
        tolerance = radii * touch(m)
        if m.world.law.cutoff == "zero_force":
            tolerance = tolerance * m.world.law.stiffness
        closes = rate * h > 0
        is_acting = bool(acts > tolerance or (acts > -tolerance and closes))
        state.acting[number] = is_acting
        state.pressing[number] = is_acting
        # Without a force to press, any slip is beyond Coulomb's limit.
        if state.acting[number] and push <= m.world.law.stiffness * m.world.radius[i] * touch(m):
            state.sliding[number] = slides(
                m, state, m.parts.loads(m.world, state, m.parts), number, h
            )
    for number, slider in enumerate(m.world.sliders):
        state.side[number] = m.parts.side_of(
            m, state, number, m.parts.slides_at(slider, state.v[slider.a])
        )


def side_of(m: Moving, state: State, number: int, speed: Number) -> int:
    """Towards where a slider moves: 0 if it is at rest and friction holds it."""
    if speed:
        if speed > 0:
            return 1
        return -1
    along = pull_along(m, state, number)
    if m.parts.holds(m.world.sliders[number], along):
        return 0
    if along > 0:
        return 1
    return -1


def pull_along(m: Moving, state: State, number: int) -> Number:
    """The force [N] along a slider's axis of all else, where it does not slip.

    A slider at rest would balance whatever pulls it; one that slips adds a known friction. So the
    loads are taken as if it slipped, less that friction.
    """
    slider = m.world.sliders[number]
    subject = state.copy()
    subject.side[number] = 1
    without = m.parts.loads(m.world, subject, m.parts).force[slider.a]
    speed = abs(m.parts.slides_at(slider, subject.v[slider.a]))
    friction = m.parts.slider_force(slider, 1, speed)
    return vec.dot(vec.minus(without, friction), slider.axis)


def slides(m: Moving, state: State, load: Loads, number: int, h: Number) -> bool:
    """A tangential spring at its limit stays there."""
    return bool(limit_excess_rate(m, state, load, number, h) > 0)


def limit_excess_rate(m: Moving, state: State, load: Loads, number: int, h: Number) -> Number:
    """The rate at which a tangential spring at its limit would exceed the limit, k_t |s|' - mu F'
    [N/s]; 0 without a spring. Its sign is that of a run forwards: above 0 the contact slips.
    """
    law = m.world.law
    if law is None or not (
        law.friction > 0 and law.tangential_stiffness > 0 and state.pressing[number]
    ):
        return 0.0
    i, j = m.world.pairs[number]
    _, _, rate, relative = meeting(m.world, state, m.parts, number)
    stretch = load.stretch[number]
    slip = load.slip[number]
    length = vec.size(stretch)
    # |s|' = s.s'/|s|, and |s'| for a spring that is not stretched yet.
    if length > 0:
        stretching = vec.dot(stretch, slip) / length
    else:
        stretching = vec.size(slip)
    # F' = k d' + c d''.
    normal_rate = law.stiffness * rate
    if law.damping > 0:
        pull = vec.times(1.0 / m.world.mass[i], load.force[i])
        if j >= 0:
            pull = vec.moved(pull, -1.0 / m.world.mass[j], load.force[j])
        normal_rate += law.damping * second_rate(m, state, number, relative, rate, pull)
    excess_rate = law.tangential_stiffness * stretching - law.friction * normal_rate
    if h > 0:
        return excess_rate
    return -excess_rate


def second_rate(
    m: Moving, state: State, number: int, relative: Vector, rate: Number, pull: Vector
) -> Number:
    """d'' [m/s^2] of a pair, `pull` being the relative acceleration a = a_i - a_j (3), `relative`
    the relative velocity v and `rate` d'.

    d = R_i + R_j - rho has d' = v . n; the normal turns with n' = -(v - (v . n) n)/rho, so that d''
    = a . n - (|v|^2 - d'^2)/rho. The normal of a plane does not turn.
    """
    i, j = m.world.pairs[number]
    normal, depth, _, _ = meeting(m.world, state, m.parts, number)
    if j < 0:
        return vec.dot(pull, normal)
    distance = m.world.radius[i] + m.world.radius[j] - depth
    return vec.dot(pull, normal) - (vec.dot(relative, relative) - rate * rate) / distance


def has_spring(m: Moving, state: State, number: int) -> bool:
    """The pair's tangential spring is at work."""
    law = m.world.law
    return bool(
        state.acting[number]
        and state.pressing[number]
        and law.friction > 0
        and law.tangential_stiffness > 0
    )


def slide_margin(
    m: Moving, before: State, after: State, load: Loads, number: int, h: Number, push: Number
) -> Number:
    """What keeps a spring that slid sliding, and one that stuck within Coulomb's limit."""
    if before.sliding[number]:
        # It slides on while the limit would be exceeded; exactly 0 counts as below 0, and sticks.
        excess_rate = limit_excess_rate(m, after, load, number, h)
        if excess_rate == 0:
            return -positional.TINY
        return excess_rate
    # It sticks on while k_t |xi| <= mu F_n.
    law = m.world.law
    return law.friction * push - law.tangential_stiffness * vec.size(load.stretch[number])


Change = tuple[str, int]


def margins(
    m: Moving, before: State, after: State, load: Loads, h: Number
) -> list[tuple[Number, Change]]:
    """The guard of every mode at the end of a step, each with the change of mode it stands for.

    A guard below 0 says that the mode of the step's begin does not fit any more.
    """
    pairs = range(len(m.world.pairs))
    if m.world.lying:
        return [(rolling.margin(m, after, number), ("roll", number)) for number in m.world.lying]
    if m.world.is_rigid:
        return [(impacts.margin(m, after, number, h), ("impact", number)) for number in pairs]
    margins_found: list[tuple[Number, Change]] = []
    for number in pairs:
        margins_found += _contact_margins(m, before, after, load, number, h)
    if m.world.hooks:
        margins_found += holding.margins(m.world, before, after, h)
    if m.world.tents or m.world.walls:
        margins_found += positional.margins(m.world, before, after, m.parts, h)
    return margins_found + _stop_margins(m, before, after)


def _contact_margins(
    m: Moving, before: State, after: State, load: Loads, number: int, h: Number
) -> list[tuple[Number, Change]]:
    """The guards of a pair: it parts (contact), it ceases to press (press), its tangential spring
    comes to its limit or leaves it (slide).
    """
    acts, push, _ = values(m, after, number)
    if before.acting[number]:
        margin = acts
    else:
        margin = -acts
    guards: list[tuple[Number, Change]] = [(margin, ("contact", number))]
    # "press" and "slide" mean nothing for a pair that parts, does not act, or has no friction.
    if margin < 0 or not before.acting[number] or not m.world.law.friction > 0:
        return guards
    if before.pressing[number]:
        margin = push
    else:
        # 0 counts as below 0: a force of exactly 0 begins to press.
        margin = -push
        if margin == 0:
            margin = -positional.TINY
    guards.append((margin, ("press", number)))
    if margin >= 0 and has_spring(m, before, number):
        guards.append((slide_margin(m, before, after, load, number, h, push), ("slide", number)))
    return guards


def _stop_margins(m: Moving, before: State, after: State) -> list[tuple[Number, Change]]:
    """How far every slider is from its stop, and from letting go."""
    margins_found: list[tuple[Number, Change]] = []
    for number, slider in enumerate(m.world.sliders):
        side = before.side[number]
        if side != 0:
            margin = m.parts.slides_at(slider, after.v[slider.a]) * side
        elif m.parts.holds(slider, pull_along(m, after, number)):
            margin = 1.0
        else:
            margin = -1.0
        margins_found.append((margin, ("stop", number)))
    return margins_found


def least(margins_found: list[tuple[Number, Change]]) -> Number:
    """The smallest of all margins."""
    return min((margin for margin, _ in margins_found), default=1.0)


def _meet_or_part(m: Moving, state: State, number: int) -> None:
    """A pair that does not act begins to; one that acts ends."""
    _, depth, _, _ = meeting(m.world, state, m.parts, number)
    begins = not state.acting[number]
    if begins:
        state.work -= held(m.world, depth)
        kind = "contact"
    else:
        state.work += held(m.world, depth)
        kind = "release"
    state.acting[number] = begins
    state.pressing[number] = begins
    state.stretch[number] = ZERO
    state.sliding[number] = False
    body, _ = m.world.pairs[number]
    m.events.append((state.t, kind, body))


OF_BODIES: Mapping[str, Callable[[Moving, State, int], None]] = {
    "contact": _meet_or_part,
    "impact": impacts.struck,
    "roll": rolling.ended,
    "catch": holding.catch,
}
"""Changes of mode of pairs and hooks."""


def changed(m: Moving, state: State, change: tuple[str, int]) -> None:
    """Makes one change of mode in `state`: its kind, and the number of pair, hook or slider."""
    kind, number = change
    if kind in OF_BODIES:
        OF_BODIES[kind](m, state, number)
    elif kind == "turn":
        positional.turned(m.world, state, m.parts, number)
    elif kind == "edge":
        pass  # the force has a corner there, nothing else
    elif kind == "slide":
        state.sliding[number] = not state.sliding[number]
    elif kind == "press":
        state.pressing[number] = not state.pressing[number]
        state.stretch[number] = ZERO
    else:
        # "stop": the slip along the axis is exactly 0, and the next side is what pulls it.
        slider = m.world.sliders[number]
        v = state.v[slider.a]
        state.v[slider.a] = vec.moved(v, -m.parts.slides_at(slider, v), slider.axis)
        before = state.side[number]
        state.side[number] = m.parts.side_of(m, state, number, 0.0)
        if not before:
            m.events.append((state.t, "slip", slider.a))
        elif not state.side[number]:
            m.events.append((state.t, "stick", slider.a))


def held(world: World, depth: Number) -> Number:
    """What the normal spring holds [J]; lost if the contact ends while the bodies still overlap."""
    # k d^(n+1)/(n+1), the work against k d^n.
    power = world.law.exponent + 1
    if depth > 0:
        return world.law.stiffness * depth**power / power
    return 0.0


def advance(m: Moving, step: Step, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """One step of h [s], in pieces between changes of mode: the state and its loads at the end.

    A trial step over the rest of h is accepted if all modes of its begin still fit at its end.
    Otherwise it is cut where the first of them has just ceased to fit, and that mode is changed.
    """
    if m.world.is_smooth:
        return step(m, state, load, h)
    left = h
    for _ in range(MOST_EVENTS):
        after, load_after = step(m, state, load, left)
        margins_found = margins(m, state, after, load_after, left)
        if least(margins_found) >= 0:
            return after, load_after
        # `part` in [0, 1] is the part of the rest at which the mode ends.
        part, after, margins_found = _cut(m, step, state, load, left, (after, margins_found))
        after = after.copy()
        for margin, change in margins_found:
            if margin < 0:
                changed(m, after, change)
        state = after
        load = m.parts.loads(m.world, after, m.parts)
        left = left - part * left
        if not left:
            return state, load
    return step(m, state, load, left)


def _cut(
    m: Moving, step: Step, state: State, load: Loads, h: Number, end: tuple[State, Any]
) -> tuple[float, State, Any]:
    """The part of a step after which a mode has just ceased to fit, the state there and its
    margins.
    """
    kept = [end]

    def margin(part: float) -> float:
        subject, load_trial = step(m, state, load, part * h)
        margins_found = margins(m, state, subject, load_trial, h)
        if least(margins_found) < 0:
            kept[0] = subject, margins_found
        return float(least(margins_found))

    if m.world.number is float:
        resolution = 2.0**-53
    else:
        resolution = 2.0**-24
    first = float(least(margins(m, state, state, load, h)))
    last = float(least(end[1]))
    part = m.parts.located(margin, first, last, resolution)
    return (part, *kept[0])


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
