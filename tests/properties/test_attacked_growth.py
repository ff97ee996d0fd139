"""S(t) attacked: the truth of a displaced start, compared with that of the start itself, is never
further off than S says, whatever the case, the setting, the direction and the time.

REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets, REFDEM_RANDOM_SEED which
ones, REFDEM_RANDOM_LOOKS (16 for a night) at how many times motions are compared,
REFDEM_RANDOM_COORDINATES (100 for a night) how many coordinates a start may have that all are
displaced.
"""

import random
from collections.abc import Mapping
from fractions import Fraction

import pytest

from refdem.core import discovery
from tests.attack import BODIES, LOOKS, MARGIN, MAX_OVERESTIMATE, Attack
from tests.displaced import has_displaced_starts
from tests.properties.test_started_again import STARTS, Again, random_again
from tests.random_settings import NAMES, SETTINGS, first_accepted, settings, written

NOT_ATTACKED = {
    "block-on-slope": "its start is rest, and no parameter",
    "degrees-of-freedom": "no time",
    "granular-gas": "a law of means",
    "moments-of-inertia": "no time",
    "newtons-first-law": "its scales and its motion are those of a uniform motion",
    "quaternions": "no time",
    "rotations": "no time",
}

NOTHING: Mapping[str, str] = {}
ATTACKED = sorted(case for case in set(NAMES) - set(NOT_ATTACKED) if has_displaced_starts(case))
MANY_LOOKS = max(16, LOOKS)
"""Times at which the largest growths are searched: impulses at a few do not show them."""
SHARP = (
    "asymmetric-field",
    "billiard-break",
    "billiards",
    "bouncing-ball",
    "captured-mass",
    "coulomb-oscillator",
    "coupled-pendulums",
    "dissipating-body",
    "double-pendulum",
    "driven-duffing",
    "driven-oscillator",
    "duffing",
    "hard-wall",
    "harmonic-oscillator",
    "heavy-top",
    "hertz-spheres",
    "kapitza-pendulum",
    "logistic",
    "newtons-cradle",
    "pendulum",
    "pendulum-equilibria",
    "pendulum-wheel-mass",
    "phase-flow",
    "power-oscillator",
    "quadratic-drag",
    "quadratic-response",
    "rolling",
    "two-body-orbit",
    "van-der-pol",
    "viscous-oscillator",
    "wedge-collision",
    "whirling-shaft",
)
"""Cases without bodies whose largest growths are found: their attacks span all errors."""
SHARP_LOOKS = max(32, LOOKS)
"""Times for those: where S rises fast the impulse that grows most is made in a short interval."""
SHARP_AT = {"billiard-break": {"rows": "2"}}
"""Settings of sharp attacks that leave so few coordinates that all are displaced: 4 balls of 16."""
FEWEST = 39
"""Cases that are attacked, of those that are files of refdem itself."""


def test_no_case_drops_out_of_the_attack():
    assert len(ATTACKED) >= FEWEST


def random_attack(
    case: str, number: int, looks: int = LOOKS, fixed: Mapping[str, str] = NOTHING
) -> Attack:
    """A case at a random setting, but for what is fixed, attacked in random directions."""

    def made(rng: random.Random) -> Attack:
        return Attack(case, written(case, settings(rng, case)) | fixed, rng, looks=looks)

    return first_accepted(case, number, made)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", ATTACKED)
def test_no_displacement_grows_by_more_than_s(case, number):
    assert random_attack(case, number).violations() == []


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(set(BODIES) - {"neglected-gyroscopic"}))
def test_s_of_a_body_is_at_most_1_4_times_the_largest_growth_that_is_found(case, number):
    attack = random_attack(case, number, MANY_LOOKS)
    assert attack.violations() == []
    assert attack.overestimates() == []


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", SHARP)
def test_s_is_at_most_1_4_times_the_largest_growth_that_is_found(case, number):
    attack = random_attack(case, number, SHARP_LOOKS, SHARP_AT.get(case, NOTHING))
    assert attack.overestimates() == []


def attack_in_the_middle(again: Again) -> Attack:
    """The motion from the state that another has at `again.begin`, attacked there, where impulses
    reach what those of the first start have lost: after a stop they all are in one direction.
    """
    case = again.first.case.id
    rng = random.Random(again.second.label)
    return Attack(case, again.second.p.texts(), rng, counted_as=again.first)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(set(STARTS) - {"logistic"}))
def test_no_displacement_in_the_middle_grows_by_more_than_s_since_the_start(case, number):
    again = random_again(case, number, back=False)
    attack = attack_in_the_middle(again)
    assert attack.violations_of(again.truth, again.begin) == []


def test_an_s_that_is_too_small_is_found():
    """The test of the test: half of the S of a pendulum, and of a body whose turns are read."""
    for case in ("pendulum", "free-rigid-body"):
        attack = Attack(case, written(case, {}), random.Random(1))
        assert attack.violations() == []
        assert len(attack.violations(part=0.5)) >= LOOKS - 1


def test_a_tenth_of_the_s_of_a_cluster_cannot_be_spared():
    attack = Attack("rigid-cluster", written("rigid-cluster", {}), random.Random(1), looks=16)
    assert attack.violations() == []
    assert attack.violations(part=0.9)


def test_s_after_a_stop_is_at_most_1_4_times_what_impulses_just_before_it_grow_to():
    """A stop leaves one direction of the errors made before it: impulses made anew show the other
    one, which grows to 338; of errors made at the start 97 are left.
    """
    given = written("stick-slip", {"a": "23.59", "lambda1": "0.02301", "gamma": "0"})
    case = discovery.case("stick-slip")
    first = case.at(**given)
    truth = first.truth()
    end = Fraction("6.196574")
    struck = [end * part / 26 for part in (1, 20, 21)]
    growths = []
    for begin in struck:
        state = truth.at(begin)
        start = {"x0": rounded(state["x"].mid), "v0": rounded(state["v"].mid)}
        rng = random.Random(1)
        times = [Fraction(0), end - begin]
        anew = Attack("stick-slip", {**given, **start}, rng, counted_as=first, times=times)
        growths += anew.growths(1)
    bound = truth.sensitivity(end)
    assert max(growths) <= bound * (1 + MARGIN)
    assert bound <= MAX_OVERESTIMATE * max(growths)


def rounded(value: Fraction) -> str:
    """The text of a number near `value` that a parameter may be."""
    return str(round(value, 12))
