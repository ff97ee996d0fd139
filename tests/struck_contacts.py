"""The growth of impulses that are made within a contact under the linear law, whose tangential
spring no quantity says: the motion goes on from displaced states of its phase.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np
from flint import arb, arb_mat

from refdem.truth.balls import arb_of, precision
from refdem.truth.collision import Collision
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.events.system import Entry

Array = np.ndarray
BITS = 192
"""Where coordinates are 0 but for a displacement, sets are known in parts of that: 63 bits go to
SIZE, and the doubles of all growths are those of 384 bits.
"""
SIZE = arb(10) ** -19
"""Of a displacement, in units of the phases."""


class Struck(ContactMotion):
    """A contact from a state within a mode on."""

    def __init__(self, contact: TracedContact, mode: str, state: Sequence[arb]) -> None:
        self.traced = contact
        self.parameters = 0
        with precision(BITS):
            self.begin(contact.modes, state, Entry(mode), BITS, None)


def doubles(matrix: arb_mat) -> Array:
    """The midpoints of a matrix of balls."""
    return np.array([[float(value.mid()) for value in row] for row in matrix.table()])


def by_displacement(places: Sequence[Sequence[arb]], count: int) -> Array:
    """The derivative of the first `count` coordinates of a place, from the place of a motion and
    those of displaced ones.
    """
    base, *moved = places
    columns = []
    for place in moved:
        changes = zip(place[:count], base[:count], strict=True)
        columns.append([float(((value - kept) / SIZE).mid()) for value, kept in changes])
    return np.array(columns).T


def passage(truth: Collision, begin: Fraction, end: Fraction) -> Array:
    """How errors of the relative motion, and of the spring, grow from one time [s] to another, in
    units of the phases: from the motions on from displaced states.
    """
    contact = truth.traced()
    motion = truth.motion(BITS)
    clock = truth.clock(begin)
    mode = motion.name(motion.phase(clock))
    count = truth.phases.size - 1
    with precision(BITS):
        state = [value.mid() for value in motion.at(clock)]
        state[-1] = arb_of(begin / truth.phases.time)
        states = [state]
        for place in range(count):
            states.append([*state[:place], state[place] + SIZE, *state[place + 1 :]])
        made = by_displacement([contact.place(mode, one) for one in states], count)
        runs = [Struck(contact, mode, one) for one in states]
        left = by_displacement([run.place(truth.clock(end)) for run in runs], count)
    passed: Array = left @ np.linalg.inv(made)
    return passed


def largest_growths(truth: Collision, times: Sequence[Fraction]) -> list[float]:
    """For each time [s] but the first, the largest growth of an impulse at those before it, in the
    quantities that S counts.

    Matrices from one time to the next multiply.
    """
    found = []
    grown: list[tuple[Fraction, Array]] = []
    for begin, end in pairwise(times):
        passed = passage(truth, begin, end)
        grown.append((begin, np.eye(len(passed))))
        grown = [(made_at, passed @ matrix) for made_at, matrix in grown]
        growths = [of_bodies(truth, matrix, end - made_at) for made_at, matrix in grown]
        found.append(max(float(np.abs(growth).sum(axis=1).max()) for growth in growths))
    return found


def of_bodies(truth: Collision, relative: Array, lasts: Fraction) -> Array:
    """The growth of errors in the quantities that S counts, in scales, from that of the relative
    motion in units of the phases; the centre of mass moves uniformly for so long [s].
    """
    count = len(relative)
    units = np.ones(count)
    own_units = [float(unit) for unit in truth.units()][:count]
    units[: len(own_units)] = own_units
    drifting = len(truth.drifting())
    both = np.eye(count + drifting)
    both[:count, :count] = relative * units[:, None] / units[None, :]
    for position in range(count, count + drifting // 2):
        both[position, position + drifting // 2] = float(lasts)
    with precision(BITS):
        bodies = doubles(truth.bodies())
        scales = np.array([float(scale.mid()) for scale in truth.scales_of_coordinates()])
    growth = bodies @ both @ np.linalg.inv(bodies)
    counted = len(truth.counted())
    in_scales: Array = growth * scales[None, :] / scales[:, None]
    return in_scales[:counted, :counted]
