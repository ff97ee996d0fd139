"""MJX' attitude of a body at rest has the derivative 0 by its angular velocity, in place of t/2.

A body turns about x with omega for t = 1 s: its attitude has x = sin(omega t/2), which changes by
t/2 for omega at omega = 0. JAX differentiates the steps of MJX, forward and in reverse; both find 0
where omega is less than 1e-8 rad/s, and t/2 from there on. Central differences over 1e-5 rad/s find
t/2 at rest too. `normalize_with_norm` of mujoco/mjx/_src/math.py divides by 1e-6 where a norm is 0,
and `norm` calls it 0 where all components are less than 1e-8; its docstring has it "safe for
gradients at x=0". The angle of a step, omega h, then has the derivative 0, and so has the turn.
"""

import math

import jax
import mujoco
from mujoco import mjx

jax.config.update("jax_enable_x64", True)

STEPS = 8
"""Of 0.125 s, to 1 s: turns about one axis add up exactly."""
DIFFERENCE = 1e-5
"""The change of omega [rad/s] for central differences, which rounding leaves 11 digits."""
MODEL = """
<mujoco>
  <option gravity="0 0 0" timestep="0.125"/>
  <worldbody>
    <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
  </worldbody>
</mujoco>
"""


model = mujoco.MjModel.from_xml_string(MODEL)
there = mjx.put_model(model)
start = mjx.put_data(model, mujoco.MjData(model))


def stepped(state, _):
    """The state after a step of MJX, as the body of a scan."""
    return mjx.step(there, state), None


def attitude(omega):
    """The x of the attitude after 1 s, of a body that turns about x with omega [rad/s]."""
    state = start.replace(qvel=start.qvel.at[3].set(omega))
    state, _ = jax.lax.scan(stepped, state, length=STEPS)
    return state.qpos[4]


value = jax.jit(attitude)
forward = jax.jit(jax.jacfwd(attitude))
reverse = jax.jit(jax.jacrev(attitude))
for omega in (0.0, 1e-9, 1e-7, 1.0):
    difference = (value(omega + DIFFERENCE) - value(omega - DIFFERENCE)) / (2 * DIFFERENCE)
    print(
        f"omega {omega:g} rad/s: forward {forward(omega):.6f}, reverse {reverse(omega):.6f},"
        f" differences {difference:.6f}, exact {0.5 * math.cos(omega / 2):.6f}"
    )
