"""Oblique contact of spheres that stick and slip: against vectors with the switches found anew,
planted faults, displaced starts.
"""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from flint import arb

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.two_spheres import MOVED, TwoSpheres
from refdem.truth.contact_phases import ContactPhases
from refdem.truth.witnesses.collisions import Spheres, first_switch, two_spheres
from refdem.truth.witnesses.taylor import Solution

PARTS = (Fraction(1, 64), Fraction(3, 8), Fraction(5, 8), Fraction(15, 16), Fraction(9, 8))
UNEQUAL = {"masses": "1,3", "radii": "1/2,3/4"}
SPUN = UNEQUAL | {"spins": "0,0,1,0,0,-2"}
SPRING = {"tangential_stiffness": "256/7", "friction": "1/2"}
CONTACTS = [
    (SPRING | SPUN | {"damping": "1", "angle": "0.008727", "branch": "R"}, "slip, pull, release"),
    (SPRING | {"angle": "1.48353", "branch": "R-d", "damping": "0", "friction": "2"}, "release"),
    (
        {"damping": "1", "angle": "1/2", "friction": "1/4", "tangential_stiffness": "96"} | SPUN,
        "slip, stick, slip back, pull, release",
    ),
    (
        {
            "angle": "-1/2",
            "friction": "1/4",
            "damping": "4",
            "cutoff": "zero_force",
            "branch": "R-d",
        }
        | UNEQUAL,
        "stick, slip back, release",
    ),
    (
        {"angle": "1/2", "friction": "1/4", "damping": "0", "branch": "R"} | SPUN,
        "stick, slip, release",
    ),
    (
        {"spins": "0,0,3,0,0,-2", "friction": "1/8", "damping": "1/100", "branch": "R-d"} | UNEQUAL,
        "stick, slip back, pull, release",
    ),
    (
        {
            "damping": "1",
            "angle": "1/2",
            "friction": "1/4",
            "tangential_stiffness": "96",
            "branch": "slip-R",
        }
        | SPUN,
        "slip, stick, slip back, pull, release",
    ),
    (
        {"angle": "1/2", "friction": "1/4", "damping": "0", "branch": "slip-R"} | SPUN,
        "stick, slip, release",
    ),
]


@cache
def said(number):
    """What the witness says at parts of the duration."""
    instance = discovery.case("two-spheres").at(**CONTACTS[number][0])
    duration = instance.truth().scalars()["duration"].mid
    times = [Fraction(round(float(duration * part) * 2**24), 2**24) for part in PARTS]
    with precision(256):
        found = dict(two_spheres(instance.p, times, {"duration": duration}))
    assert len(found) == len(times) + 1
    return found


def apart(number):
    """How far truth and witness are apart, of everything that the witness says, and the names of
    the switches.
    """
    truth = discovery.case("two-spheres").at(**CONTACTS[number][0]).truth()
    with precision(256):
        balls = [
            (truth.at(t) if t else truth.scalars(), values) for t, values in said(number).items()
        ]
        worst = max(
            abs(v - arb_of(ball[name].mid)) for ball, values in balls for name, v in values.items()
        )
    return float(worst), ", ".join(event.name for event in truth.motion(192).events)


@pytest.mark.parametrize("number", range(len(CONTACTS)))
def test_stick_and_slip_are_those_of_vectors_with_the_switches_found_anew(number):
    worst, switches = apart(number)
    assert switches == CONTACTS[number][1]
    assert worst < 1e-40


def falls_slower(self, y):
    return y[1] * self.k


def no_bend(self, y):
    r = 1 - y[0] * self.eps
    (first, second) = self.levers(y)
    return (
        -y[1]
        * y[3]
        / (r * r)
        * self.eps
        / (1 + first * first * self.ease[0] + second * second * self.ease[1])
    )


