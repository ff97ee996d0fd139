"""A motion that is started again from where it is goes on as it did; where nothing is lost, it goes
back with its rates reversed, and comes to its start.

The second start is the certified state, rounded to a decimal: what that is off may grow by S.
REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets, REFDEM_RANDOM_SEED which
ones.
"""

import random
from collections.abc import Mapping
from fractions import Fraction
from math import hypot

import pytest

from refdem.core import discovery
from refdem.core.truth import Ball
from tests.random_settings import SETTINGS, first_accepted, settings, written
from tests.two_truths import asked_at

DIGITS = 30
PLACES = 36
ERROR = 2
"""How much larger than an error of its quaternion that of a turn is, in radians."""
LINE = {"x0": "x", "v0": "v"}
RODS = {"theta0": "theta1 theta2", "thetadot0": "thetadot1 thetadot2"}
OMEGA = "omega_body.x omega_body.y omega_body.z"
BODY = {"omega_body": OMEGA, "attitude": "attitude.w attitude.x attitude.y attitude.z"}
WHEEL = {name + "0": name for name in ("r", "theta", "rdot", "thetadot")}
STARTS = {
    "harmonic-oscillator": LINE,
    "viscous-oscillator": LINE,
    "driven-oscillator": LINE,
    "coulomb-oscillator": LINE,
    "driven-duffing": LINE,
    "quadratic-response": LINE,
    "van-der-pol": LINE,
    "stick-slip": LINE,
    "asymmetric-field": LINE,
    "pendulum": {"theta0": "theta", "thetadot0": "thetadot"},
    "coupled-pendulums": RODS,
    "double-pendulum": RODS,
    "pendulum-wheel-mass": WHEEL,
    "free-rigid-body": BODY,
    "dissipating-body": {"omega_body": OMEGA},
    "whirling-shaft": {"x0": "x y", "v0": "vx vy"},
    "logistic": {"x0": "x_n"},
    "lorenz": {"start": "x y z"},
}
"""Parameters of a start, and the quantities that they are."""
UNDRIVEN = {
    "driven-oscillator": {"f0": "0"},
    "driven-duffing": {"f0": "0"},
    "quadratic-response": {"f0": "0,0"},
    "van-der-pol": {"p": "0"},
    "stick-slip": {"gamma": "0"},
}
"""Settings without a drive, which would be in another phase at another start."""
KEEPING = {
    "harmonic-oscillator": {},
    "driven-duffing": {"delta": "0"},
    "quadratic-response": {"delta": "0"},
    "asymmetric-field": {},
    "pendulum": {},
    "coupled-pendulums": {},
    "double-pendulum": {},
    "pendulum-wheel-mass": {},
    "free-rigid-body": {},
}
"""Settings in which nothing is lost."""
RATES = ("v", "thetadot", "thetadot1", "thetadot2", "rdot", *OMEGA.split())
ALSO_REVERSED = (*RATES, "omega.x", "omega.y", "omega.z")
TWO_SIGNS = "attitude"
"""A quaternion and its negative are one attitude; R has no such choice."""


class Again:
    """A setting, and the same motion started again from its state at `begin`."""

    def __init__(self, case: str, given: Mapping[str, str], *, back: bool) -> None:
        self.back = back
        self.first = discovery.case(case).at(**given)
        self.truth = self.first.truth().refined(DIGITS)
        self.begin = asked_at(self.first, self.truth)[-1]
        state = self.truth.at(self.begin)
        self.expected = self.when_it_arrives()
        self.uncertain: dict[str, Fraction] = {}
        start = {
            name: ",".join(self.decimal(state, quantity) for quantity in quantities.split())
            for name, quantities in STARTS[case].items()
        }
        self.second = discovery.case(case).at(**{**given, **start})

    def sign(self, name: str) -> int:
        """-1 for a rate on the way back."""
        if self.back and name in ALSO_REVERSED:
            return -1
        return 1

    def decimal(self, state: Mapping[str, Ball], name: str) -> str:
        """A quantity of the state at which the motion is started again; what it is off is noted."""
        ball = state[name]
        decimal = ball.decimals(PLACES)[0]
        self.uncertain[name] = abs(ball.mid - Fraction(decimal)) + ball.radius
        return str(self.sign(name) * Fraction(decimal))

    def when_it_arrives(self) -> Mapping[str, Ball]:
        """What the first motion has where the second is to arrive."""
        if self.back:
            return self.truth.at(Fraction(0))
        return self.truth.at(2 * self.begin)

    def error_at_start(self) -> float:
        """The length of what the second start is off, in the scales of that motion."""
        quantities = self.second.quantities
        return ERROR * hypot(*(float(r) / quantities[n].scale for n, r in self.uncertain.items()))

    def differences(self) -> list[str]:
        """Quantities in which both differ by more than S times what the start is off."""
        truth = self.second.truth().refined(DIGITS)
        arrived = truth.at(self.begin)
        allowed = truth.sensitivity(self.begin) * self.error_at_start()
        found = []
        for name in (name for name in self.expected if not name.startswith(TWO_SIGNS)):
            ball = self.expected[name]
            error = abs(self.sign(name) * ball.mid - arrived[name].mid)
            allowance = allowed * self.second.quantities[name].scale
            if error > ball.radius + arrived[name].radius + Fraction(allowance):
                found.append(
                    f"{self.first.label}, then {self.second.label}: {name} is off by"
                    f" {float(error):.3g}, allowed are {allowance:.3g}"
                )
        return found


def random_again(case: str, number: int, *, back: bool) -> Again:
    """A case at a random setting that can be started again."""
    fixed = UNDRIVEN.get(case, {})
    if back:
        fixed = {**fixed, **KEEPING[case]}

    def made(rng: random.Random) -> Again:
        return Again(case, written(case, settings(rng, case)) | fixed, back=back)

    return first_accepted(case, number, made)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(STARTS))
def test_a_motion_that_is_started_again_goes_on_as_it_did(case, number):
    assert random_again(case, number, back=False).differences() == []


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(KEEPING))
def test_a_motion_that_is_reversed_comes_back_to_its_start(case, number):
    assert random_again(case, number, back=True).differences() == []


def test_a_start_that_is_off_is_found():
    """The test of the test: damping, without which the way back is the way there."""
    given = written("viscous-oscillator", {"delta": "1/10"})
    assert len(Again("viscous-oscillator", given, back=True).differences()) == 2
