"""Motions through events hold what they must (guards.py); then bugs planted there, every one of
which some guard must see.
"""

import pytest
from flint import arb

from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, unit_matrix
from refdem.truth.closed_forms import stick_slip
from refdem.truth.events import crossing, phase, system
from refdem.truth.events import motion as motions
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.phase import Phase
from tests.truth.events import systems
from tests.truth.events.guards import GUARDS


@pytest.mark.parametrize("guard", GUARDS)
def test_motions_through_events_as_they_are_raise_no_alarm(guard):
    guard()


def every_guard():
    """All of them, one after another."""
    for guard in GUARDS:
        guard()


def positive_middle(watched, low, high):
    """The first crossing as the signs at the ends of the window alone tell it."""
    if watched.value(high) > 0:
        return None
    return crossing.only_zero(watched, low, high)


def accepted(watched, low, high):
    """What cannot be decided is no crossing."""
    try:
        return FIRST(watched, low, high)
    except SwitchError:
        return None


def first_listed(guards, low, high):
    """The first guard in the list that crosses."""
    found = [(watched.name, CROSSING(watched, low, high)) for watched in guards[:1]]
    return next((one for one in found if one[1] is not None), None) or EARLIEST(
        guards[1:], low, high
    )


def by_midpoints(guards, low, high):
    """Overlapping crossings in the order of their midpoints."""
    found = [
        (watched.name, when)
        for watched in guards
        if (when := accepted(watched, low, high)) is not None
    ]
    return min(found, key=lambda one: float(one[1].mid()), default=None)


def point_crossing(self):
    """The event at one time, with the states there."""
    guard, piece, since, _ = STATES(self)
    return guard, piece, since.mid(), piece.at(since.mid())


def newton_at_a_point(watched, low, high):
    """Newton with the rate at the middle."""
    middle = low.union(high).mid()
    for _ in range(20):
        middle = (middle - watched.value(middle) / watched.rate(middle)).mid()
    return middle


def thin_watched(self, piece, name, touching=0, *, whole=True):
    """The guard along the exact centre, for the set."""
    return WATCHED(self, piece, name, touching, whole=False)


def middle_watched(self, piece, name, touching=0, *, whole=True):
    """Each interval of times by its middle."""
    found = WATCHED(self, piece, name, touching, whole=whole)
    return crossing.Watched(
        name, [lambda since, rate=rate: rate(since.mid()) for rate in found.rates], touching
    )


def without_touching(self, piece, name, touching=0, *, whole=True):
    """A stretch that begins at a zero taken as one that begins above."""
    return WATCHED(self, piece, name, 0, whole=whole)


def every_other_window(self, piece, low, high):
    """Windows are looked at in turn."""
    if int(high * 4) % 2:
        return None
    return FOUND(self, piece, low, high)


def stale(spread, jacobian, local, bits):
    """The set as it was before the step."""
    return spread


def principal(self, level, clock):
    """The arc cosine's principal branch alone."""
    if not abs(level) < abs(arb_of(self.gamma)):
        return NEXT(self, level, clock)
    angle = (level / arb_of(self.gamma)).acos()
    turn = 2 * arb.pi()
    turns = int(((arb_of(self.eta) * clock - angle) / turn).ceil().unique_fmpz())
    return (angle + turn * turns) / arb_of(self.eta) - clock


def last_turn(self, level, clock):
    """A release before the landing."""
    found = NEXT(self, level, clock)
    if found is None:
        return found
    return found - 2 * arb.pi() / arb_of(self.eta)


SECTION = Phase.section
STATES = Phase.crossing
WATCHED = Phase.watched
FOUND = Phase.event_in
NEXT = stick_slip.StickSlip.next_time
FIRST = CROSSING = crossing.first_crossing
EARLIEST = crossing.earliest
MOVED = phase.moved
ROWS = system.Traced.derivative_rows
ONLY = crossing.only_zero
LEAVES = stick_slip.StickSlip.leaves

