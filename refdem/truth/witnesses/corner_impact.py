"""Witness of the impact of a box's corner: velocities and impulse from a linear system, the time of
impact by bisection, the corners by rotations in the complex plane.

The formulas of the truth are not used. The vertical velocity vy' and the angular velocity omega'
after the impact and the impulse P e_y at the arm r of the lowest corner satisfy

    m (v' - v) = P e_y,   I (omega' - omega) = r x P e_y,   vy' + omega' r_x = -e (vy + omega r_x),

with omega = 0 before the impact; the system is solved by elimination. I = m <|r|^2>, the mean over
the box by Gauss's rule with two points in each direction, which is exact for squares.
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
    # The four arms (+-a/2, +-b/2) from the centre, turned by the angle; the lowest corner hits the
    # plane y = 0.
    arms = [turned(acb(i * a / 2, j * b / 2), angle) for i in (-1, 1) for j in (-1, 1)]
    lowest = min(arms, key=lambda arm: float(arm.imag))
    impact = bisected(height + lowest.imag, vy)
    mass = arb_of(number(p, "mass"))
    restitution = arb_of(number(p, "restitution"))
    # I = m <|r|^2>, the mean over the box.
    moment = mass * mean_square(a, b)
    # Unknowns (vy', omega', P):
    #     m vy' - P = m vy,   I omega' - r_x P = 0,   vy' + r_x omega' = -e vy
    balance = arb_mat([[mass, 0, -1], [0, moment, -lowest.real], [1, lowest.real, 0]])
    known = arb_mat([[mass * vy], [arb(0)], [-restitution * vy]])
    rise, omega, impulse = (row[0] for row in balance.solve(known).tolist())
    # The friction is 0, so that vx stays: loss = (m vy^2 - m vy'^2 - I omega'^2)/2.
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
    """The mean of |r|^2 over a rectangle with sides a and b, by Gauss's rule of two points.

    The nodes of the rule on a side s about 0 are +-s/(2 sqrt(3)) = +-s sqrt(3)/6.
    """
    node = arb(3).sqrt() / 6
    total = arb(0)
    for i in (-1, 1):
        for j in (-1, 1):
            total += (i * node * a) ** 2 + (j * node * b) ** 2
    return total / 4


def bisected(gap: arb, speed: arb) -> arb:
    """The root t [s] of gap + speed t = 0, for gap > 0 [m] and speed < 0 [m/s], by bisection."""
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
