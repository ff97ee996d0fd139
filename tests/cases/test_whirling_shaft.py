"""The whirling shaft: what grows and what decays, beside the border that dissipation makes."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError

CASE = discovery.case("whirling-shaft")


def amplitudes(**given: str) -> np.ndarray:
    """The distance (T,) [m] from the axis in the reference."""
    problem = CASE.at(duration="40", samples="81", **given).problem
    run, _ = ENGINE.run(Request(problem=problem, method="exact-whirl"))
    found: np.ndarray = np.linalg.norm(run.position[:, 0], axis=1)
    return found


def test_damping_makes_unstable_what_was_stable_without_any() -> None:
    """At twice the border: without damping, with damping outside alone, and with damping inside."""
    undamped = amplitudes(turning="6", outer_damping="0", inner_damping="0")
    outside = amplitudes(turning="6", inner_damping="0")
    inside = amplitudes(turning="6")
    assert 0.4 < undamped[-20:].max() < 1.2
    assert outside[-20:].max() < 0.02
    assert inside[-20:].max() > 1e3


@pytest.mark.parametrize(("turning", "grows"), [("2.9", False), ("3.1", True), ("-3.1", True)])
def test_the_border_is_where_the_amplitude_begins_to_grow(turning: str, grows: bool) -> None:
    found = amplitudes(turning=turning)
    assert bool(found[-20:].max() > found[-40:-20].max()) is grows


def test_damping_outside_moves_the_border_up() -> None:
    for outer, border in (("0", 2), ("1/2", 3), ("3", 8)):
        scalars = CASE.at(outer_damping=outer).truth().scalars()
        assert scalars["border"].mid == border


def test_the_duration_is_20_radians_or_8_e_folds() -> None:
    assert CASE.at().scales.duration == 10.0
    fast = CASE.at(inner_damping="40", turning="50")
    rate = float(fast.truth().scalars()["growth_rate"].mid)
    assert rate > 2
    assert fast.scales.duration == pytest.approx(8 / rate, rel=1e-12)


def test_a_start_at_rest_on_the_axis_is_refused() -> None:
    with pytest.raises(UsageError, match="x0"):
        CASE.at(x0="0,0", v0="0,0")


def test_what_is_turned_by_a_quarter_is_the_same_motion() -> None:
    first = CASE.at(x0="1/3,2", v0="-1,5/7").truth().at(Fraction(3))
    turned = CASE.at(x0="-2,1/3", v0="-5/7,-1").truth().at(Fraction(3))
    for name, other, sign in (("x", "y", 1), ("y", "x", -1), ("vx", "vy", 1), ("vy", "vx", -1)):
        assert abs(turned[other].mid - sign * first[name].mid) < Fraction(1, 10**38)


def test_only_methods_that_know_the_fluid_answer() -> None:
    problem = CASE.at().problem
    answering = {m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None}
    assert answering == {"exact-whirl"}