PLANTED = {
    "a limit whose rate forgets the dashpot": (2, "steepening", falls_slower),
    "levers of full size": (2, "levers", lambda self, y: [1 + 0 * y[0], 1 + 0 * y[0]]),
    "a slip without the second spin": (
        2,
        "slip",
        lambda self, y: y[3] / (1 - y[0] * self.eps) - self.levers(y)[0] * y[4],
    ),
    "a spring of half the stiffness": (2, "pull", lambda self, y: y[6] * self.kt),
    "a spring that pushes on": (2, "pull", lambda self, y: y[6] * (-2 * self.kt)),
    "no centrifugal force": (4, "falling", lambda self, y: -self.force(y)),
    "a hold that forgets the growing levers": (5, "holding", no_bend),
    "a hold that any friction can give": (5, "excess", lambda self, y: arb(1)),
    "a slip that never sticks": (2, "lag", lambda self, y, side: 1 + 0 * y[0]),
    "a clipped spring that is lost": (
        2,
        "caught",
        lambda self, side: ContactPhases.stretched(self, (), 0, False),
    ),
    "spins in units of a speed that is off": (4, "units", None),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_fault_is_seen(monkeypatch, name):
    number, what, wrong = PLANTED[name]
    said(number)
    if wrong is None:
        plain = TwoSpheres.units
        monkeypatch.setattr(
            TwoSpheres, what, lambda self: [*plain(self)[:4], *reversed(plain(self)[4:])]
        )
    else:
        monkeypatch.setattr(ContactPhases, what, wrong)
    try:
        worst, _ = apart(number)
    except (NotCertifiedError, ValueError, KeyError):
        return
    assert worst > 1e-12


def after_first_switch(pair, start, t):
    first = pair.begin(start)
    solution = Solution(pair.field(pair.law(first)), start)
    then, end = first_switch(solution, pair.ends(first), 0.0, 0.02)
    second, state = pair.after(first, then, solution.at(end))
    return Solution(pair.field(pair.law(second)), state, begin=end).at(t)[:6]


def test_sensitivity_is_the_largest_row_of_displaced_motions_through_a_switch():
    instance = discovery.case("two-spheres").at(**CONTACTS[2][0])
    truth = instance.truth()
    pair = Spheres(instance.p)
    tiny = 1e-20
    t = Fraction(1, 64)  # past the first slip, at 0.01 s
    with precision(256):
        places = [truth.at(Fraction(0))[name].mid for name in MOVED]
        start = [arb_of(places[i] - places[4 + i]) for i in range(4)] + [
            arb_of(places[8]),
            arb_of(places[9]),
            arb(0),
        ]
        columns = []
        for axis in range(6):
            ends = []
            for sign in (1, -1):
                displaced = [
                    value + sign * arb(tiny) * (i == axis) for i, value in enumerate(start)
                ]
                ends.append(after_first_switch(pair, displaced, t))
            columns.append([float((a - b) / (2 * tiny)) for a, b in zip(*ends, strict=True)])
    relative = np.array(columns).T
    (m1, m2) = (0.25, 0.75)
    whole = np.zeros((10, 10))
    carried = np.eye(4) + float(t) * np.eye(4, k=2)
    whole[:4, :4] = m1 * carried + m2 * relative[:4, :4]
    whole[:4, 4:8] = m2 * carried - m2 * relative[:4, :4]
    whole[4:8, :4] = m1 * carried - m1 * relative[:4, :4]
    whole[4:8, 4:8] = m2 * carried + m1 * relative[:4, :4]
    whole[:4, 8:] = m2 * relative[:4, 4:]
    whole[4:8, 8:] = -m1 * relative[:4, 4:]
    whole[8:, :4] = relative[4:, :4]
    whole[8:, 4:8] = -relative[4:, :4]
    whole[8:, 8:] = relative[4:, 4:]
    sizes = np.array([instance.quantities[name].scale for name in MOVED])
    growth = float(np.max(np.abs(whole) @ sizes / sizes))
    assert growth <= truth.sensitivity(t) * (1 + 1e-9)
    assert truth.sensitivity(t) <= 1.3 * growth
