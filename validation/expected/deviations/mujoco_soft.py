"""MuJoCo's soft constraints: how far boxes sink, and a softness that is counted in seconds.

A cube sinks by g (1 - d) (2 h)^2, d the impedance and 2 h the time constant; of two cubes the
lower sinks twice, the upper four times as far. An oscillator with dry friction as shipped moves
otherwise in other units of time, for solref is 0.02 of whatever the units are; with solreffriction
in the same seconds it moves as before. With smaller steps and 0.02 s it comes nearer to a softened
motion; Coulomb's, to which a shorter time constant leads, is another.
"""

import math

import mujoco
import numpy as np

GRAVITY = 9.8125  # [m/s^2]


def sunk(step, impedance, count):
    """The ways [g (1 - d) (2 h)^2] by which cubes of a stack sink, from the lowest."""
    law = f'condim="1" solref="{2 * step} 1" solimp="{impedance} {impedance} 0.001 0.5 2"'
    inertial = f'<inertial pos="0 0 0" mass="1" diaginertia="{1 / 6} {1 / 6} {1 / 6}"/>'
    cube = f'{inertial}<geom type="box" size="0.5 0.5 0.5"/>'
    bodies = "".join(
        f'<body pos="0 0 {0.5 + number}"><freejoint/>{cube}</body>' for number in range(count)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 {-GRAVITY}" tolerance="1e-15">'
        f'<flag diagexact="enable"/></option><default><geom {law} margin="1e-15"/></default>'
        f'<worldbody><geom type="plane" size="5 5 1"/>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    for _ in range(400):
        mujoco.mj_step(model, data)
    unit = GRAVITY * (1 - impedance) * (2 * step) ** 2
    return [(0.5 + n - data.qpos[7 * n + 2]) / unit for n in range(count)]


def oscillation(unit, constant, step=2.0**-10):
    """Positions and velocities [m/s] of an oscillator with dry friction, in units of `unit` s.

    A mass of 1 kg starts at 1 m, with 1 oscillation a second and a friction of 4 N; 4 s.
    """
    rate = 2 * math.pi * unit
    joint = f'type="slide" axis="1 0 0" stiffness="{rate**2}" frictionloss="{4 * unit**2}"'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step / unit}" gravity="0 0 0"/><worldbody><body>'
        f'<joint {joint} solreffriction="{constant} 1"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[0] = 1.0
    rows = []
    for _ in range(round(4 / step)):
        mujoco.mj_step(model, data)
        rows.append((data.qpos[0], data.qvel[0] / unit))
    return np.array(rows)


for step in (2.0**-8, 2.0**-9):
    for impedance in (0.9999, 0.999):
        for count in (1, 2):
            ways = ", ".join(f"{way:.3f}" for way in sunk(step, impedance, count))
            print(f"h {step:.5f} s, impedance {impedance}, {count} cubes: {ways} g (1 - d) (2 h)^2")
seconds = oscillation(1.0, 0.02)
for unit in (2.0, 0.5):
    default = np.abs(oscillation(unit, 0.02) - seconds).max()
    same = np.abs(oscillation(unit, 0.02 / unit) - seconds).max()
    print(f"units of {unit} s: apart by {default:.0e} with solref 0.02, {same:.0e} with 0.02 s")
# Between two turns the position that friction and spring leave is 1 m less 4 f/k a turn.
exact = 1 - 4 * (4 / (2 * math.pi) ** 2)
for constant in (0.02, 0.01, 0.005):
    for step in (2.0**-10, 2.0**-11):
        turned = oscillation(1.0, constant, step)[round(1 / step) - 1, 0]
        found = f"{turned - exact:+.1e} m from Coulomb's after one turn"
        print(f"solref {constant} s, step {step:.6f} s: {found}")
