"""A scene in MJX, MuJoCo on JAX: free bodies, a top on a ball joint, rods in a plane, gravity.

The steps are MJX's, in double precision on the CPU, all of those from sample to sample in one
compiled loop; a free body is a free joint, and a chain of rods one of hinges. Where bodies are at
the samples comes from MuJoCo's own kinematics of MJX' coordinates. Derivatives are JAX' own,
through the same steps (`tangent`).
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import border
import served
from served import cannot

# isort: split
import jax
import mujoco
import numpy as np
from hinges import hinges
from mujoco import mjx
from tangent import NOWHERE, changes_of, derivatives, table

jax.config.update("jax_enable_x64", True)
# What is compiled is kept beside the packages, for the other processes of a gate and the next gate.
jax.config.update("jax_compilation_cache_dir", str(Path(sys.prefix) / "compiled"))

KNOWN = ("uniform_gravity", "rod", "ball_joint")
LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""
LEAST_MOMENT_ON_A_ROD = 1e-15
"""mjMINVAL, below which MuJoCo's compiler takes no moment of inertia."""
INTEGRATORS = {
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
    "rk4": mujoco.mjtIntegrator.mjINT_RK4,
}


@jax.jit
def advanced(model, data, count):
    """The state after `count` steps."""
    return jax.lax.fori_loop(0, count, lambda _, state: mjx.step(model, state), data)


class World:
    """MuJoCo's model of a scene with its start.

    `numbers` has the number in the model of each body, `joints` the kind of each joint in the order
    of coordinates, with both numbers of its body; `axis` (3) is that of hinges, or None.
    """

    def __init__(self, scene):
        self.scene = scene
        self.spec = mujoco.MjSpec()
        self.spec.option.gravity = scene.gravity
        self.spec.option.timestep = scene.step
        self.spec.option.integrator = INTEGRATORS[scene.method]
        self.numbers = {}
        self.joints = []
        self.axis = None
        self.qpos = []
        self.qvel = []
        tops = {joint["a"]: joint for joint in scene.of_kind("ball_joint")}
        if scene.of_kind("rod"):
            self.add_chain()
        for number, body in enumerate(scene.bodies):
            if number in tops:
                self.add_top(number, body, tops[number])
            elif number not in self.numbers:
                self.add_free(number, body)
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)
        self.data.qpos = self.qpos
        self.data.qvel = self.qvel

    def add(self, kind, parent, number, at, mass, centre, moments):
        """Adds a body at a place (3) of its parent, for a joint of this kind."""
        made = parent.add_body(
            pos=at, mass=mass, ipos=centre, inertia=moments, explicitinertial=True
        )
        there = len(self.numbers) + 1
        self.numbers[number] = there
        self.joints.append((kind, number, there))
        return made

    def put_start(self, body, place, velocity):
        """The coordinates of a joint that turns: attitude, and omega in body axes."""
        omega = border.turned(border.conjugate(body["attitude"]), body["omega"])
        self.qpos += [*place, *body["attitude"]]
        self.qvel += [*velocity, *omega]

    def add_free(self, number, body):
        """Adds a body that is free to move and to turn."""
        moments = self.scene.moments(body, LEAST_MOMENT)
        world = self.spec.worldbody
        made = self.add("free", world, number, NOWHERE, body["mass"], NOWHERE, moments)
        made.add_freejoint()
        self.put_start(body, body["position"], body["velocity"])

    def add_top(self, number, body, ball):
        """Adds a body that is held to the world by a ball joint."""
        cannot(ball["b"] != -1, "ball joints between bodies")
        centre = [-component for component in ball["anchor_a"]]
        world = self.spec.worldbody
        at = ball["anchor_b"]
        made = self.add("ball", world, number, at, body["mass"], centre, body["inertia"])
        made.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
        self.put_start(body, [], [])

    def add_chain(self):
        """Adds points on a chain of rods that moves in a plane: a hinge for each rod."""
        self.axis, found = hinges(self.scene)
        parent = self.spec.worldbody
        moments = [LEAST_MOMENT_ON_A_ROD] * 3
        for hinge in found:
            mass = self.scene.bodies[hinge.number]["mass"]
            parent = self.add("hinge", parent, hinge.number, hinge.at, mass, hinge.arm, moments)
            parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=self.axis)
            self.qpos.append(0.0)
            self.qvel.append(hinge.rate)

    def states(self, state):
        """Position, velocity, attitude (w first) and omega of each body."""
        self.data.qpos = state.qpos
        self.data.qvel = state.qvel
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)
        motion = np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_BODY
        for number, body in enumerate(self.scene.bodies):
            there = self.numbers[number]
            mujoco.mj_objectVelocity(self.model, self.data, kind, there, motion, 0)
            place = self.data.xipos[there].copy()
            velocity = motion[3:].copy()
            if any(body["inertia"]):
                yield place, velocity, self.data.xquat[there].copy(), motion[:3].copy()
            else:
                yield place, velocity, body["attitude"], body["omega"]


def derivatives_of(world, model, state):
    """A function of the steps from sample to sample: the derivatives of all states."""
    scene = world.scene
    changes = changes_of(scene, world.axis)
    axis = np.zeros(3) if world.axis is None else world.axis
    joints = tuple(world.joints)
    numbers = table(scene)

    def after(stride):
        counts = np.full(len(scene.times), stride)
        counts[0] = 0
        return derivatives(model, state, axis, numbers, changes, counts, joints=joints)

    return after


def keep_derivatives(scene, found):
    """Keeps derivatives, arrays (samples, N, ..., K), as those of the rows."""
    beside = scene.with_numbers(lambda value, place: value)
    arrays = [np.array(one) for one in found]
    for sample, t in enumerate(scene.times):
        for number in range(len(scene.bodies)):
            beside.rows.append((t, number, *(one[sample, number] for one in arrays)))
    # Each component of a state is the array (K,) of its derivatives.
    scene.differentiated(beside, lambda slopes: slopes)


def solve(scene):
    """One run of the integrator that was asked for, and its derivatives if they were."""
    world = World(scene)
    model = mjx.put_model(world.model)
    state = mjx.put_data(world.model, world.data)
    start = state
    # Compiled for the kinds of joints, not for their numbers: no step is taken here.
    advanced(model, state, 0).qpos.block_until_ready()
    if scene.sensitivities:
        differentiated = derivatives_of(world, model, start)
        jax.block_until_ready(differentiated(0))
    scene.warm()
    for sample, t in enumerate(scene.times):
        if sample > 0:
            state = advanced(model, state, scene.stride)
        for number, found in enumerate(world.states(state)):
            scene.rows.append((t, number, *found))
    if scene.sensitivities:
        keep_derivatives(scene, differentiated(scene.stride))


served.run(solve, *KNOWN)
