"""Steps that are cut where a contact begins or ends, where friction ends, and where a slider stops (bisection of the step)."""

from refdem.faults import positional
from refdem.faults import vectors as vec
from refdem.faults.loads import Loads, meeting
from refdem.faults.steps import Moving
from refdem.faults.vectors import ZERO, Number, Vector
from refdem.faults.world import State, World

HALVINGS = 52
MOST_EVENTS = 8


def touch(m: Moving) -> float:
    """Relative overlap that rounding alone may leave of a touch."""
    return 1e-12 if m.world.number is float else 1e-5


def values(m: Moving, state: State, number: int) -> tuple[Number, Number, Number]:
    """What a contact's modes hang on: positive while it acts, while it presses; and the rate of its overlap."""
    normal, depth, rate, _ = meeting(m.world, state, m.parts, number)
    del normal
    push = m.parts.normal_force(m.world.law, depth, rate)
    acts = m.parts.presses(m.world.law, depth, push)
    if m.world.corners[number] is not None:
        acts = min(acts, m.world.law.stiffness * depth)
    return acts, push, rate


def first_modes(m: Moving, state: State, h: Number) -> None:
    """Sets the modes of a start; a pair that only touches acts if it closes, a slider at rest starts towards what pulls it."""
    for number, (i, j) in enumerate(m.world.pairs):
        acts, push, rate = values(m, state, number)
        reach = (m.world.radius[i] + (m.world.radius[j] if j >= 0 else 0.0)) * touch(m)
        if m.world.law.cutoff == "zero_force":
            reach = reach * m.world.law.stiffness
        state.acting[number] = state.pressing[number] = bool(acts > reach or (acts > -reach and rate * h > 0))
        if state.acting[number] and push <= m.world.law.stiffness * m.world.radius[i] * touch(m):
            state.sliding[number] = slides(m, state, m.parts.loads(m.world, state, m.parts), number, h)
    for number, slider in enumerate(m.world.sliders):
        state.side[number] = m.parts.side_of(m, state, number, m.parts.slides_at(slider, state.v[slider.a]))


def side_of(m: Moving, state: State, number: int, speed: Number) -> int:
    """Towards where a slider moves: 0 if it is at rest and friction holds it."""
    if speed:
        return 1 if speed > 0 else -1
    along = pull_along(m, state, number)
    return 0 if m.parts.holds(m.world.sliders[number], along) else 1 if along > 0 else -1


def pull_along(m: Moving, state: State, number: int) -> Number:
    """The force [N] along a slider's axis of all else, where it does not slip."""
    slider, trial = m.world.sliders[number], state.copy()
    trial.side[number] = 1
    without = m.parts.loads(m.world, trial, m.parts).force[slider.a]
    return vec.dot(vec.minus(without, m.parts.slider_force(slider, 1, abs(m.parts.slides_at(slider, trial.v[slider.a])))), slider.axis)


def slides(m: Moving, state: State, load: Loads, number: int, h: Number) -> bool:
    """A tangential spring at its limit stays there: it would grow faster than the limit k_t |s'| > mu F'."""
    law = m.world.law
    if law is None or not (law.friction > 0 and law.tangential_stiffness > 0 and state.pressing[number]):
        return False
    i, j = m.world.pairs[number]
    _, _, rate, relative = meeting(m.world, state, m.parts, number)
    stretch, slip = load.stretch[number], load.slip[number]
    length = vec.size(stretch)
    along = vec.dot(stretch, slip) / length if length > 0 else vec.size(slip)
    growth = law.stiffness * rate
    if law.damping > 0:
        pull = vec.times(1.0 / m.world.mass[i], load.force[i])
        pull = vec.moved(pull, -1.0 / m.world.mass[j], load.force[j]) if j >= 0 else pull
        growth += law.damping * second_rate(m, state, number, relative, rate, pull)
    return bool((law.tangential_stiffness * along - law.friction * growth) * (1 if h > 0 else -1) > 0)


