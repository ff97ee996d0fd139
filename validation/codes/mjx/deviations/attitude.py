"""MJX' Runge-Kutta 4 is of second order in the attitude of a free body that tumbles.

The documentation of its IntegratorType calls it a 4th-order Runge Kutta. The angular velocity in
body axes is of fourth order; the attitude is turned once by the weighted mean of the angular
velocities of four stages, whose axes differ (`rungekutta4` of mujoco/mjx/_src/forward.py). A twin
of these lines has the same attitudes to rounding; the same twin with the stages in the axes of the
start, by the inverse of the differential of the exponential map, is of fourth order. MuJoCo 4.0.0
is of fourth order in both, MuJoCo 3.3.0 of second in the attitude.
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


def product(p, q):
    """The product of two quaternions (w, x, y, z)."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *vector])


def turned(q, turn):
    """A quaternion turned by a rotation vector in body axes."""
    angle = np.linalg.norm(turn)
    if angle == 0:
        return q
    return product(q, np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * turn)]))


def carried(omega, turn):
    """The rate of the rotation vector `turn` at that omega in body axes, to third order.

    omega + turn x omega / 2 + turn x (turn x omega) / 12 (Munthe-Kaas 1998).
    """
    first = np.cross(turn, omega)
    return omega + first / 2 + np.cross(turn, first) / 12


def by_twin(step, is_carried):
    """Attitude and angular velocity of classical Runge-Kutta, its stages in one frame or not."""
    moments = np.array([1.0, 2.0, 2.5])
    q = np.array([1.0, 0.0, 0.0, 0.0])
    omega = np.array([1.0, 2.0, 0.5])
    for _ in range(round(SECONDS / step)):
        rates = []
        accelerations = []
        for part in (0.0, 0.5, 0.5, 1.0):
            turn, stage = np.zeros(3), omega
            if rates:
                turn = part * step * rates[-1]
                stage = omega + part * step * accelerations[-1]
            rates.append(carried(stage, turn) if is_carried else stage)
            accelerations.append(np.cross(moments * stage, stage) / moments)
        weights = np.array([1.0, 2.0, 2.0, 1.0]) / 6
        q = turned(q, step * (weights @ np.array(rates)))
        omega = omega + step * (weights @ np.array(accelerations))
    return q, omega


finest = by_mujoco(1e-4)
for name, code in (("MJX", by_mjx), ("MuJoCo", by_mujoco)):
    for step in (0.04, 0.02, 0.01):
        off = [np.abs(a - b).max() for a, b in zip(code(step), finest, strict=True)]
        print(f"{name}, step {step} s: attitude off by {off[0]:.1e}, omega by {off[1]:.1e}")
for step in (0.04, 0.02, 0.01):
    of_mjx, _ = by_mjx(step)
    twin, _ = by_twin(step, False)
    other, _ = by_twin(step, True)
    print(
        f"twin, step {step} s: attitude {np.abs(twin - of_mjx).max():.0e} from that of MJX; with"
        f" the stages in one frame off by {np.abs(other - finest[0]).max():.1e}"
    )
