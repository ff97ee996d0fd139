"""The derivatives of a motion in MJX by K numbers of its scene, by jax.jacfwd through its steps.

The numbers of a scene are a table of arrays, x. Each number that a request names moves them along
a change dx_k, so that a motion is a function of K factors,

    e -> motion(x + sum e_k dx_k),

whose Jacobian at e = 0 has the derivatives. The model, its start and where bodies are at the
samples are computed in JAX from the table.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from hinges import LEAST_SINE
from mujoco import mjx
from served import cannot

OF_BODIES = ("mass", "inertia", "position", "velocity", "attitude", "omega")
NOWHERE = [0.0, 0.0, 0.0]


def table(scene):
    """The numbers of a scene: arrays (N, ...) over bodies, the anchors (N, 3) of those on ball
    joints, gravity (3), and the pivot (3) of a chain of rods.
    """
    found = {name: np.array([body[name] for body in scene.bodies], float) for name in OF_BODIES}
    balls = {joint["a"]: joint for joint in scene.of_kind("ball_joint")}
    for name in ("anchor_a", "anchor_b"):
        anchors = [
            balls[number][name] if number in balls else NOWHERE
            for number in range(len(scene.bodies))
        ]
        found[name] = np.array(anchors, float)
    found["gravity"] = np.array(scene.gravity, float)
    found["pivot"] = np.zeros(3)
    if scene.of_kind("rod"):
        found["pivot"] = np.array(scene.chain()[1], float)
    return found


def changes_of(scene, axis):
    """The changes of the table by each number that the request names: arrays (K, ...).

    Raises UnsupportedError for numbers by which the model has no derivatives. `axis` (3) is that of
    the hinges of a chain, or None.
    """
    each = [table(change) for change in scene.changes()]
    stacked = {name: np.array([one[name] for one in each]) for name in each[0]}
    is_zero = np.array([body["inertia"] for body in scene.bodies]) == 0
    refused = np.any(stacked["inertia"][:, is_zero])
    cannot(refused, "derivatives by moments of inertia that are 0")
    if axis is not None:
        for name in ("position", "velocity", "gravity", "pivot"):
            out = np.abs(stacked[name] @ axis)
            cannot(np.any(out > LEAST_SINE), "derivatives out of the plane of the rods")
    return stacked


def to_body(q, vector):
    """q* v q: a vector (3) of space seen from a body with the unit quaternion q (w, x, y, z)."""
    w = q[0]
    r = q[1:]
    # v - 2 w (r x v) + 2 r x (r x v).
    crossed = jnp.cross(r, vector)
    return vector - 2 * w * crossed + 2 * jnp.cross(r, crossed)


class Start:
    """The fields of the model that a table moves, and the coordinates q and velocities v.

    Bodies are added in the order of their coordinates.
    """

    def __init__(self, model, numbers):
        self.numbers = numbers
        self.pos = model.body_pos
        self.ipos = model.body_ipos
        self.mass = model.body_mass
        self.inertia = model.body_inertia
        self.q = []
        self.v = []

    def add_turning(self, number):
        """Adds the coordinates of a joint that turns as the body does."""
        attitude = self.numbers["attitude"][number]
        q = attitude / jnp.sqrt(attitude @ attitude)
        self.q.append(q)
        self.v.append(to_body(q, self.numbers["omega"][number]))

    def add_free(self, number, there):
        """Adds a body that is free to move and to turn."""
        self.q.append(self.numbers["position"][number])
        self.v.append(self.numbers["velocity"][number])
        self.add_turning(number)
        self.add_mass(number, there)

    def add_top(self, number, there):
        """Adds a body on a ball joint."""
        self.pos = self.pos.at[there].set(self.numbers["anchor_b"][number])
        self.ipos = self.ipos.at[there].set(-self.numbers["anchor_a"][number])
        self.add_turning(number)
        self.add_mass(number, there)

    def add_mass(self, number, there):
        """Puts mass and moments of inertia; moments of 0 stay those that the model has for them."""
        moments = self.numbers["inertia"][number]
        moments = jnp.where(moments == 0, self.inertia[there], moments)
        self.mass = self.mass.at[there].set(self.numbers["mass"][number])
        self.inertia = self.inertia.at[there].set(moments)

    def add_chain(self, axis, chain):
        """Adds points on rods, from the world on."""
        at = self.numbers["pivot"]
        above = at
        moving_above = jnp.zeros(3)
        turned = 0.0
        for number, there in chain:
            position = self.numbers["position"][number]
            velocity = self.numbers["velocity"][number]
            arm = position - above
            # omega = n . (r x v) / r^2, of which the hinge has what the rod before it has not.
            crossed = jnp.cross(arm, velocity - moving_above)
            omega = axis @ crossed / (arm @ arm)
            self.pos = self.pos.at[there].set(at)
            self.ipos = self.ipos.at[there].set(arm)
            self.q.append(jnp.zeros(1))
            self.v.append(jnp.array([omega - turned]))
            self.add_mass(number, there)
            at = arm
            above = position
            moving_above = velocity
            turned = omega


def started(model, axis, joints, numbers):
    """MJX' model, q and v of a table; `joints` has the kind of each joint, and the numbers of its
    body in the scene and in the model.
    """
    start = Start(model, numbers)
    chain = [(number, there) for kind, number, there in joints if kind == "hinge"]
    start.add_chain(axis, chain)
    for kind, number, there in joints:
        if kind == "ball":
            start.add_top(number, there)
        elif kind == "free":
            start.add_free(number, there)
    moved = model.replace(
        body_pos=start.pos,
        body_ipos=start.ipos,
        body_mass=start.mass,
        body_inertia=start.inertia,
        opt=model.opt.replace(gravity=numbers["gravity"]),
    )
    return moved, jnp.concatenate(start.q), jnp.concatenate(start.v)


def states(model, data, joints, numbers):
    """Position, velocity, attitude and omega, (N, 3) or (N, 4), of all bodies of the scene."""
    data = mjx.com_vel(model, mjx.com_pos(model, mjx.kinematics(model, data)))
    omega = data.cvel[:, :3]
    # The velocity of a centre is that of the centre of its tree, and omega x r from there.
    lever = data.xipos - data.subtree_com[model.body_rootid]
    velocity = data.cvel[:, 3:] + jnp.cross(omega, lever)
    there = np.array([place for _, _, place in sorted(joints, key=lambda joint: joint[1])])
    turns = jnp.any(numbers["inertia"] != 0, axis=1)[:, None]
    attitude = jnp.where(turns, data.xquat[there], numbers["attitude"])
    return (
        data.xipos[there],
        velocity[there],
        attitude,
        jnp.where(turns, omega[there], numbers["omega"]),
    )


def motion(model, data, axis, joints, numbers, counts):
    """The states at all samples, arrays (samples, N, ...), with `counts` of steps before each."""
    moved, q, v = started(model, axis, joints, numbers)

    def stepped(_, state):
        # Without contacts, actuators and other constraints a step depends on q and v alone.
        after = mjx.step(moved, data.replace(qpos=state[0], qvel=state[1]))
        return after.qpos, after.qvel

    def sampled(state, count):
        state = jax.lax.fori_loop(0, count, stepped, state)
        at_sample = data.replace(qpos=state[0], qvel=state[1])
        return state, states(moved, at_sample, joints, numbers)

    return jax.lax.scan(sampled, (q, v), counts)[1]


@partial(jax.jit, static_argnames="joints")
def derivatives(model, data, axis, numbers, changes, counts, *, joints):
    """The derivatives of the states at all samples by K numbers: arrays (samples, N, ..., K)."""

    def along(factors):
        moved = {
            name: value + jnp.tensordot(factors, changes[name], 1)
            for name, value in numbers.items()
        }
        return motion(model, data, axis, joints, moved, counts)

    return jax.jacfwd(along)(jnp.zeros(len(changes["mass"])))
