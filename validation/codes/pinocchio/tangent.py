"""The derivatives of a motion in Pinocchio by K numbers of its scene.

Pinocchio differentiates accelerations by the state (`computeABADerivatives`) and the exponential
map of each joint (`dIntegrate`). With the joint torques tau(q, v, a) = 0 of inverse dynamics and
the mass matrix M, a number s of the model moves accelerations by

    da/ds = -M^-1 dtau/ds at fixed q, v and a.

Torques are linear in the inertial parameters (`computeJointTorqueRegressor`) and in gravity. The
place of a joint on its parent is the coordinate of a joint that slides and is held, so that dtau/ds
is a derivative by a coordinate (`computeRNEADerivatives`).

Derivatives of a configuration are in its tangent space, as Pinocchio's: of a joint that turns they
are rotations in body axes.
"""

import numpy as np
import pinocchio as pin
from hinges import LEAST_SINE, hinges
from served import cannot
from world import World

DIAGONAL = [4, 6, 9]
"""Where Ixx, Iyy and Izz are among the inertial parameters of a body on its joint, which are
m, m c (3), Ixx, Ixy, Iyy, Ixz, Iyz, Izz.
"""
TENSOR = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])
"""The rows and the columns of these six moments."""


class Held(World):
    """The model in which each place of a joint is the coordinate of a joint that slides, and does
    not move. A joint at the origin of its parent has none.
    """

    def __init__(self, scene):
        self.moving_q = []
        self.moving_v = []
        super().__init__(scene)

    def add(self, parent, joint, at, q, v):
        """Adds a joint on one that slides to a place (3) of the parent; the number of the first."""
        if at is not None:
            slide = pin.JointModelTranslation()
            parent = super().add(parent, slide, None, at, np.zeros(3))
            self.moving_q += [False] * 3
            self.moving_v += [False] * 3
        self.moving_q += [True] * len(q)
        self.moving_v += [True] * len(v)
        return super().add(parent, joint, None, q, v)

    def whole(self, q, v):
        """The state of all joints, those that are held included."""
        whole_q = self.q.copy()
        whole_q[self.moving_q] = q
        return whole_q, self.spread(v)

    def spread(self, rates):
        """Rates (nv, ...) of the joints that move, with 0 for those that are held."""
        whole = np.zeros((self.v.size, *rates.shape[1:]))
        whole[self.moving_v] = rates
        return whole


