"""MJX' Runge-Kutta 4 is of second order in the attitude of a free body that tumbles.

The documentation of its IntegratorType calls it a 4th-order Runge Kutta. The angular velocity in
body axes is of fourth order; the attitude is turned once by the mean of the angular velocities of
four stages, whose axes differ. MuJoCo, from 4.0.0 on, is of fourth order in both.
"""

import jax
import mujoco
import numpy as np
from mujoco import mjx

jax.config.update("jax_enable_x64", True)

SECONDS = 1.0
"""Half a turn or so: long enough for the errors of attitudes to add up."""
MODEL = """
<mujoco>
  <option integrator="RK4" gravity="0 0 0"/>
  <worldbody>
    <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 2 2.5"/></body>
  </worldbody>
</mujoco>
"""


@jax.jit
def advanced(model, data, count):
    """The state after `count` steps."""
    return jax.lax.fori_loop(0, count, lambda _, state: mjx.step(model, state), data)


def started(step):
    """The model with this step, and a body that tumbles."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    model.opt.timestep = step
    data = mujoco.MjData(model)
    data.qvel[3:] = (1.0, 2.0, 0.5)
    return model, data


def by_mjx(step):
    """Attitude and angular velocity of MJX at the end."""
    model, data = started(step)
    state = mjx.put_data(model, data)
    state = advanced(mjx.put_model(model), state, round(SECONDS / step))
    return np.array(state.qpos[3:]), np.array(state.qvel[3:])


def by_mujoco(step):
    """Attitude and angular velocity of MuJoCo at the end."""
    model, data = started(step)
    for _ in range(round(SECONDS / step)):
        mujoco.mj_step(model, data)
    return data.qpos[3:].copy(), data.qvel[3:].copy()


finest = by_mujoco(1e-4)
for name, code in (("MJX", by_mjx), ("MuJoCo", by_mujoco)):
    for step in (0.04, 0.02, 0.01):
        off = [np.abs(a - b).max() for a, b in zip(code(step), finest, strict=True)]
        print(f"{name}, step {step} s: attitude off by {off[0]:.1e}, omega by {off[1]:.1e}")
