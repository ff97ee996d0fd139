"""Bounces in REBOUND's MERCURIUS change the energy by a part that falls with the step, and WHFast
attracts hard spheres where gravity is none.

Two equal planets, m = 1e-6 and r = 0.02, move about a star of mass 1 on nearly one orbit; the inner
one catches up, and they bounce once at 0.087 of their speed, without loss. The start is moved over
one step in sixteen parts. Printed are the bounces and the least and the greatest change of the
total energy over m^2.

MERCURIUS propagates a pair that is near by ias15. The part L of the mutual force F, which the
switching function takes from ias15, acts in kicks of half a step h at both ends of the step. A
bounce between two kicks turns the velocity, so that they do work on different velocities: the
energy changes by up to F L h/2 times the change of the closing speed, with either sign. It falls
with the step and with L. It is gone with a greater r_crit_hill, at which L = 0 where the planets
touch, and with ias15, which has no kicks.

WHFast propagates motion about the first particle whatever `gravity` is. With `gravity = "none"` two
hard spheres that should fly freely attract each other, and their kinetic energy is not kept, with
bounces or without them; with G = 0 it is.

REBOUND 5.2.2 says of MERCURIUS that it "uses WHFast for long term integrations but switches over
smoothly to IAS15 for close encounters", and of WHFast that it "is the best choice for systems in
which there is a dominant central object and perturbations to the Keplerian orbits are small". Of
collisions it says nothing there.
"""

import math

import rebound

PHASES = 16  # enough that the least and the greatest change halve with the step to 10 %


def changes(integrator, step, *, bounces=True, r_crit_hill=None, mass=1e-6):
    """Number of bounces, and changes of the total energy over mass^2, one a phase."""
    count = 0
    found = []
    for phase in range(PHASES):
        simulation = rebound.Simulation()
        simulation.integrator = integrator
        simulation.dt = step
        if r_crit_hill is not None:
            simulation.integrator.r_crit_hill = r_crit_hill
        if bounces:
            simulation.collision = "direct"
            simulation.collision_resolve = "hardsphere"
        # They close at 0.087 where they meet: the phases cover a whole step.
        ahead = 0.1 + 0.1 * step * phase / PHASES
        simulation.add(m=1)
        simulation.add(m=mass, r=0.02, x=0.992, vy=1.2)
        simulation.add(
            m=mass,
            r=0.02,
            x=math.cos(ahead),
            y=math.sin(ahead),
            vx=-math.sin(ahead),
            vy=math.cos(ahead),
        )
        simulation.move_to_com()
        before = simulation.energy()
        # ias15 ends a step at each of these times.
        for number in range(round(1 / step)):
            simulation.integrate((number + 1) * step)
        count += simulation.collisions_log_n
        found.append((simulation.energy() - before) / mass**2)
    return count, found


def report(name, integrator, step, **options):
    """Prints a line on the changes."""
    count, found = changes(integrator, step, **options)
    print(f"{name}: {count} bounces, from {min(found):.5f} to {max(found):.5f} m^2")


def kinetic_change(integrator, *, bounces, constant=1.0):
    """Relative change of the kinetic energy of two hard spheres without gravity in 2 s."""
    simulation = rebound.Simulation()
    simulation.integrator = integrator
    simulation.gravity = "none"
    simulation.G = constant
    simulation.dt = 2**-8
    if bounces:
        simulation.collision = "direct"
        simulation.collision_resolve = "hardsphere"
    simulation.add(m=1, r=0.5, x=-1.3, y=0.3, vx=1)
    simulation.add(m=1, r=0.5)
    simulation.steps(2**9)
    simulation.synchronize()
    squares = [body.vx**2 + body.vy**2 for body in simulation.particles]
    return sum(squares) - 1


for step in (0.01, 0.005, 0.0025):
    report(f"mercurius, step {step}", "mercurius", step)
report("mercurius without bounces, step 0.005", "mercurius", 0.005, bounces=False)
for r_crit_hill in (6, 10, 20, 40):
    report(
        f"mercurius, r_crit_hill {r_crit_hill}",
        "mercurius",
        0.005,
        r_crit_hill=r_crit_hill,
    )
report("ias15, step 0.005 at most", "ias15", 0.005)
for integrator in ("leapfrog", "whfast"):
    for bounces in (True, False):
        for constant in (1.0, 0.0):
            change = kinetic_change(integrator, bounces=bounces, constant=constant)
            print(
                f"{integrator}, gravity none, {'bounces' if bounces else 'no collisions'},"
                f" G = {constant}: kinetic energy changes by {change:.5f}"
            )
