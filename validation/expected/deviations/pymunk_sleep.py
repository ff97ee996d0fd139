"""pymunk's sleeping, once a user turns it on, stops a pendulum where it turns round.

A bob of 1 kg on a rod of 1 m is let go at 1 rad, in steps of 1/1024 s. A body sleeps that has been
slower than `Space.idle_speed_threshold` for `Space.sleep_time_threshold`, whatever forces act on
it. At the turning point the bob is slower than v for 2 v/(g sin 1), and at the start, from rest,
for half of that: it falls asleep where this is longer than the threshold, at the start or at the
first turning point, and hangs there in the air. A higher speed, a shorter time or a smaller g puts
it to sleep; with infinite time, as shipped, it swings on.

pymunk's documentation says of sleep_time_threshold: "Time a group of bodies must remain idle in
order to fall asleep. The default value of `inf` disables the sleeping algorithm."
"""

import math

import pymunk

STEP = 1 / 1024  # [s]: a hundredth of the shortest threshold


def stopped(time, speed, gravity=9.8125):
    """When [s] the pendulum falls asleep within 8 s, or 0 if it does not; its angle [rad] then."""
    space = pymunk.Space()
    space.gravity = (0.0, -gravity)
    space.sleep_time_threshold = time
    space.idle_speed_threshold = speed
    bob = pymunk.Body(1.0, 1e9)
    bob.position = (math.sin(1.0), -math.cos(1.0))
    rod = pymunk.PinJoint(space.static_body, bob, (0, 0), (0, 0))
    space.add(bob, rod)
    slept = 0.0
    for step in range(1, round(8 / STEP) + 1):
        space.step(STEP)
        if bob.is_sleeping:
            slept = step * STEP
            # Freeing a space whose body sleeps may end the process.
            bob.activate()
            break
    return slept, math.atan2(bob.position.x, -bob.position.y)


for time, speed, gravity in (
    (math.inf, 0.5, 9.8125),
    (0.2, 0.5, 9.8125),
    (0.1, 0.5, 9.8125),
    (0.05, 0.5, 9.8125),
    (0.1, 0.2, 9.8125),
    (0.1, 1.0, 9.8125),
    (0.2, 0.5, 1.625),
):
    slept, angle = stopped(time, speed, gravity)
    slow = speed / (gravity * math.sin(1.0))
    named = f"asleep above {time} s"
    if math.isinf(time):
        named = "as shipped, inf s"
    print(
        f"{named}, idle below {speed} m/s, g {gravity} m/s^2: slower for {slow:.4f} s"
        f" and {2 * slow:.4f} s; asleep after {slept:.4f} s at {angle:.3f} rad"
    )
