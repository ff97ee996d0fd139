"""The derivative of a smooth flow by its start, and S of a motion that solves an equation.

A closed form takes `derivative_by_start`, or that of from_rest.py, as its method `jacobian`;
whatever has a derivative by the start, of whatever family, is `Variational`.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, Protocol, Self, runtime_checkable

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.closed_form import DISPLACEMENT
from refdem.truth.energy_growth import EnergyGrowth, Line
from refdem.truth.growth import Grows, Growth, PeriodicGrowth


class Equation(Protocol):
    """A motion given by the equation that it solves, as a closed form needs it
    (validated_flow.py).
    """

    @property
    def state(self) -> Sequence[str]:
        """The names of the state's coordinates."""

    def growth(self) -> Growth:
        """S of the motion, from the variational equation."""

    def readings_at(self, y: Sequence[arb]) -> arb_mat:
        """d quantity_i/scale_i over d state_j/scale_j at a state y."""


@runtime_checkable
class Variational(Protocol):
    """A truth with derivatives with respect to the initial state."""

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j, with the state as the first rows."""


class Displaceable(Protocol):
    """A closed form whose start can be displaced, as central differences need it."""

    @property
    def state(self) -> tuple[str, ...]: ...

    @property
    def scale(self) -> Mapping[str, Fraction]: ...

    @property
    def kept(self) -> dict[Any, Any]: ...

    def displaced(self, axis: int, amount: Fraction, /) -> Self: ...

    def evaluate(self, t: arb) -> dict[str, arb]: ...


def derivative_by_start(form: Displaceable, t: Fraction) -> arb_mat:
    """d quantity_i(t)/scale_i over d start_j/scale_j by central differences, with `state` as the
    first rows: the method `jacobian` of a closed form whose state is among its quantities.
    """
    # dq_i/dy_j = (q_i(t; y + d e_j) - q_i(t; y - d e_j))/(2 d), d = DISPLACEMENT scales of y_j.
    columns = [scaled_changes(form, axis, arb_of(t)) for axis in range(len(form.state))]
    rows = [[column[i] for column in columns] for i in range(len(columns[0]))]
    return arb_mat(rows) / arb_of(2 * DISPLACEMENT)


def pair(form: Displaceable, axis: int) -> tuple[Any, Any]:
    """The two motions whose starts are displaced by +-DISPLACEMENT scales along one coordinate;
    kept for later calls.
    """
    if ("pair", axis) not in form.kept:
        amount = DISPLACEMENT * form.scale[form.state[axis]]
        form.kept["pair", axis] = form.displaced(axis, amount), form.displaced(axis, -amount)
    motions: tuple[Any, Any] = form.kept["pair", axis]
    return motions


def scaled_changes(form: Displaceable, axis: int, t: arb) -> list[arb]:
    """The difference of each quantity at t, in its scale, between the two motions of `pair`.

    Over 2 DISPLACEMENT it is a central difference. The quantities of `state` come first.
    """
    plus, minus = (displaced.evaluate(t) for displaced in pair(form, axis))
    names = [*form.state, *(name for name in plus if name not in form.state)]
    scale = form.scale
    return [(plus[name] - minus[name]) / arb_of(scale[name]) for name in names]


def growth_along(line: Line, scale: Mapping[str, Fraction], equation: Equation) -> Grows:
    """S of a motion of one degree of freedom, from the closed form of its neighbours (`line`).

    The derivatives of the quantities by the state are those of its `equation`.
    """
    place, speed = (scale[name] for name in equation.state)
    return EnergyGrowth(line, place, speed, equation.readings_at)


def growth_of_an_equation(equation: Equation, period: arb | None) -> Grows:
    """S from the equation that a motion solves, integrated to a low precision.

    With a `period`, after which the motion repeats, errors drift apart in proportion to time
    (PeriodicGrowth).
    """
    first = equation.growth()
    if period is None:
        return first
    return PeriodicGrowth(first, period)
