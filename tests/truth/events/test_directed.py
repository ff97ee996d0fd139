"""Derivatives of a motion through events by the parameters of its field, guard and reset."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from flint import arb

from refdem.truth.balls import precision
from refdem.truth.dual import ExactDual, parameters, slopes_of
from refdem.truth.events import directed, phase
from refdem.truth.events.phase import Phase
from refdem.truth.events.system import Entry, Guard, Mode
from refdem.truth.events.truth import HybridFlow
from refdem.truth.refiner import Refiner

HEIGHT, GRAVITY, FLOOR, RESTITUTION = Fraction(9, 4), Fraction(8), Fraction(1, 3), Fraction(4, 5)
VALUES = (HEIGHT, GRAVITY, FLOOR, RESTITUTION)
LATE = Fraction(1)
"""A time [s] after the first bounce, at about 0.69 s, and before the second."""


def dropped(height: Any, gravity: Any, floor: Any, restitution: Any) -> HybridFlow:
    """A ball that is dropped on a floor of that height and bounces."""
    bounce = Guard(
        "bounce",
        lambda y: y[0] - floor,
        lambda y: Entry(
            "fly", lambda y: [y[0] * 0 + floor, y[1] * -restitution, y[2]], {"bounce": 1}
        ),
    )
    return HybridFlow(
        {"fly": Mode(lambda y: [y[1], -gravity, 1], (bounce,))},
        (height, Fraction(0), Fraction(0)),
        lambda y: Entry("fly"),
        lambda y: {"y": y[0], "energy": y[1] * y[1] / 2 + y[0] * gravity},
        Refiner.of({"y": 1, "energy": 1}),
        state=("y", "energy"),
        moved=(0, 1),
    )


def formula(height: Any, gravity: Any, floor: Any, restitution: Any) -> dict[str, Any]:
    """The same after one bounce: y = floor + e v s - g s^2/2 with s = t - v/g, v the speed of
    the fall.
    """
    speed = (2 * gravity * (height - floor)).sqrt()
    since = arb(int(LATE)) - speed / gravity
    place = floor + restitution * speed * since - gravity * since * since / 2
    velocity = restitution * speed - gravity * since
    return {"y": place, "energy": velocity * velocity / 2 + place * gravity}


def derivatives() -> dict[str, tuple[Any, ...]]:
    """Those of the flow, by its four numbers."""
    numbers = []
    for k, value in enumerate(VALUES):
        numbers.append(ExactDual(value, [int(k == other) for other in range(len(VALUES))]))
    return dropped(*numbers).derivatives(LATE, len(VALUES))


def are_those_of_the_formula() -> bool:
    with precision(200):
        numbers = parameters([arb(v.numerator) / v.denominator for v in VALUES])
        expected = formula(*numbers)
        found = derivatives()
        for quantity, value in expected.items():
            for slope, ball in zip(slopes_of(value), found[quantity], strict=True):
                near = arb(ball.mid.numerator) / ball.mid.denominator
                if not abs(slope - near) < arb(10) ** -38:
                    return False
    return True


def test_a_bounce_carries_derivatives_by_field_guard_reset_and_start() -> None:
    assert are_those_of_the_formula()


def _guard_without(guard: Guard, count: int) -> Guard:
    """A directed guard that does not know its parameters."""
    return replace(DIRECTED(guard, count), value=lambda y: y[0] - FLOOR)


def _entry_without(entry: Entry, count: int) -> Entry:
    """An entry whose reset does not know its parameters."""
    return replace(ENTRY(entry, count), reset=lambda y: [y[0], y[1] * -RESTITUTION, *y[2:]])


DIRECTED = directed.directed_guard
ENTRY = directed.directed_entry
FAULTS: dict[str, tuple[Any, str, Callable[..., Any]]] = {
    "guard without its parameters": (directed, "directed_guard", _guard_without),
    "reset without its parameters": (directed, "directed_entry", _entry_without),
    "time of the event left out": (
        Phase,
        "section",
        lambda self, guard, states, rate: phase.unit_matrix(len(states)),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_derivative_that_leaves_out_a_part_is_seen(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(*FAULTS[fault])
    assert not are_those_of_the_formula()


def test_the_last_certified_state_of_a_motion_that_ends_has_no_parameters() -> None:
    """What a motion with parameters as coordinates says where it ends."""
    flow = dropped(*(ExactDual(value, (1,)) for value in VALUES))
    (name, *_), time = flow.last_state(directed.inner([arb(1), arb(2), arb(1), arb(3)], 1))
    assert (name, time) == ("y", 3.0)
