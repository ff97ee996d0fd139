"""REBOUND's search `line` finds each meeting, and `hardsphere` resolves those that still overlap.

A sphere is shot head-on at another one of the same size, forty times, from places spread over one
step. A resolver that only counts is called in all forty, however long the step. `hardsphere` lets
spheres bounce only where they overlap and approach at the end of the step. At 1 m/s they do so for
one diameter, 1 s: of steps of h seconds a part 1/h ends in time, and the others pass through each
other. So it is with `direct`, whose search looks at no more than that. Larger spheres, a lower
speed or a resolver of our own, which goes back to the touch, vary the cause.

REBOUND's documentation says of `line` that it "checks for overlapping particles during the timestep
(not just at the end)" (Collisions, "Line"), and of `hardsphere` nothing of the kind. In its source
(5.2.2, src/collision.c, reb_collision_resolve_hardsphere) stand
`if (rp*rp < x21*x21 + y21*y21 + z21*z21) return 0;` and
`if (vx21*x21 + vy21*y21 + vz21*z21 >0) return 0; // not approaching`.
"""

import rebound

SHOTS = 40  # divided by each step in diameters over the speed: 80, 20, 10 and 2 whole shots


def resolved_at_the_touch(pointer, collision):
    """Resolves a head-on impact of equal masses at the time of the touch: both go back to it,
    exchange their velocities, and go on to the end of the step.
    """
    particles = pointer.contents.particles
    first, second = particles[collision.p1], particles[collision.p2]
    closing = first.vx - second.vx
    side = 1 if closing > 0 else -1
    since = (first.x - second.x + side * (first.r + second.r)) / closing
    first.x -= since * closing
    second.x += since * closing
    first.vx, second.vx = second.vx, first.vx
    return 0


def bounces(search, step, radius=0.5, speed=1.0, resolver="hardsphere"):
    """How many of the shots are found, and how many of them bounce."""
    found = bounced = 0
    for shot in range(SHOTS):
        simulation = rebound.Simulation()
        simulation.integrator = "leapfrog"
        simulation.gravity = "none"
        simulation.dt = step
        simulation.collision = search
        calls = []

        def count(pointer, collision, calls=calls):
            calls.append(collision)
            return 0

        simulation.collision_resolve = count if resolver == "count" else resolver
        start = -4 * radius - speed * step * (shot + 0.5) / SHOTS
        simulation.add(m=1, r=radius, x=start, vx=speed)
        simulation.add(m=1, r=radius)
        simulation.steps(int(8 * radius / (speed * step)) + 3)
        found += bool(calls)
        bounced += simulation.particles[1].vx != 0
    return found, bounced


for step in (0.5, 2, 4, 20):
    for search in ("direct", "line"):
        found, _ = bounces(search, step, resolver="count")
        _, bounced = bounces(search, step)
        print(f"{search}, step {step} s: {SHOTS} meetings, {found} found, {bounced} bounce")
for radius, speed in ((1.0, 1.0), (0.5, 0.5), (2.0, 0.5)):
    _, bounced = bounces("line", 20, radius, speed)
    print(f"line, spheres of radius {radius} m, {speed} m/s, step 20 s: {bounced} bounce")
for step in (2, 20):
    _, bounced = bounces("line", step, resolver=resolved_at_the_touch)
    print(f"line, resolved at the touch, step {step} s: {bounced} bounce")
