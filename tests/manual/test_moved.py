"""The lines of a page on what each number of a case moves, against motions known on paper."""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.manual import MovedLine
from refdem.manual.moved import moved_at, moved_lines


def lines_of(name: str, **given: str) -> dict[str, MovedLine]:
    return {line.number: line for line in moved_lines(discovery.case(name).at(**given))}


def test_a_uniform_motion_moves_by_the_time_times_its_velocity() -> None:
    """x = x0 + v t: dx/dv = t, and 1 % more of v moves x by v t/100."""
    instance = discovery.case("newtons-first-law").at()
    lines = lines_of("newtons-first-law")
    time = float(Fraction(moved_at(instance)))
    moving = {number: line for number, line in lines.items() if number.startswith("velocity")}
    assert moving
    for line in moving.values():
        assert line.quantity in ("x", "y", "z")
        assert line.slope == pytest.approx(time, rel=1e-3)
        if line.value:
            scale = instance.quantities[line.quantity].scale
            assert line.share == pytest.approx(abs(line.value) * time / scale, rel=1e-3)


def test_a_border_and_what_changes_nothing_are_told() -> None:
    lines = lines_of("coulomb-oscillator")
    assert not lines["v0"].has_derivative
    assert lines["gravity"].quantity == ""
    assert lines["mass"].quantity in ("x", "v")


def test_the_numbers_of_a_member_are_its_own() -> None:
    lines = lines_of("impact-benchmarks")
    assert lines["restitution"].value == 0.98
    assert lines["restitution"].quantity


def test_a_case_without_time_or_without_derivatives_has_no_lines() -> None:
    assert moved_lines(discovery.case("moments-of-inertia").at()) == ()
    assert moved_lines(discovery.case("granular-gas").at()) == ()