def second_rate(m: Moving, state: State, number: int, relative: Vector, rate: Number, pull: Vector) -> Number:
    """d'' [m/s^2]: the relative acceleration along the normal, less the turning of the normal."""
    i, j = m.world.pairs[number]
    normal, depth, _, _ = meeting(m.world, state, m.parts, number)
    if j < 0:
        return vec.dot(pull, normal)
    distance = m.world.radius[i] + m.world.radius[j] - depth
    return vec.dot(pull, normal) - (vec.dot(relative, relative) - rate * rate) / distance


def has_spring(m: Moving, state: State, number: int) -> bool:
    """The pair's tangential spring is at work."""
    law = m.world.law
    return bool(state.acting[number] and state.pressing[number] and law.friction > 0 and law.tangential_stiffness > 0)


def slides_now(m: Moving, before: State, after: State, load: Loads, number: int, h: Number) -> bool:
    """A spring that slid still does; one that stuck is longer than Coulomb's limit allows."""
    if before.sliding[number]:
        return slides(m, after, load, number, h)
    law, (_, push, _) = m.world.law, values(m, after, number)
    return bool(law.tangential_stiffness * vec.size(load.stretch[number]) > law.friction * push)


def changes(m: Moving, before: State, after: State, load: Loads, h: Number) -> list[tuple[str, int]]:
    """The modes that do not fit the state at the end of a step."""
    found = []
    for number in range(len(m.world.pairs)):
        acts, presses, _ = values(m, after, number)
        if (acts < 0) if before.acting[number] else (acts > 0):
            found.append(("contact", number))
        elif before.acting[number] and m.world.law.friction > 0 and before.pressing[number] != (presses >= 0):
            found.append(("press", number))
        elif has_spring(m, before, number) and before.sliding[number] != slides_now(m, before, after, load, number, h):
            found.append(("slide", number))
    found += positional.stops(m.world, before, after, m.parts, h)
    for number, slider in enumerate(m.world.sliders):
        side = before.side[number]
        released = side == 0 and not m.parts.holds(slider, pull_along(m, after, number))
        if released or m.parts.slides_at(slider, after.v[slider.a]) * side < 0:
            found.append(("stop", number))
    return found


def changed(m: Moving, state: State, change: tuple[str, int]) -> None:
    """Makes one change of mode."""
    kind, number = change
    if kind == "contact":
        _, depth, _, _ = meeting(m.world, state, m.parts, number)
        state.work += held(m.world, depth) * (1 if state.acting[number] else -1)
        state.acting[number] = state.pressing[number] = not state.acting[number]
        state.stretch[number], state.sliding[number] = ZERO, False
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
        slider = m.world.sliders[number]
        v = state.v[slider.a]
        state.v[slider.a] = vec.moved(v, -m.parts.slides_at(slider, v), slider.axis)
        state.side[number] = m.parts.side_of(m, state, number, 0.0)


def held(world: World, depth: Number) -> Number:
    """What the normal spring holds [J]; lost if the contact ends while the bodies still overlap."""
    power = world.law.exponent + 1
    return world.law.stiffness * depth**power / power if depth > 0 else 0.0


def advance(m: Moving, step: object, state: State, load: Loads, h: Number) -> tuple[State, Loads]:
    """One step of h, in pieces between changes of mode."""
    left = h
    for _ in range(MOST_EVENTS):
        after, load_after = step(m, state, load, left)  # type: ignore[operator]
        if m.world.is_smooth or not changes(m, state, after, load_after, left):
            return after, load_after
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            trial, load_trial = step(m, state, load, middle * left)  # type: ignore[operator]
            if changes(m, state, trial, load_trial, left):
                high, after, load_after = middle, trial, load_trial
            else:
                low = middle
        found = changes(m, state, after, load_after, left)
        for change in found:
            changed(m, after, change)
        state, load, left = after, m.parts.loads(m.world, after, m.parts), left - high * left
        if not left:
            return state, load
    return step(m, state, load, left)  # type: ignore[operator, no-any-return]
