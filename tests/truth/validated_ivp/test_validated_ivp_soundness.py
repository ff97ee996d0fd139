"""The guards against the integrator as it is, and against planted bugs: which guard kills which is
the table planted_bugs.txt.
"""

from pathlib import Path

import pytest
from flint import arb

from refdem.truth.balls import UndecidedError
from refdem.truth.validated_ivp.integration import Integration
from tests.truth.validated_ivp.fields import at, decay, squares
from tests.truth.validated_ivp.ivp_guards import GUARDS as OTHERS
from tests.truth.validated_ivp.ivp_package import MODULES, package
from tests.truth.validated_ivp.ivp_set_guards import SET_GUARDS

GUARDS = [*OTHERS, *SET_GUARDS]


@pytest.mark.parametrize("guard", GUARDS)
def test_the_integrator_as_it_is_raises_no_alarm(guard):
    guard(package())


def test_the_state_of_a_low_order_is_a_ball_that_is_not_empty():
    assert at(decay, [1], "1/4", order=1)[0].rad() > 1e-4


def test_a_motion_into_a_pole_is_certified_to_just_before_it():
    with pytest.raises(UndecidedError, match=r"enclosed up to t = 0\.99"):
        at(squares, [1], 2, bits=200)


def test_a_set_that_reaches_a_pole_is_undecided_at_this_precision():
    with pytest.raises(UndecidedError, match="too large"):
        Integration(squares, lambda: [arb(1, "0.01")], 64).at(arb(2))


def planted_bugs():
    """name: (module, text, what the bug makes of it, the guard that kills it), from triples of
    lines in planted_bugs.txt.
    """
    lines = (Path(__file__).parent / "planted_bugs.txt").read_text().splitlines()
    found = {}
    for head, old, new in zip(lines[::3], lines[1::3], lines[2::3], strict=True):
        name, module, guard = head.split(" | ")
        assert (old[:2], new[:2], name in found) == ("- ", "+ ", False)
        found[name] = module, old[2:], new[2:], guard
    return found


BUGS = planted_bugs()


def test_at_least_sixty_bugs_are_planted_in_every_module_and_every_guard_kills_one():
    assert len(BUGS) >= 60
    assert {bug[0] for bug in BUGS.values()} == set(MODULES)
    assert {bug[3] for bug in BUGS.values()} == {guard.__name__ for guard in GUARDS}


@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_killed_by_its_guard(bug):
    module, old, new, guard = BUGS[bug]
    planted = package(module, old, new)
    with pytest.raises((AssertionError, UndecidedError, pytest.fail.Exception)):
        next(claim for claim in GUARDS if claim.__name__ == guard)(planted)
