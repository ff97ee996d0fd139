"""REBOUND as shipped sees spheres late, by a step of ias15 that grows until a sample cuts it.

`Simulation.dt` is 0.001 by default, whatever the units of time, and `integrator` is "ias15", which
chooses its step by the forces; here nothing acts before the impact, and each step is four times the
one before. REBOUND's documentation says of dt that "adaptive integrators such as IAS15 will use
this value as their initial guess during the first timestep" (Simulation, "Variables"), and of the
search for collisions "It does this only after each timestep" (Collisions, "Direct").

Three causes are varied. With dt in other units of time scaled as they are, the motion is the same,
and with the default it is not. With more samples, which cut the step, the error falls; against the
normal where the overlap is seen, there is none. With leapfrog the step stays, and the error is that
of this step. A cradle of five spheres is off likewise, and does not come back to its start when it
is run back, since the way back sees impacts late at other places.
"""

import math
import warnings
from itertools import pairwise

import rebound

# ias15 says that it does not converge, in the step in which velocities jump.
warnings.simplefilter("ignore", RuntimeWarning)
SECONDS = 3.0  # the impact comes after 1 s


def hard_spheres(step, integrator):
    """A simulation of hard spheres without gravity, yet without spheres."""
    simulation = rebound.Simulation()
    simulation.G = 0
    simulation.collision = "direct"
    simulation.collision_resolve = "hardsphere"
    simulation.integrator = integrator
    simulation.dt = step
    return simulation


def grown():
    """The steps [s] of ias15 until the first sample, after 3 s, where nothing meets."""
    simulation = hard_spheres(0.001, "ias15")
    simulation.add(m=1, r=0.5, x=0.0, vx=1.0)
    simulation.add(m=1, r=0.5, x=100.0)
    times = []
    simulation.heartbeat = lambda state: times.append(state.contents.t)
    simulation.integrate(SECONDS)
    return [after - before for before, after in pairwise(times)]


def impact(unit=1.0, samples=8, step=0.001, integrator="ias15", gap=0.9):
    """Velocity [m/s] of a sphere after an oblique impact, in units of `unit` seconds, and that
    which the normal where the overlap is seen would give it.
    """
    simulation = hard_spheres(step, integrator)
    simulation.add(m=1, r=0.5, x=0.0, vx=unit)
    simulation.add(m=1, r=0.5, x=1.0 + gap, y=0.3)
    normals = []

    def look(state):
        first, second = state.contents.particles[0], state.contents.particles[1]
        if not normals and first.vx != unit:
            away = (second.x - first.x, second.y - first.y)
            normals.append([part / math.hypot(*away) for part in away])

    simulation.heartbeat = look
    for sample in range(1, samples + 1):
        simulation.integrate(SECONDS / unit * sample / samples)
    sphere = simulation.particles[1]
    # Equal masses exchange what lies along the normal.
    (along, across) = normals[0]
    return (sphere.vx / unit, sphere.vy / unit), (along**2, along * across)


# The normal of the true impact has the sine 0.3.
cosine = math.sqrt(1 - 0.3**2)
EXACT = (cosine**2, 0.3 * cosine)


def off(**settings):
    """The largest errors of the velocity [m/s], over ten places of the impact within a step:
    against the true impact, and against one along the normal where the overlap is seen.
    """
    impacts = [impact(gap=0.9 + 0.0123 * place, **settings) for place in range(10)]
    true = max(abs(a - b) for found, _ in impacts for a, b in zip(found, EXACT, strict=True))
    seen = max(abs(a - b) for pair in impacts for a, b in zip(*pair, strict=True))
    return true, seen


def in_a_row(gap, step, integrator):
    """Five spheres with this gap [m] between them, the first of which moves."""
    simulation = hard_spheres(step, integrator)
    for number in range(5):
        simulation.add(m=1, r=0.5, x=number * (1 + gap), vx=float(number == 0))
    return simulation


def returned(samples=8, step=0.001, integrator="ias15"):
    """The largest distance [m] of a sphere of that cradle from its start after 1.25 s forward and,
    with all velocities reversed, 1.25 s more.
    """
    worst = 0.0
    for place in range(10):
        gap = 0.25 + 0.00123 * place
        simulation = in_a_row(gap, step, integrator)
        for sample in range(1, 2 * samples + 1):
            simulation.integrate(1.25 * sample / samples)
            if sample == samples:
                for sphere in simulation.particles:
                    sphere.vx = -sphere.vx
        for number in range(5):
            worst = max(worst, abs(simulation.particles[number].x - number * (1 + gap)))
    return worst


def cradle(samples=8, step=0.001, integrator="ias15"):
    """The largest error [m] of a place of five spheres in a row, over samples and over ten gaps.

    The first moves at 1 m/s; each hands its velocity on to the next, and the last moves on.
    """
    worst = 0.0
    for place in range(10):
        gap = 0.25 + 0.00123 * place
        simulation = in_a_row(gap, step, integrator)
        for sample in range(1, samples + 1):
            time = 1.25 * sample / samples
            simulation.integrate(time)
            for number in range(5):
                moved = max(time - number * gap, 0.0)
                if number < 4:
                    moved = min(moved, gap)
                true = number * (1 + gap) + moved
                worst = max(worst, abs(simulation.particles[number].x - true))
    return worst


steps = ", ".join(f"{step:.3f}" for step in grown())
print(f"ias15 without forces, the first sample after {SECONDS} s: steps of {steps} s")
for unit in (1.0, 1 / 3, 0.1):
    print(
        f"units of {unit:.2f} s: vx {impact(unit)[0][0]:.9f} with the default step,"
        f" {impact(unit, step=0.001 / unit)[0][0]:.9f} with 0.001 s in them"
    )
for samples in (8, 80, 800):
    true, seen = off(samples=samples)
    print(
        f"ias15, {samples} samples: velocity off by {true:.1e} m/s,"
        f" by {seen:.0e} against the normal where the overlap is seen"
    )
for step in (0.1, 0.01, 0.001):
    true, seen = off(step=step, integrator="leapfrog")
    print(f"leapfrog, steps of {step} s: off by {true:.1e} m/s, by {seen:.0e} against that normal")
for samples in (8, 80, 800):
    print(f"cradle, ias15, {samples} samples: off by {cradle(samples):.1e} m")
for step in (0.1, 0.01, 0.001, 0.0001):
    print(f"cradle, leapfrog, steps of {step} s: off by {cradle(8, step, 'leapfrog'):.1e} m")
for samples in (8, 80, 800):
    print(f"cradle and back, ias15, {samples} samples: off by {returned(samples):.1e} m")
for step in (0.1, 0.01, 0.001, 0.0001):
    off_by = returned(8, step, "leapfrog")
    print(f"cradle and back, leapfrog, steps of {step} s: off by {off_by:.1e} m")
