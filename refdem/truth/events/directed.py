"""The derivatives of a motion through events by the parameters of its modes, guards and resets.

Theorem: with the parameters p as coordinates whose rate is 0 and which no reset changes, a system
that switches is one without parameters. The derivative of its state by p is then that by a part of
its start, which the jump matrices carry through each event (phase.py): with the derivative dt*/dp =
-g_p/(grad g . f) of the time of the event, and that of the reset.

Hypotheses, and where each is checked:

* the motion beside it passes the same events in the same order: a guard crosses zero at a proved
  rate (Phase.after), and two guards do not come together (`earliest`, crossing.py);
* what an entry says is exactly zero is so for all parameters beside them: derivatives are bracketed
  by differences of certified values (sensitivities.py).

A state here is (y_1, .., y_n, d_1, .., d_count, clock), with d_k = 1 for the parameter k
(traced_field.py).
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
    """The coordinates of the mode itself, without its `count` parameters."""
    return [*y[: -1 - count], y[-1]]


def beside_parameters(y: Sequence[Any], parameters: Sequence[Any]) -> list[Any]:
    """The coordinates of a mode with those of its parameters before the clock."""
    return [*y[:-1], *parameters, y[-1]]


def directed(mode: Mode, count: int) -> Mode:
    """A mode whose `count` parameters are coordinates."""

    def field(y: Sequence[Any]) -> list[Any]:
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
        return beside_parameters(reset(inner(y, count)), y[-1 - count : -1])

    return replace(entry, reset=with_parameters)


def directed_start(start: Sequence[arb], count: int) -> list[arb]:
    """The balls of a start without their derivatives, and 1 for each parameter."""
    return beside_parameters([ball(value) for value in start], [arb(1)] * count)


def dual_state(motion: Followed, t: arb, start: Sequence[arb], count: int) -> list[arb]:
    """The coordinates of the mode at t, with their derivatives by the parameters.

    dy_i/dp_k is the sum of dy_i(t)/dy_j(0) dy_j(0)/dp_k over j, and of dy_i(t)/dd_k. `motion` is
    that of the directed modes, `start` has the dual balls of the start of the modes themselves.
    """
    state = motion.at(t)
    table = motion.jacobian(t).table()
    no_slopes = (arb(0),) * count
    with precision(motion.bits + GUARD):
        duals: list[arb] = []
        for value, row in zip(inner(state, count), inner(table, count), strict=True):
            slopes = list(row[-1 - count : -1])
            for by_start, one in zip(inner(row, count), start, strict=True):
                of_start = slopes_of(one) or no_slopes
                slopes = [
                    slope + by_start * other for slope, other in zip(slopes, of_start, strict=True)
                ]
            duals.append(DualBall(value, slopes))
    return duals
