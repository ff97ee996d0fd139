"""The derivatives of a motion through events by the parameters of its modes, guards and resets.

Theorem: let the parameters p be added to the state, as coordinates whose rate is 0 and which no
reset changes. The switching system then has no parameters, and the derivative of its state by p is
the derivative by a part of its start, which the jump matrices propagate through each event
(phase.py). They contain the derivative of the time t* of the event, with g_y = grad g,

    dt*/dp = -(g_p + g_y . dy/dp)/(g_y . f),

and the derivative of the reset by p.

Hypotheses, and where each is checked:

* motions for parameters near p pass the same events in the same order: each guard crosses zero at a
  rate that is proved not to be 0 (`Phase.after`), and no two guards vanish at the same time
  (`earliest`, crossing.py);
* a guard that an entry declares to be exactly 0 is 0 there for all parameters near p: derivatives
  are bracketed by differences of certified values (sensitivities.py).

A state of this module is (y_1, .., y_n, d_1, .., d_count, clock): n coordinates of the mode but for
the clock, one coordinate d_k = 1 for each of the `count` parameters (traced_field.py), the clock.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from flint import arb

from refdem.truth.balls import precision
from refdem.truth.dual import DualBall, ball, slopes_of
from refdem.truth.events.motion import Followed
from refdem.truth.events.system import Entry, Guard, GuardRates, Mode, State, TracedModes
from refdem.truth.validated_ivp.integration import GUARD


def inner(y: Sequence[Any], count: int) -> list[Any]:
    """The coordinates (y_1, .., y_n, clock) of the mode, without its `count` parameters."""
    return [*y[: -1 - count], y[-1]]


def beside_parameters(y: Sequence[Any], parameters: Sequence[Any]) -> list[Any]:
    """The coordinates of a mode with those of its parameters inserted before the clock."""
    return [*y[:-1], *parameters, y[-1]]


def directed(mode: Mode, count: int) -> Mode:
    """A mode whose `count` parameters are coordinates."""

    def field(y: Sequence[Any]) -> list[Any]:
        # y' = f(y), d' = 0, and the rate 1 of the clock.
        return beside_parameters(mode.field(inner(y, count)), [0] * count)

    def leaves(y: State) -> tuple[str, arb] | None:
        assert mode.leaves is not None
        end = mode.leaves(inner(y, count))
        if end is None:
            return None
        name, since = end
        return name, ball(since)

    def stops(y: State) -> arb | None:
        assert mode.stops is not None
        return mode.stops(inner(y, count))

    return replace(
        mode,
        field=field,
        guards=tuple(directed_guard(guard, count) for guard in mode.guards),
        leaves=leaves if mode.leaves else None,
        stops=stops if mode.stops else None,
    )


class DirectedModes(dict[str, Mode]):
    """Modes whose `count` parameters are coordinates, each made when it is entered."""

    def __init__(self, modes: Mapping[str, Mode], count: int) -> None:
        super().__init__()
        self.modes = modes
        self.count = count

    def __missing__(self, name: str) -> Mode:
        self[name] = directed(self.modes[name], self.count)
        return self[name]


def directed_programs(
    modes: Mapping[str, Mode], size: int, rates: GuardRates, count: int
) -> TracedModes:
    """The programs of modes of `size` coordinates to which `count` parameters are added."""
    return TracedModes(DirectedModes(modes, count), size + count, rates, count)


def directed_guard(guard: Guard, count: int) -> Guard:
    """A guard, and the entry that follows it, where parameters are coordinates."""
    return Guard(
        guard.name,
        lambda y: guard.value(inner(y, count)),
        lambda y: directed_entry(guard.then(inner(y, count)), count),
    )


def directed_entry(entry: Entry, count: int) -> Entry:
    """An entry whose reset leaves the parameters what they are."""
    reset = entry.reset
    if reset is None:
        return entry

    def with_parameters(y: Sequence[Any]) -> list[Any]:
        # The reset of y, with the parameters d and the clock.
        return beside_parameters(reset(inner(y, count)), y[-1 - count : -1])

    return replace(entry, reset=with_parameters)


def directed_start(start: Sequence[arb], count: int) -> list[arb]:
    """The balls of a start without their derivatives, and 1 for each parameter."""
    return beside_parameters([ball(value) for value in start], [arb(1)] * count)


def dual_state(motion: Followed, t: arb, start: Sequence[arb], count: int) -> list[arb]:
    """The coordinates of the mode at t, with their derivatives by the parameters.

        dy_i(t)/dp_k = dy_i(t)/dd_k + sum over j of dy_i(t)/dy_j(0) dy_j(0)/dp_k,

    where j runs over the coordinates of the mode, the clock included. `motion` is that of the modes
    with parameters as coordinates, `start` has the start of the modes themselves as dual balls.
    """
    state = motion.at(t)
    table = motion.jacobian(t).table()
    no_slopes = (arb(0),) * count
    with precision(motion.bits + GUARD):
        duals: list[arb] = []
        for value, row in zip(inner(state, count), inner(table, count), strict=True):
            # dy_i(t)/dd_k, to which each coordinate j of the start adds its product.
            slopes = list(row[-1 - count : -1])
            for by_start, one in zip(inner(row, count), start, strict=True):
                of_start = slopes_of(one) or no_slopes
                # dy_i/dp_k += (dy_i(t)/dy_j(0)) (dy_j(0)/dp_k) for each k.
                slopes = [
                    slope + by_start * other for slope, other in zip(slopes, of_start, strict=True)
                ]
            duals.append(DualBall(value, slopes))
    return duals
