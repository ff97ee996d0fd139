"""pymunk's joints as shipped take out their drift at a rate in seconds, not in units of time.

`Constraint.error_bias` is 0.9**60 by default, the part of a drift that is left after one unit of
time. A pendulum in units of u seconds is here moved with the default, with error_bias to the power
u, which is the same rate, and with 0, which takes the whole drift out in every step: with the last
two it moves as in seconds: to the bit where u is a power of 2, and to roundings where it is not.
"""

import math

import pymunk

STEP = 1 / 64  # [s]: a power of 2, so that units of 2 s and 0.5 s round nothing
STEPS = 128  # 2 s, about a period of the pendulum


def motion(unit, bias):
    """Positions [m] and velocities [m/s] of a bob on a rod of 1 m, in units of `unit` seconds."""
    space = pymunk.Space()
    space.gravity = (0.0, -9.8125 * unit**2)
    bob = pymunk.Body(1.0, 1e9)
    bob.position = (math.sin(1.0), -math.cos(1.0))
    rod = pymunk.PinJoint(space.static_body, bob, (0, 0), (0, 0))
    rod.error_bias = bias
    space.add(bob, rod)
    found = []
    for _ in range(STEPS):
        space.step(STEP / unit)
        found += [*bob.position, *(bob.velocity / unit)]
    return found


def apart(unit, bias_of_seconds, bias):
    """The largest difference of the motion in these units from that in seconds."""
    pairs = zip(motion(1.0, bias_of_seconds), motion(unit, bias), strict=True)
    return max(abs(a - b) for a, b in pairs)


default = 0.9**60  # Constraint.error_bias as pymunk comes, to a digit less
for unit in (2.0, 0.5, 0.25, 3.0, 1 / 3, 0.1):
    print(
        f"units of {unit:.3g} s: apart by {apart(unit, default, default):.1e} with the default,"
        f" {apart(unit, default, default**unit):.1e} with the same rate,"
        f" {apart(unit, 0.0, 0.0):.1e} with 0"
    )
