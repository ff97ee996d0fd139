"""MuJoCo's block that friction just holds on a slope creeps: what it depends on.

The slope is 3 in 4. As shipped (friction 3/4) the block slides at 6 mm/s at the finest step of the
gate, and not much less at half of it: less with a shorter time constant (solref), with an impedance
nearer to 1 (solimp), and with the elliptic cone, least with that and noslip iterations. What is
left of it with an impedance of 0.9999 falls with the step.

With the settings of refdem's adapter it creeps by a speed that falls with the step. It has two
causes. One part falls with the number of noslip iterations as 1/n; it is most of it under Euler,
and grows. The other part the block gains while its contact takes on the weight, and friction that
just balances gravity does not brake it: a block that is stopped once after that does not have it.
It is most of it under RK4. With friction 0.9 the block sinks by 54 h^2 until its contact bears the
weight, slips by 20 h^2 meanwhile, and stays; what speed it has after 1/128 s, the first sample of
the gate, is along the normal. Contacts of impedance 0.9999 creep by less than 1e-7 m/s, and throw
up a block that slides, on friction 1/2.

The documentation calls all constraints soft (Modeling, "Solver parameters"), and says of
noslip_iterations that the step after the solver serves "to suppress slip/drift in friction
dimensions resulting from the soft-constraint model", and of elliptic cones that they "are a better
model of the physical reality" (XML reference, option).
"""

import mujoco
import numpy as np

SECONDS = 0.5  # as the gate asks: the block has taken on its creep by the half of it
SCENE = """
<mujoco>
  <option timestep="{step}" gravity="5.8875 0 -7.85" cone="{cone}" integrator="{integrator}"
   noslip_iterations="{noslip}" {solver}>
    <flag diagexact="{exact}"/>
  </option>
  <worldbody>
    <geom name="plane" type="plane" size="50 50 1"/>
    <body pos="0 0 0.125">
      <freejoint/>
      <inertial pos="0 0 0" mass="3" diaginertia="1.015625 1.015625 2"/>
      <geom name="block" type="box" size="1 1 0.125"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="plane" geom2="block" condim="3" friction="{friction} {friction} 0 0 0" {law}/>
  </contact>
</mujoco>
"""
SOLVER = 'tolerance="1e-15" noslip_tolerance="1e-15" ls_tolerance="1e-6"'


def motion(
    step,
    friction,
    law,
    integrator="Euler",
    cone="elliptic",
    noslip=100,
    tuned=True,
    stop_after=None,
    seconds=SECONDS,
):
    """Way and speed down the slope, height of the block and speed along the normal after each
    step, and steps without contact.

    `stop_after` is a number of steps after which the block is stopped once.
    """
    scene = SCENE.format(
        step=step,
        friction=friction,
        law=law,
        integrator=integrator,
        cone=cone,
        noslip=noslip,
        solver=SOLVER if tuned else "",
        exact="enable" if tuned else "disable",
    )
    model = mujoco.MjModel.from_xml_string(scene)
    data = mujoco.MjData(model)
    rows = []
    free = 0
    for number in range(round(seconds / step)):
        if number == stop_after:
            data.qvel[:] = 0
        mujoco.mj_step(model, data)
        rows.append((data.qpos[0], data.qvel[0], data.qpos[2] - 0.125, data.qvel[2]))
        free += data.ncon == 0
    return np.array(rows), free


def creep(rows, step):
    """Speed [m/s] over the last quarter of a second."""
    last = round(SECONDS / 2 / step)
    return (rows[-1, 0] - rows[-1 - last, 0]) / (SECONDS / 2)


def shipped(step, constant=0.02, impedance="0.9 0.95", cone="pyramidal", noslip=0):
    """The creep [mm/s] of the law that MuJoCo ships, with what is given here changed."""
    law = f'solref="{constant} 1" solimp="{impedance} 0.001 0.5 2"'
    rows, _ = motion(step, 0.75, law, cone=cone, noslip=noslip, tuned=False)
    return 1000 * creep(rows, step)


