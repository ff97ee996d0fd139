"""REBOUND as shipped sees spheres late, by a step of ias15 that doubles until a sample cuts it.

`Simulation.dt` is 0.001 by default, whatever the units of time, and `integrator` is "ias15", which
chooses its step by the forces; here nothing acts before the impact. Three causes are varied. With
dt in other units of time scaled as they are, the motion is the same, and with the default it is
not. With more samples, which cut the step, the error falls. With leapfrog the step stays, and the
error is that of this step.
"""

import math
import warnings

import rebound

# ias15 says that it does not converge, in the step in which velocities jump.
warnings.simplefilter("ignore", RuntimeWarning)
SECONDS = 3.0  # the impact comes after 1 s


def impact(unit=1.0, samples=8, step=0.001, integrator="ias15", gap=0.9):
    """Velocity [m/s] of a sphere after an oblique impact, in units of `unit` seconds."""
    simulation = rebound.Simulation()
    simulation.G = 0
    simulation.collision = "direct"
    simulation.collision_resolve = "hardsphere"
    simulation.integrator = integrator
    simulation.dt = step
    simulation.add(m=1, r=0.5, x=0.0, vx=unit)
    simulation.add(m=1, r=0.5, x=1.0 + gap, y=0.3)
    for sample in range(1, samples + 1):
        simulation.integrate(SECONDS / unit * sample / samples)
    sphere = simulation.particles[1]
    return sphere.vx / unit, sphere.vy / unit


# The normal has the sine 0.3: equal masses exchange what lies along it.
cosine = math.sqrt(1 - 0.3**2)
EXACT = (cosine**2, 0.3 * cosine)


def off(**settings):
    """The largest error of the velocity [m/s], over ten places of the impact within a step."""
    impacts = [impact(gap=0.9 + 0.0123 * place, **settings) for place in range(10)]
    return max(abs(a - b) for found in impacts for a, b in zip(found, EXACT, strict=True))


for unit in (1.0, 1 / 3, 0.1):
    print(
        f"units of {unit:.2f} s: vx {impact(unit)[0]:.9f} with the default step,"
        f" {impact(unit, step=0.001 / unit)[0]:.9f} with 0.001 s in them"
    )
for samples in (8, 80, 800):
    print(f"ias15, {samples} samples: velocity off by {off(samples=samples):.1e} m/s")
for step in (0.1, 0.01, 0.001):
    print(f"leapfrog, steps of {step} s: off by {off(step=step, integrator='leapfrog'):.1e} m/s")