# a bug: where, what stands there instead
BUGS = {
    "jump matrix forgotten": (
        Phase,
        "section",
        lambda self, guard, states, rate: unit_matrix(len(states)),
    ),
    "jump matrix with the wrong sign": (
        Phase,
        "section",
        lambda self, g, y, rate: SECTION(self, g, y, -rate),
    ),
    "jump matrix at a point of the set": (
        Phase,
        "section",
        lambda self, g, y, rate: SECTION(self, g, [x.mid() for x in y], rate.mid()),
    ),
    "event at a point of time": (Phase, "crossing", point_crossing),
    "reset not in the jacobian": (
        system.Traced,
        "derivative_rows",
        lambda self, f: ROWS(self, lambda y: list(y)),
    ),
    "set not moved through the event (stale step)": (phase, "moved", stale),
    "local error of the event forgotten": (
        phase,
        "moved",
        lambda s, v, local, bits: MOVED(s, v, [arb(0)] * len(local), bits),
    ),
    "set moved by the midpoint of the jump": (
        phase,
        "moved",
        lambda s, v, local, bits: MOVED(s, v.mid(), local, bits),
    ),
    "centre crosses where the set does": (
        Phase,
        "centre_time",
        lambda self, piece, guard, since: since.mid(),
    ),
    "grazing accepted": (crossing, "first_crossing", accepted),
    "signs at the ends only": (crossing, "first_crossing", positive_middle),
    "the guard listed first ends the mode": (phase, "earliest", first_listed),
    "two at once in the order of midpoints": (phase, "earliest", by_midpoints),
    "a second guard is not looked for": (
        phase,
        "earliest",
        lambda guards, low, high: EARLIEST(guards[:1], low, high),
    ),
    "newton with the rate at a point": (phase, "only_zero", newton_at_a_point),
    "newton for the set with the rate at a point": (crossing, "only_zero", newton_at_a_point),
    "newton stops after one turn at its middle": (
        crossing,
        "only_zero",
        lambda w, low, high: ONLY(w, low, high).mid(),
    ),
    "guard of the centre for the set": (Phase, "watched", thin_watched),
    "guard at the middle of an interval": (Phase, "watched", middle_watched),
    "zero at the entry forgotten": (Phase, "watched", without_touching),
    "zero at the entry not looked at": (crossing, "touches", lambda watched, begin: True),
    "every other window is skipped": (Phase, "event_in", every_other_window),
    "sign of the midpoint": (
        systems,
        "sign",
        lambda value, what: int(value.mid() > 0) - int(value.mid() < 0),
    ),
    "release on the principal branch only": (stick_slip.StickSlip, "next_time", principal),
    "release before the landing": (stick_slip.StickSlip, "next_time", last_turn),
    "never released": (stick_slip.StickSlip, "leaves", lambda self, y: None),
    "released on one side only": (
        stick_slip.StickSlip,
        "leaves",
        lambda self, y: _one_sided(self, y),
    ),
    "clocks of a set taken as equal": (
        Phase,
        "hull_at_entry",
        lambda self: [*HULL(self)[:-1], HULL(self)[-1].mid()],
    ),
    "state at the entry without its radius": (
        Phase,
        "hull_at_entry",
        lambda self: [value.mid() for value in HULL(self)],
    ),
    "changes at a time since the event": (
        motions,
        "at_fixed_time",
        lambda phase, state: unit_matrix(len(state)),
    ),
}
HULL = Phase.hull_at_entry


def _one_sided(self, y):
    since = self.next_time(y[0] + arb_of(2 * self.limit), y[2])
    if since is None:
        return None
    return ("forward", since)


@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_caught(bug, monkeypatch):
    """By a wrong bound, or because a motion that is certified is so no more."""
    place, name, wrong = BUGS[bug]
    monkeypatch.setattr(place, name, wrong)
    with pytest.raises(
        (AssertionError, UndecidedError, NotCertifiedError, ValueError, pytest.fail.Exception)
    ):
        every_guard()
