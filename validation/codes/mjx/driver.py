"""A scene in MJX, MuJoCo on JAX: free bodies, a top on a ball joint, rods in a plane, gravity.

The steps are MJX's, in double precision on the CPU, all of those from sample to sample in one
compiled loop; a free body is a free joint, and a chain of rods one of hinges. Where bodies are at
the samples comes from MuJoCo's own kinematics of MJX' coordinates.
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

jax.config.update("jax_enable_x64", True)

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
    """MuJoCo's model of a scene with its start, and the number of the body there of each body."""

    def __init__(self, scene):
        self.scene = scene
        self.spec = mujoco.MjSpec()
        self.spec.option.gravity = scene.gravity
        self.spec.option.timestep = scene.step
        self.spec.option.integrator = INTEGRATORS[scene.method]
        self.numbers = {}
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

    def add(self, parent, number, at, mass, centre, moments):
        """Adds a body at a place (3) of its parent."""
        made = parent.add_body(
            pos=at, mass=mass, ipos=centre, inertia=moments, explicitinertial=True
        )
        self.numbers[number] = len(self.numbers) + 1
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
        made = self.add(world, number, [0, 0, 0], body["mass"], [0, 0, 0], moments)
        made.add_freejoint()
        self.put_start(body, body["position"], body["velocity"])

    def add_top(self, number, body, ball):
        """Adds a body that is held to the world by a ball joint."""
        cannot(ball["b"] != -1, "ball joints between bodies")
        centre = [-component for component in ball["anchor_a"]]
        world = self.spec.worldbody
        made = self.add(world, number, ball["anchor_b"], body["mass"], centre, body["inertia"])
        made.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
        self.put_start(body, [], [])

    def add_chain(self):
        """Adds points on a chain of rods that moves in a plane: a hinge for each rod."""
        axis, found = hinges(self.scene)
        parent = self.spec.worldbody
        moments = [LEAST_MOMENT_ON_A_ROD] * 3
        for hinge in found:
            mass = self.scene.bodies[hinge.number]["mass"]
            parent = self.add(parent, hinge.number, hinge.at, mass, hinge.arm, moments)
            parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
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


def solve(scene):
    """One run of the integrator that was asked for."""
    world = World(scene)
    model = mjx.put_model(world.model)
    state = mjx.put_data(world.model, world.data)
    # Compiled for the kinds of joints, not for their numbers: no step is taken here.
    advanced(model, state, 0).qpos.block_until_ready()
    scene.warm()
    for sample, t in enumerate(scene.times):
        if sample > 0:
            state = advanced(model, state, scene.stride)
        for number, found in enumerate(world.states(state)):
            scene.rows.append((t, number, *found))


served.run(solve, *KNOWN)
