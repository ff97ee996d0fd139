"""A scene in DART: free bodies, a chain of rods in a plane, uniform gravity.

A body is a skeleton of its own, and a chain of rods one skeleton of hinges; World.step is
semi-implicit Euler in the coordinates of the joints.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import border
import served

# isort: split
import dartpy as dart
import numpy as np
from hinges import hinges

KNOWN = ("uniform_gravity", "rod")
LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""


def transform(rotation, place):
    """A rotation (3, 3) and a place (3) as DART has them."""
    made = dart.math.Isometry3()
    made.set_rotation(np.array(rotation))
    made.set_translation(np.array(place))
    return made


def put_body(scene, number, body):
    """A skeleton of one free body with its start, and the body."""
    skeleton = dart.dynamics.Skeleton(f"s{number}")
    joint, node = skeleton.createFreeJointAndBodyNodePair()
    moments = np.diag(scene.moments(body, LEAST_MOMENT))
    node.setInertia(dart.dynamics.Inertia(body["mass"], np.zeros(3), moments))
    joint.setTransform(transform(border.matrix(body["attitude"]), body["position"]))
    joint.setLinearVelocity(np.array(body["velocity"]))
    joint.setAngularVelocity(np.array(body["omega"]))
    return skeleton, node


def put_chain(scene):
    """A skeleton of hinges with its start, and the bodies by number with their arms."""
    axis, found = hinges(scene)
    skeleton = dart.dynamics.Skeleton("chain")
    nodes = {}
    parent = None
    for hinge in found:
        properties = dart.dynamics.RevoluteJointProperties()
        properties.mAxis = axis
        properties.mName = f"j{hinge.number}"
        properties.mT_ParentBodyToJoint = transform(np.eye(3), hinge.at)
        joint, node = skeleton.createRevoluteJointAndBodyNodePair(parent, properties)
        mass = scene.bodies[hinge.number]["mass"]
        node.setInertia(dart.dynamics.Inertia(mass, hinge.arm, np.zeros((3, 3))))
        joint.setVelocity(0, hinge.rate)
        nodes[hinge.number] = (node, hinge.arm)
        parent = node
    return skeleton, nodes


def states(scene, nodes):
    """Position, velocity, attitude (w first) and omega of each body."""
    for number, body in enumerate(scene.bodies):
        node, arm = nodes[number]
        pose = node.getWorldTransform()
        position = pose.multiply(arm)
        velocity = node.getLinearVelocity(arm)
        if any(body["inertia"]):
            attitude = border.quaternion(pose.rotation().tolist())
            yield position, velocity, attitude, node.getAngularVelocity()
        else:
            yield position, velocity, body["attitude"], body["omega"]


def solve(scene):
    """One run, in a world of its own."""
    world = dart.simulation.World()
    world.setGravity(scene.gravity)
    world.setTimeStep(scene.step)
    # On by default: bodies at rest would be put to sleep.
    deactivation = world.getDeactivationOptions()
    deactivation.mEnabled = False
    world.setDeactivationOptions(deactivation)
    if scene.of_kind("rod"):
        skeleton, nodes = put_chain(scene)
        world.addSkeleton(skeleton)
    else:
        nodes = {}
        for number, body in enumerate(scene.bodies):
            skeleton, node = put_body(scene, number, body)
            world.addSkeleton(skeleton)
            nodes[number] = (node, np.zeros(3))
    scene.sampled(world.step, lambda: states(scene, nodes))


served.run(solve, *KNOWN)