def soft(step):
    """The law of refdem's adapter for what may slide."""
    return (
        f'solref="{-1 / (4 * step**2)} {-1 / step}" solimp="0.0009765625 0.0009765625 1 0.5 2"'
        f' solreffriction="-2.3e-308 {-1 / (1024 * step)}" margin="1e-15"'
    )


def hard(step):
    """The hardest law that MuJoCo allows."""
    return f'solref="{2 * step} 1" solimp="0.9999 0.9999 1 0.5 2" margin="1e-15"'


STEP = 2.0**-11  # [s]: the finest of the gate
SAMPLE = 2.0**-7  # [s]: the first of the gate
STEPS = [2.0**-power for power in range(8, 14)]
SHIPPED = {
    "as shipped": {},
    "solref 0.01 s": {"constant": 0.01},
    "solref 0.005 s": {"constant": 0.005},
    "solimp 0.9": {"impedance": "0.9 0.9"},
    "solimp 0.95": {"impedance": "0.95 0.95"},
    "solimp 0.99": {"impedance": "0.99 0.99"},
    "solimp 0.9999": {"impedance": "0.9999 0.9999"},
    "cone elliptic": {"cone": "elliptic"},
    "noslip 100": {"noslip": 100},
    "cone elliptic, noslip 100": {"cone": "elliptic", "noslip": 100},
}
print("creep [mm/s] as shipped but for what is named, h = 2^-8 to 2^-13 s:")
for name, settings in SHIPPED.items():
    print(f"  {name}: " + ", ".join(f"{shipped(step, **settings):.2f}" for step in STEPS))
for integrator in ("Euler", "RK4"):
    for step in (4 * STEP, 2 * STEP, STEP):
        name = f"{integrator}, h = {step:.6f} s"
        rows, _ = motion(step, 0.75, soft(step), integrator)
        speed = creep(rows, step)
        print(f"{name}: creeps at {speed:.2e} m/s = {speed / step:.3f} h")
        rows, _ = motion(step, 0.9, soft(step), integrator)
        sunk, slipped = -rows[:, 2].min() / step**2, rows[-1, 0] / step**2
        left = f"{rows[-1, 1]:.0e} m/s are left"
        print(f"  friction 0.9: sinks {sunk:.1f} h^2, slips {slipped:.1f} h^2, {left}")
for integrator in ("Euler", "RK4"):
    for friction in (0.75, 0.9):
        rows, _ = motion(STEP, friction, soft(STEP), integrator)
        number = round(SAMPLE / STEP)
        slip, normal = rows[number - 1, 1], rows[number - 1, 3]
        speeds = f"{abs(normal):.2e} m/s along the normal, {slip:.1e} m/s down the slope"
        print(f"{integrator}, friction {friction}, after {number} steps: {speeds}")
for integrator in ("Euler", "RK4"):
    for noslip in (30, 100, 1000):
        whole, _ = motion(STEP, 0.75, soft(STEP), integrator, noslip=noslip)
        stopped, _ = motion(STEP, 0.75, soft(STEP), integrator, noslip=noslip, stop_after=100)
        gain, speeds = whole[99, 1] / STEP, [creep(rows, STEP) / STEP for rows in (whole, stopped)]
        name = f"{integrator}, {noslip} iterations of noslip"
        found = f"{gain:.3f} h after 100 steps, creeps at {speeds[0]:.3f} h"
        print(f"{name}: {found}, at {speeds[1]:.4f} h if stopped once after 100 steps")
for seconds in (0.5, 4):
    rows, _ = motion(STEP, 0.75, soft(STEP), seconds=seconds)
    print(f"Euler, at the end of {seconds} s: creeps at {creep(rows, STEP) / STEP:.3f} h")
for step in (8 * STEP, STEP):
    rows, _ = motion(step, 0.75, hard(step))
    held = f"creeps at {creep(rows, step):.0e} m/s on friction 3/4"
    rows, free = motion(step, 0.5, hard(step))
    thrown = f"{free} of {len(rows)} steps without contact on friction 1/2"
    print(f"hard contacts, h = {step:.6f} s: {held}, {thrown}")
