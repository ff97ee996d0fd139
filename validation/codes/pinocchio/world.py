"""The model of a scene in Pinocchio, and the steps of its state.

A free body is a joint that slides and one that turns on it: the velocities of a JointModelFreeFlyer
are in body axes, and no step keeps momentum with them (deviations/free_flyer.py).
"""

import numpy as np
import pinocchio as pin
from hinges import hinges
from served import cannot

LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""


def turning(body):
    """The coordinates of a joint that turns, (x, y, z, w), and its omega, in body axes."""
    w, x, y, z = body["attitude"]
    to_body = pin.Quaternion(w, x, y, z).toRotationMatrix().T
    return np.array([x, y, z, w]), to_body @ np.array(body["omega"])


class World:
    """The model of a scene, its state (q, v), and where each body is on its joint."""

    def __init__(self, scene):
        self.scene = scene
        self.model = pin.Model()
        self.model.gravity.linear = np.array(scene.gravity)
        # By the numbers of the bodies: the joint that carries it, and where it is on the joint.
        self.joints = {}
        self.offsets = {}
        self.q = np.zeros(0)
        self.v = np.zeros(0)
        tops = {joint["a"]: joint for joint in scene.of_kind("ball_joint")}
        if scene.of_kind("rod"):
            self.add_chain()
        for number, body in enumerate(scene.bodies):
            if number in tops:
                self.add_top(number, body, tops[number])
            elif number not in self.joints:
                self.add_free(number, body)
        self.data = self.model.createData()

    def add(self, parent, joint, at, q, v):
        """Adds a joint at a place (3) of its parent, None at the origin, with its coordinates; its
        number.
        """
        placement = pin.SE3.Identity()
        if at is not None:
            placement.translation = np.array(at)
        self.q = np.concatenate([self.q, q])
        self.v = np.concatenate([self.v, v])
        return self.model.addJoint(parent, joint, placement, f"{self.q.size}")

    def put(self, number, joint, offset, inertia):
        """Puts a body on a joint, its centre at `offset` (3)."""
        placement = pin.SE3(np.eye(3), offset)
        self.model.appendBodyToJoint(joint, inertia, placement)
        self.joints[number] = joint
        self.offsets[number] = placement

    def inertia(self, body):
        """Mass and moments of inertia about the centre."""
        moments = self.scene.moments(body, LEAST_MOMENT)
        return pin.Inertia(body["mass"], np.zeros(3), np.diag(moments))

    def add_free(self, number, body):
        """Adds a free body: it moves in space axes and turns in its own."""
        place = np.array(body["position"])
        slide = self.add(0, pin.JointModelTranslation(), None, place, body["velocity"])
        turn = self.add(slide, pin.JointModelSpherical(), None, *turning(body))
        self.put(number, turn, np.zeros(3), self.inertia(body))

    def add_top(self, number, body, ball):
        """Adds a body that is held to the world by a ball joint."""
        cannot(ball["b"] != -1, "ball joints between bodies")
        turn = self.add(0, pin.JointModelSpherical(), np.array(ball["anchor_b"]), *turning(body))
        self.put(number, turn, -np.array(ball["anchor_a"]), self.inertia(body))

    def add_chain(self):
        """Adds points on a chain of rods that moves in a plane: a hinge for each rod."""
        axis, found = hinges(self.scene)
        parent = 0
        for hinge in found:
            joint = pin.JointModelRevoluteUnaligned(axis)
            parent = self.add(parent, joint, hinge.at, np.zeros(1), np.array([hinge.rate]))
            mass = self.scene.bodies[hinge.number]["mass"]
            point = pin.Inertia(mass, np.zeros(3), np.zeros((3, 3)))
            self.put(hinge.number, parent, hinge.arm, point)

    def accelerations(self, q, v):
        """The accelerations of all joints."""
        return pin.aba(self.model, self.data, q, v, np.zeros_like(v))

    def euler(self):
        """Semi-implicit Euler: the new velocities move the joints."""
        h = self.scene.step
        self.v = self.v + h * self.accelerations(self.q, self.v)
        self.q = pin.integrate(self.model, self.q, h * self.v)

    def middle(self):
        """The state (q, v) after half a step of explicit Euler."""
        h = self.scene.step
        half_v = self.v + h / 2 * self.accelerations(self.q, self.v)
        half_q = pin.integrate(self.model, self.q, h / 2 * self.v)
        return half_q, half_v

    def midpoint(self):
        """The midpoint rule, explicit."""
        h = self.scene.step
        half_q, half_v = self.middle()
        self.v = self.v + h * self.accelerations(half_q, half_v)
        self.q = pin.integrate(self.model, self.q, h * half_v)

    def states(self):
        """Position, velocity, attitude (w first) and omega of each body."""
        pin.forwardKinematics(self.model, self.data, self.q, self.v)
        for number, body in enumerate(self.scene.bodies):
            joint = self.joints[number]
            offset = self.offsets[number]
            pose = self.data.oMi[joint] * offset
            motion = offset.actInv(self.data.v[joint])
            velocity = pose.rotation @ motion.linear
            if not any(body["inertia"]):
                yield pose.translation, velocity, body["attitude"], body["omega"]
                continue
            x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
            yield pose.translation, velocity, (w, x, y, z), pose.rotation @ motion.angular
