"""Witness of the impact of a box's corner: the unknowns of the impact from a linear system, its
time by bisection, all corners by rotations in the complex plane.

The formulas of the truth are not used. Right after the impact the velocity, the angular velocity
and the impulse P obey

    m (v' - v) = P e_y,   I (omega' - omega) = r x P e_y,   vy' + omega' r_x = -e (vy + omega r_x),

which elimination solves. I is the integral of |r|^2 over the box by Gauss's rule with two points
a side, which is exact for squares.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import acb, arb, arb_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness

METHOD = (
    "balance equations of the body and of the contact by elimination, time of impact by bisection,"
    " unproven (refdem/truth/witnesses/corner_impact.py)"
)
HALVINGS = 300
"""Bisections of the time of impact: 2^-300 of the interval is beyond the bits of a cross-check."""


def corner(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The scalars, and the quantities at the times."""
    a, b = (arb_of(side) for side in vector(p, "sides"))
    angle = arb_of(number(p, "angle"))
    vx, vy = (arb_of(speed) for speed in vector(p, "velocity"))
    height = arb_of(number(p, "height"))
    arms = [turned(acb(i * a / 2, j * b / 2), angle) for i in (-1, 1) for j in (-1, 1)]
    lowest = min(arms, key=lambda arm: float(arm.imag))
    impact = bisected(height + lowest.imag, vy)
    mass = arb_of(number(p, "mass"))
    restitution = arb_of(number(p, "restitution"))
    moment = mass * mean_square(a, b)
    # Unknown: vy', omega', P.
    balance = arb_mat([[mass, 0, -1], [0, moment, -lowest.real], [1, lowest.real, 0]])
    known = arb_mat([[mass * vy], [arb(0)], [-restitution * vy]])
    rise, omega, impulse = (row[0] for row in balance.solve(known).tolist())
    lost = (mass * (vy * vy - rise * rise) - moment * omega * omega) / 2
    yield None, {"impact_time": impact, "normal_impulse": impulse, "energy_lost": lost}
    for t in times:
        now = arb_of(t)
        if now < impact:
            y, speed, rate, theta = height + vy * now, vy, arb(0), angle
        else:
            since = now - impact
            y = height + vy * impact + rise * since
            speed, rate, theta = rise, omega, angle + omega * since
        place = {"x": vx * now, "y": y, "vx": vx, "vy": speed}
        yield t, place | {"theta": theta, "omega": rate}


def turned(place: acb, angle: arb) -> acb:
    """A place in the complex plane, turned about 0 by an angle [rad]."""
    return place * acb(0, angle).exp()


def mean_square(a: arb, b: arb) -> arb:
    """The mean of |r|^2 over a rectangle with sides a and b, by Gauss's rule of two points."""
    node = arb(3).sqrt() / 6
    total = arb(0)
    for i in (-1, 1):
        for j in (-1, 1):
            total += (i * node * a) ** 2 + (j * node * b) ** 2
    return total / 4


def bisected(gap: arb, speed: arb) -> arb:
    """The time [s] at which a gap [m] that changes by `speed` [m/s] is closed."""
    low, high = arb(0), arb(1)
    while gap + speed * high > 0:
        high = 2 * high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if gap + speed * middle > 0:
            low = middle
        else:
            high = middle
    return low.union(high)


WITNESSES = {"corner-impact": Witness(METHOD, corner)}
