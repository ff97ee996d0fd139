"""A scene in Drake: free bodies, a pendulum or a chain of rods in a plane, uniform gravity.

A MultibodyPlant is either discrete, with a step of its own, or continuous, under an integrator; the
methods are one of the first kind and one of the second, with steps that are fixed.

Derivatives are Drake's own: the plant is converted to AutoDiffXd, the numbers of the scene that a
request asks for are put into its context as dual numbers, and the same steps are taken.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import served

# isort: split
import numpy as np
from hinges import LEAST_SINE, hinges
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.eigen_geometry import Quaternion_
from pydrake.math import RigidTransform, RigidTransform_
from pydrake.multibody.math import SpatialForce_, SpatialVelocity_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia_, UnitInertia_
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator_

KNOWN = ("uniform_gravity", "rod")
LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""
INTEGRATORS = {"runge-kutta-3": "runge_kutta3"}


def inertia(scene, body, scalar=float):
    """Mass and moments of inertia about the centre."""
    moments = np.array(scene.moments(body, LEAST_MOMENT))
    unit = UnitInertia_[scalar](*(moments / body["mass"]))
    return SpatialInertia_[scalar](body["mass"], alike(scalar, np.zeros(3)), unit)


def inertia_of_point(mass, arm, scalar=float):
    """A mass at the end of an arm (3) [m] from the hinge, which is the origin of its body."""
    arm = alike(scalar, arm)
    return SpatialInertia_[scalar](mass, arm, UnitInertia_[scalar].PointMass(arm))


def plant_of(scene):
    """A plant with the bodies of a scene, b0, b1 ...; points on rods hang on hinges j0, j1 ... in
    frames f0, f1 ... of the bodies above them.
    """
    is_discrete = scene.method not in INTEGRATORS
    plant = MultibodyPlant(time_step=scene.step if is_discrete else 0.0)
    if scene.of_kind("rod"):
        add_chain(scene, plant)
    else:
        for number, body in enumerate(scene.bodies):
            plant.AddRigidBody(f"b{number}", inertia(scene, body))
    plant.mutable_gravity_field().set_gravity_vector(scene.gravity)
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    return plant


def add_chain(scene, plant):
    """Adds points on rods as bodies on hinges."""
    axis, found = hinges(scene)
    parent = plant.world_body()
    for hinge in found:
        mass = scene.bodies[hinge.number]["mass"]
        body = plant.AddRigidBody(f"b{hinge.number}", inertia_of_point(mass, hinge.arm))
        offset = FixedOffsetFrame(f"f{hinge.number}", parent.body_frame(), RigidTransform(hinge.at))
        upper = plant.AddFrame(offset)
        plant.AddJoint(
            RevoluteJoint(f"j{hinge.number}", upper, body.body_frame(), axis, damping=0.0)
        )
        parent = body


def put_chain(scene, plant, context, scalar):
    """Puts the numbers of points on rods into a context; the arms (3) [m] by number of the body."""
    axis, found = hinges(scene)
    refuse_other_planes(scene, axis, found)
    arms = {}
    for hinge in found:
        number = hinge.number
        point = inertia_of_point(scene.bodies[number]["mass"], hinge.arm, scalar)
        plant.GetBodyByName(f"b{number}").SetSpatialInertiaInBodyFrame(context, point)
        at = RigidTransform_[scalar](alike(scalar, hinge.at))
        plant.GetFrameByName(f"f{number}").SetPoseInParentFrame(context, at)
        plant.GetJointByName(f"j{number}").set_angular_rate(context, hinge.rate)
        arms[number] = alike(scalar, hinge.arm)
    return arms


def refuse_other_planes(scene, axis, found):
    """Raises UnsupportedError for derivatives by numbers that move a chain out of its plane: the
    axis of a joint is no dual number.
    """
    fixed = np.array([dual_of(component).value() for component in axis])
    vectors = [hinge.arm for hinge in found] + [body["velocity"] for body in scene.bodies]
    for vector in [*vectors, scene.gravity]:
        out = slopes_of(fixed @ np.array(vector))
        served.cannot(np.any(np.abs(out) > LEAST_SINE), "derivatives out of the plane of the rods")


def put_free(scene, plant, context, scalar):
    """Puts the numbers of free bodies into a context; the arms (3) [m] by number, which are 0."""
    for number, said in enumerate(scene.bodies):
        body = plant.GetBodyByName(f"b{number}")
        body.SetSpatialInertiaInBodyFrame(context, inertia(scene, said, scalar))
        attitude, position, velocity, omega = (
            alike(scalar, said[name]) for name in ("attitude", "position", "velocity", "omega")
        )
        turned = Quaternion_[scalar](attitude / np.linalg.norm(attitude))
        plant.SetFreeBodyPose(context, body, RigidTransform_[scalar](turned, position))
        moving = SpatialVelocity_[scalar](w=omega, v=velocity)
        plant.SetFreeBodySpatialVelocity(context, body, moving)
    return dict.fromkeys(range(len(scene.bodies)), alike(scalar, np.zeros(3)))


def put_change_of_gravity(scene, plant, context, arms):
    """Applies forces that are 0 and whose derivatives are those of the weights.

    The gravity g of a plant is no dual number: with g0 its value, m (g - g0) acts at each centre.
    """
    gravity = alike(AutoDiffXd, scene.gravity)
    change = gravity - [component.value() for component in gravity]
    forces = []
    for number, arm in arms.items():
        force = ExternallyAppliedSpatialForce_[AutoDiffXd]()
        force.body_index = plant.GetBodyByName(f"b{number}").index()
        force.p_BoBq_B = arm
        weight = scene.bodies[number]["mass"] * change
        force.F_Bq_W = SpatialForce_[AutoDiffXd](tau=alike(AutoDiffXd, np.zeros(3)), f=weight)
        forces.append(force)
    plant.get_applied_spatial_force_input_port().FixValue(context, forces)


def states(scene, plant, context, arms):
    """Position, velocity, attitude (w first) and omega of each body."""
    for number, said in enumerate(scene.bodies):
        body = plant.GetBodyByName(f"b{number}")
        pose = plant.EvalBodyPoseInWorld(context, body)
        motion = plant.EvalBodySpatialVelocityInWorld(context, body)
        lever = pose.rotation().multiply(arms[number])
        position = pose.translation() + lever
        velocity = motion.translational() + np.cross(motion.rotational(), lever)
        if any(said["inertia"]):
            attitude = pose.rotation().ToQuaternion().wxyz()
            yield position, velocity, attitude, motion.rotational()
        else:
            yield position, velocity, said["attitude"], said["omega"]


def move(scene, plant, scalar):
    """Runs a plant of these scalars, float or AutoDiffXd, and keeps the rows in the scene."""
    simulator = Simulator_[scalar](plant)
    context = simulator.get_mutable_context()
    put = put_chain if scene.of_kind("rod") else put_free
    arms = put(scene, plant, context, scalar)
    if scalar is AutoDiffXd:
        put_change_of_gravity(scene, plant, context, arms)
    is_discrete = scene.method not in INTEGRATORS
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

    scene.sampled(advance, lambda: states(scene, plant, context, arms))


def alike(scalar, numbers):
    """An array of numbers of one kind: Drake 1.51.1 reads floats among dual numbers as dual ones,
    out of bounds.
    """
    if scalar is float:
        return np.array(numbers, float)
    return np.array([dual_of(number) for number in numbers])


def dual_of(number):
    """A number that may be a float as a dual number; the derivatives of a float are none."""
    if isinstance(number, AutoDiffXd):
        return number
    return AutoDiffXd(number)


def slopes_of(number):
    """The derivatives of a number that may be dual; those of a constant are none."""
    return dual_of(number).derivatives()


def solve(scene):
    """One run of the method that was asked for, and one in dual numbers if derivatives were."""
    plant = plant_of(scene)
    move(scene, plant, float)
    if not scene.sensitivities:
        return
    units = np.eye(len(scene.sensitivities))
    dual = scene.with_numbers(lambda number, place: AutoDiffXd(number, units[place]))
    move(dual, plant.ToAutoDiffXd(), AutoDiffXd)
    scene.differentiated(dual, slopes_of)


served.run(solve, *KNOWN)
