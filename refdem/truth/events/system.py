"""A switching system as its author writes it (modes, guards that end them, entries into the next),
and its traced form.

The state's last coordinate is the clock: its rate is 1 in every mode, and no reset changes it. All
functions of a state use the operations of a traced field (refdem/truth/traced_field.py): + - * /,
methods sin, cos, exp, sqrt, and exact rational constants.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.truth.traced_field import NONE, Field, Node, Program, slope, traced

State = Sequence[arb]


@dataclass(frozen=True)
class Entry:
    """The way into a mode: its name, the state there, and those of its guards that vanish there.

    `mode` is None where the motion ends. `reset` gives the new state from the old one (by default
    the same); a coordinate that is zero on the section should be an exact 0 in it. `touching` has,
    for each guard of the new mode that vanishes at the entry, the order of that zero: the guard and
    its derivatives below that order are exactly 0 there for every motion, and the derivative of
    that order is proved > 0 on the first stretch.
    """

    mode: str | None
    reset: Field | None = None
    touching: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Guard:
    """A switching function: `value(y)` > 0 inside the mode, and its first zero ends it.

    `then(y)` receives balls that contain every state at the zero and returns the entry. It branches
    on `sign` (crossing.py), which raises UndecidedError where the balls do not have one sign (a
    corner). An event has the `name` of its guard: "stick" for one that begins a stick, and so on.
    """

    name: str
    value: Callable[[Sequence[Any]], Any]
    then: Callable[[State], Entry]


@dataclass(frozen=True)
class Mode:
    """A field with the guards that end it.

    `leaves(y)`, where there is a closed form, gets balls of the state at the entry and returns the
    name of the guard that ends the mode and a ball of the time since the entry at which it does, or
    None if the mode never ends; it raises UndecidedError where balls do not decide that.
    `window` [s] is about the time between sign changes of the guards: longer pieces are searched
    window by window. `stops(y)`, where the field has a singularity that motions run into, gets
    balls of a state and returns a bound of the time [s] after which all motions from there have run
    into it, or None where that is not proved.
    """

    field: Field
    guards: tuple[Guard, ...] = ()
    leaves: Callable[[State], tuple[str, arb] | None] | None = None
    window: Fraction = Fraction(1)
    stops: Callable[[State], arb | None] | None = None


class Traced:
    """A mode as programs: the field and its Jacobian; each guard with its derivatives in time, and
    its gradient.

    `size` is the number of coordinates of the state, the clock included; the last `parameters` of
    them before the clock stand for parameters (directed.py). `rates` makes the programs of a
    guard's derivatives in time (by default `lie_derivatives`). ValueError for a field of another
    size, or whose last rate is not the clock's 1.
    """

    def __init__(
        self, mode: Mode, size: int, rates: "GuardRates | None" = None, parameters: int = 0
    ) -> None:
        self.mode = mode
        self.size = size
        # Numbers of the coordinates that stand for parameters, before the clock.
        self.directions = range(size - 1 - parameters, size - 1)
        rates_of = rates or lie_derivatives
        # The rates of all coordinates, and the rows of the Jacobian of the field.
        outputs, rows = traced(mode.field, size, self.directions)
        # The last coordinate is the clock, whose rate is 1.
        if len(outputs) != size or outputs[-1].exact() != 1:
            raise ValueError(
                f"field of {len(outputs)} rates, the last {outputs[-1].operation}; expected {size},"
                " the last the clock's 1"
            )
        self.field = Program(outputs)
        self.slopes = Program([entry for row in rows for entry in row])
        self.rates = {}
        self.gradients = {}
        for guard in mode.guards:
            self.rates[guard.name] = rates_of(guard, mode, size, self.directions)
            self.gradients[guard.name] = self.derivative_rows(self._single(guard))

    def guard(self, name: str) -> Guard:
        """The guard that has the given name."""
        return next(guard for guard in self.mode.guards if guard.name == name)

    def derivative_rows(self, function: Field) -> Program:
        """The Jacobian of a function of the state."""
        return derivative_rows(function, self.size, self.directions)

    @staticmethod
    def _single(guard: Guard) -> Field:
        return lambda y: [guard.value(y)]


GuardRates = Callable[[Guard, Mode, int, range], list[Program]]
"""Programs of a guard's value and its first derivatives in time, in a mode whose states are of that
size, some of whose coordinates stand for parameters.
"""


def lie_derivatives(
    guard: Guard, mode: Mode, size: int, directions: range = NONE, highest: int = 4
) -> list[Program]:
    """Programs of the guard's value g and its derivatives in time up to the order `highest`.

    Along a field f they are the Lie derivatives: g^(0) = g, g^(n+1) = grad g^(n) . f.
    """
    nodes, _ = traced(lambda y: [guard.value(y), *mode.field(y)], size, directions)
    # The guard and the rates of the coordinates share one trace, so that their nodes combine.
    value, *rates = nodes
    derivatives = [value]
    for _ in range(highest):
        # g^(n+1) = grad g^(n) . f.
        derivatives.append(along(derivatives[-1], rates))
    return [Program([node]) for node in derivatives]


class TracedModes(dict[str, Traced]):
    """Modes as programs, each traced when it is entered."""

    def __init__(
        self, modes: Mapping[str, Mode], size: int, rates: GuardRates, parameters: int = 0
    ) -> None:
        super().__init__()
        self.modes = modes
        self.size = size
        self.rates = rates
        self.parameters = parameters

    def __missing__(self, name: str) -> Traced:
        self[name] = Traced(self.modes[name], self.size, self.rates, self.parameters)
        return self[name]


def along(node: Node, rates: Sequence[Node]) -> Node:
    """The derivative in time of a function g of the state: the sum over i of (dg/dy_i) y_i'."""
    total = node.trace.constant(0)
    for number, rate in enumerate(rates):
        total = total + slope(node, number) * rate
    return total


def unchanged(y: Sequence[Any]) -> list[Any]:
    """The reset of an entry without one: the state does not change."""
    return list(y)


def derivative_rows(function: Field, size: int, directions: range = NONE) -> Program:
    """The Jacobian of a function of `size` numbers, rows one after another."""
    _, rows = traced(function, size, directions)
    return Program([entry for row in rows for entry in row])
