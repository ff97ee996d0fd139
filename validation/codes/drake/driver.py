"""A scene in Drake: free bodies, a pendulum or a chain of rods in a plane, uniform gravity.

A MultibodyPlant is either discrete, with a step of its own, or continuous, under an integrator; the
methods are one of the first kind and one of the second, with steps that are fixed.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import served

# isort: split
import numpy as np
from hinges import hinges
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

KNOWN = ("uniform_gravity", "rod")
LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""
INTEGRATORS = {"runge-kutta-3": "runge_kutta3"}


def inertia(scene, body):
    """Mass and moments of inertia about the centre."""
    moments = np.array(scene.moments(body, LEAST_MOMENT))
    unit = UnitInertia(*(moments / body["mass"]))
    return SpatialInertia(body["mass"], np.zeros(3), unit)


def put_chain(scene, plant):
    """Points on rods as bodies on hinges, by number, and the rates of the hinges."""
    axis, found = hinges(scene)
    bodies = {}
    rates = []
    parent = plant.world_body()
    for hinge in found:
        mass = scene.bodies[hinge.number]["mass"]
        point = SpatialInertia(mass, hinge.arm, UnitInertia.PointMass(hinge.arm))
        body = plant.AddRigidBody(f"b{hinge.number}", point)
        offset = FixedOffsetFrame(f"f{hinge.number}", parent.body_frame(), RigidTransform(hinge.at))
        upper = plant.AddFrame(offset)
        joint = RevoluteJoint(f"j{hinge.number}", upper, body.body_frame(), axis, damping=0.0)
        rates.append((plant.AddJoint(joint), hinge.rate))
        bodies[hinge.number] = (body, hinge.arm)
        parent = body
    return bodies, rates


def put_start(scene, plant, context, bodies, rates):
    """Puts the state of the scene into a context."""
    for joint, rate in rates:
        joint.set_angular_rate(context, rate)
    if rates:
        return
    for number, (body, _) in bodies.items():
        said = scene.bodies[number]
        turned = Quaternion(np.array(said["attitude"]) / np.linalg.norm(said["attitude"]))
        plant.SetFreeBodyPose(context, body, RigidTransform(turned, said["position"]))
        moving = SpatialVelocity(w=said["omega"], v=said["velocity"])
        plant.SetFreeBodySpatialVelocity(context, body, moving)


def states(scene, plant, context, bodies):
    """Position, velocity, attitude (w first) and omega of each body."""
    for number, said in enumerate(scene.bodies):
        body, arm = bodies[number]
        pose = plant.EvalBodyPoseInWorld(context, body)
        motion = plant.EvalBodySpatialVelocityInWorld(context, body)
        lever = pose.rotation().multiply(arm)
        position = pose.translation() + lever
        velocity = motion.translational() + np.cross(motion.rotational(), lever)
        if any(said["inertia"]):
            attitude = pose.rotation().ToQuaternion().wxyz()
            yield position, velocity, attitude, motion.rotational()
        else:
            yield position, velocity, said["attitude"], said["omega"]


def solve(scene):
    """One run of the method that was asked for."""
    is_discrete = scene.method not in INTEGRATORS
    plant = MultibodyPlant(time_step=scene.step if is_discrete else 0.0)
    rates = []
    if scene.of_kind("rod"):
        bodies, rates = put_chain(scene, plant)
    else:
        bodies = {
            number: (plant.AddRigidBody(f"b{number}", inertia(scene, body)), np.zeros(3))
            for number, body in enumerate(scene.bodies)
        }
    plant.mutable_gravity_field().set_gravity_vector(scene.gravity)
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    put_start(scene, plant, context, bodies, rates)
    if not is_discrete:
        ResetIntegratorFromFlags(simulator, INTEGRATORS[scene.method], scene.step)
        simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.Initialize()

    def advance():
        if is_discrete:
            # The simulator would compare times, and take a step more or less where they round.
            context.SetDiscreteState(plant.EvalUniquePeriodicDiscreteUpdate(context))
        else:
            simulator.AdvanceTo(context.get_time() + scene.step)

    scene.sampled(advance, lambda: states(scene, plant, context, bodies))


served.run(solve, *KNOWN)