class Tangent:
    """A world and its derivatives by K numbers: of the configuration, `dq` (nv, K), of the
    velocities, `dv` (nv, K), and of the model.
    """

    def __init__(self, scene):
        self.scene = scene
        self.world = World(scene)
        self.held = Held(scene)
        self.data = self.world.model.createData()
        self.changes = scene.changes()
        count = len(self.changes)
        nv = self.world.model.nv
        self.dq = np.zeros((nv, count))
        self.dv = np.zeros((nv, count))
        self.places = np.zeros((self.held.model.nv, count))
        # Of the inertial parameters (10 a joint), gravity (3), and the offsets (3) by body.
        self.inertias = np.zeros((10 * (self.world.model.njoints - 1), count))
        self.gravity = np.array([change.gravity for change in self.changes]).T
        self.offsets = {number: np.zeros((3, count)) for number in self.world.joints}
        self.falls = [falling(self.world.model, axis) for axis in np.eye(3)]
        self.start()

    def of_body(self, number, name):
        """The derivatives (K) or (n, K) of one entry of a body."""
        return np.array([change.bodies[number][name] for change in self.changes], float).T

    def start(self):
        """Puts the derivatives of the model and of the start."""
        tops = {joint["a"]: place for place, joint in enumerate(self.scene.of_kind("ball_joint"))}
        is_chain = bool(self.scene.of_kind("rod"))
        if is_chain:
            self.start_chain()
        for number in range(len(self.scene.bodies)):
            if number in tops:
                self.start_top(number, tops[number])
            elif not is_chain:
                self.start_free(number)
            self.put_inertia(number)

    def start_free(self, number):
        """Puts the start of a free body: its position and velocity, and how it turns."""
        turn = self.world.joints[number]
        slide = rows(self.world, self.world.model.parents[turn])
        self.dq[slide] = self.of_body(number, "position")
        self.dv[slide] = self.of_body(number, "velocity")
        self.start_turning(number)

    def start_turning(self, number):
        """Puts the start of a joint that turns as the body does."""
        body = self.scene.bodies[number]
        turn = rows(self.world, self.world.joints[number])
        w, x, y, z = body["attitude"]
        dw, dx, dy, dz = self.of_body(number, "attitude")
        # The vector of q* dq, with q = (w, r): w dr - r dw - r x dr.
        vector_x = w * dx - x * dw - y * dz + z * dy
        vector_y = w * dy - y * dw - z * dx + x * dz
        vector_z = w * dz - z * dw - x * dy + y * dx
        # The rotation in body axes is the vector of 2 q* dq; a change of |q| is no rotation.
        rotation = 2 * np.array([vector_x, vector_y, vector_z])
        to_body = pin.Quaternion(w, x, y, z).toRotationMatrix().T
        omega = to_body @ np.array(body["omega"])
        self.dq[turn] = rotation
        # With Omega = R^T omega, dOmega = R^T domega + Omega x rotation.
        self.dv[turn] = to_body @ self.of_body(number, "omega") + pin.skew(omega) @ rotation

    def start_top(self, number, place):
        """Puts the start of a body on the ball joint at a place among all."""
        balls = [change.of_kind("ball_joint")[place] for change in self.changes]
        self.offsets[number] = -np.array([ball["anchor_a"] for ball in balls]).T
        self.put_place(number, np.array([ball["anchor_b"] for ball in balls]).T)
        self.start_turning(number)

    def start_chain(self):
        """Puts the start of points on rods. Raises UnsupportedError for numbers that move them out
        of their plane.
        """
        axis, found = hinges(self.scene)
        # The chain of a change has the same numbers; its pivot is the change of the pivot.
        pivot = np.array([change.chain()[1] for change in self.changes]).T
        in_plane(axis, self.gravity)
        at = pivot
        above = pivot
        moving_above = np.zeros_like(pivot)
        turned = np.zeros(len(self.changes))
        v_above = np.zeros(3)
        for hinge in found:
            position = self.of_body(hinge.number, "position")
            moving = self.of_body(hinge.number, "velocity")
            arm = position - above
            in_plane(axis, arm)
            in_plane(axis, moving)
            v = np.array(self.scene.bodies[hinge.number]["velocity"])
            r = hinge.arm
            square = r @ r
            # omega = n . (r x v) / r^2, with v relative to the rod before:
            # domega = (n . (dr x v + r x dv) - 2 omega r . dr) / r^2.
            omega = axis @ np.cross(r, v - v_above) / square
            crossed = pin.skew(r) @ (moving - moving_above) - pin.skew(v - v_above) @ arm
            domega = (axis @ crossed - 2 * omega * (r @ arm)) / square
            self.dv[rows(self.world, self.world.joints[hinge.number])] = domega - turned
            self.put_place(hinge.number, at)
            self.offsets[hinge.number] = arm
            at = arm
            above = position
            moving_above = moving
            turned = domega
            v_above = v

    def put_place(self, number, change):
        """Puts the derivatives (3, K) of the place of the joint of a body."""
        slide = self.held.model.parents[self.held.joints[number]]
        self.places[rows(self.held, slide)] = change

    def put_inertia(self, number):
        """Puts the derivatives of the inertial parameters of a body on its joint. Raises
        UnsupportedError for moments of 0, as those of points: a body with moments turns.
        """
        joint = self.world.joints[number]
        body = self.scene.bodies[number]
        mass = body["mass"]
        c = self.world.offsets[number].translation
        dmass = self.of_body(number, "mass")
        dc = self.offsets[number]
        dmoments = self.of_body(number, "inertia")
        is_zero = np.array(body["inertia"]) == 0
        cannot(np.any(dmoments[is_zero]), "derivatives by moments of inertia that are 0")
        parameters = self.inertias[10 * (joint - 1) : 10 * joint]
        parameters[0] = dmass
        parameters[1:4] = np.outer(c, dmass) + mass * dc
        # I = diag(J) + m (c^2 - c c^T).
        parameters[DIAGONAL] = dmoments
        row, column = TENSOR
        parameters[4:] += np.outer((c @ c * np.eye(3) - np.outer(c, c))[TENSOR], dmass)
        parameters[4:] -= mass * (c[row, None] * dc[column] + dc[row] * c[column, None])
        parameters[DIAGONAL] += 2 * mass * (c @ dc)

    def accelerations(self, q, v, dq, dv):
        """The derivatives (nv, K) of the accelerations."""
        model = self.world.model
        by_q, by_v, by_torque = pin.computeABADerivatives(model, self.data, q, v, np.zeros_like(v))
        a = self.data.ddq.copy()
        regressor = pin.computeJointTorqueRegressor(model, self.data, q, v, a)
        # A matrix of one row comes as a vector.
        torques = np.atleast_2d(regressor) @ self.inertias
        if np.any(self.gravity):
            weights = [pin.computeGeneralizedGravity(fall, self.data, q) for fall in self.falls]
            torques += np.array(weights).T @ self.gravity
        if np.any(self.places):
            torques += self.by_places(q, v, a)
        return by_q @ dq + by_v @ dv - by_torque @ torques

    def by_places(self, q, v, a):
        """The derivatives (nv, K) of the torques by the places of joints."""
        held = self.held
        whole_q, whole_v = held.whole(q, v)
        by_q, _, _ = pin.computeRNEADerivatives(
            held.model, held.data, whole_q, whole_v, held.spread(a)
        )
        return by_q[held.moving_v] @ self.places

    def integrated(self, q, moved, dq, dmoved):
        """The derivatives (nv, K) of a configuration that is moved by (nv) on its joints."""
        by_q, by_moved = pin.dIntegrate(self.world.model, q, moved)
        return by_q @ dq + by_moved @ dmoved

    def euler(self):
        """A step of semi-implicit Euler of the world, and its derivatives."""
        h = self.scene.step
        q = self.world.q
        self.dv = self.dv + h * self.accelerations(q, self.world.v, self.dq, self.dv)
        self.world.euler()
        self.dq = self.integrated(q, h * self.world.v, self.dq, h * self.dv)

    def midpoint(self):
        """A step of the midpoint rule of the world, and its derivatives."""
        h = self.scene.step
        q = self.world.q
        v = self.world.v
        half_q, half_v = self.world.middle()
        half_dv = self.dv + h / 2 * self.accelerations(q, v, self.dq, self.dv)
        half_dq = self.integrated(q, h / 2 * v, self.dq, h / 2 * self.dv)
        self.world.midpoint()
        self.dv = self.dv + h * self.accelerations(half_q, half_v, half_dq, half_dv)
        self.dq = self.integrated(q, h * half_v, self.dq, h * half_dv)

    def states(self):
        """The derivatives of position, velocity, attitude (w first) and omega of each body: arrays
        (3, K) and (4, K).
        """
        held = self.held
        q, v = held.whole(self.world.q, self.world.v)
        dq = self.places + held.spread(self.dq)
        dv = held.spread(self.dv)
        model = held.model
        pin.forwardKinematics(model, held.data, q, v)
        pin.computeForwardKinematicsDerivatives(model, held.data, q, v, np.zeros_like(v))
        for number, body in enumerate(self.scene.bodies):
            position, velocity, rotation, omega = self.of_pose(number, dq, dv)
            if not any(body["inertia"]):
                attitude = self.of_body(number, "attitude")
                yield position, velocity, attitude, self.of_body(number, "omega")
                continue
            pose = held.data.oMi[held.joints[number]]
            x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
            # dq = q (0, rotation) / 2, rotation in body axes.
            columns = np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
            yield position, velocity, columns @ rotation / 2, omega

    def of_pose(self, number, dq, dv):
        """The derivatives (3, K) of position and velocity, of the rotation in body axes, and of
        omega.
        """
        held = self.held
        joint = held.joints[number]
        offset = held.offsets[number]
        by_q, by_v = pin.getFrameVelocityDerivatives(
            held.model, held.data, joint, offset, pin.LOCAL
        )
        # In axes of the body: the twist of its pose, and the change of its motion (v, Omega).
        twist = by_v @ dq
        change = by_q @ dq + by_v @ dv
        motion = offset.actInv(held.data.v[joint])
        rotation = twist[3:]
        doffset = self.offsets[number]
        # With c the centre on the joint: r = p + R c and v_space = R (v + Omega x c).
        position = twist[:3] + doffset
        velocity = change[:3] - pin.skew(motion.linear) @ rotation
        velocity += pin.skew(motion.angular) @ doffset
        omega = change[3:] - pin.skew(motion.angular) @ rotation
        to_space = held.data.oMi[joint].rotation
        return to_space @ position, to_space @ velocity, rotation, to_space @ omega


def rows(world, joint):
    """The rows of a joint among the velocities of a world."""
    first = world.model.idx_vs[joint]
    return slice(first, first + world.model.nvs[joint])


def in_plane(axis, vectors):
    """Raises UnsupportedError for changes (3, K) that leave the plane of the rods."""
    cannot(np.any(np.abs(axis @ vectors) > LEAST_SINE), "derivatives out of the plane of the rods")


def falling(model, axis):
    """A copy of a model, in a gravity of 1 m/s^2 along an axis (3)."""
    copy = model.copy()
    copy.gravity.linear = axis
    return copy
