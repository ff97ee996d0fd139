"""A scene in Exudyn: free bodies, springs, rods, a top on a ball joint, uniform gravity.

The explicit methods integrate rotation vectors as a Lie group and have no constraints; the implicit
one, the trapezoidal method, has Euler parameters and joints with multipliers.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import border
import served
from served import cannot

# isort: split
import exudyn
import exudyn.utilities as made
import numpy as np

KNOWN = ("uniform_gravity", "spring", "rod", "ball_joint")
LEAST_MOMENT = 1e-3
"""Of a free point [kg m^2], which feels no torque: a mass matrix with 0 is singular."""
OUTPUT = exudyn.OutputVariableType
SOLVERS = {
    "rk44": exudyn.DynamicSolverType.RK44,
    "generalized-alpha": exudyn.DynamicSolverType.GeneralizedAlpha,
}


class World:
    """Exudyn's system of a scene, and the numbers of its bodies there."""

    def __init__(self, scene):
        self.scene = scene
        self.is_explicit = scene.method == "rk44"
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.CreateGround()
        self.bodies = [self.put_body(body) for body in scene.bodies]
        for spring in scene.of_kind("spring"):
            self.put_spring(spring)
        cannot(self.is_explicit and scene.of_kind("rod"), "rods under an explicit method")
        cannot(self.is_explicit and scene.of_kind("ball_joint"), "joints under an explicit method")
        for rod in scene.of_kind("rod"):
            cannot(any(rod["anchor_a"]), "anchors off the centre")
            self.put_rod(rod)
        for joint in scene.of_kind("ball_joint"):
            self.put_joint(joint)
        self.system.Assemble()

    def put_body(self, body):
        """Puts a body into the system: a mass point, or a rigid body."""
        if not any(body["inertia"]) and not self.scene.of_kind("ball_joint"):
            return self.system.CreateMassPoint(
                referencePosition=body["position"],
                initialVelocity=body["velocity"],
                mass=body["mass"],
                gravity=self.scene.gravity,
            )
        node = exudyn.NodeType.RotationEulerParameters
        if self.is_explicit:
            node = exudyn.NodeType.RotationRotationVector
        moments = self.scene.moments(body, LEAST_MOMENT)
        return self.system.CreateRigidBody(
            referencePosition=body["position"],
            referenceRotationMatrix=np.array(border.matrix(body["attitude"])),
            initialVelocity=body["velocity"],
            initialAngularVelocity=body["omega"],
            inertia=made.RigidBodyInertia(mass=body["mass"], inertiaTensor=np.diag(moments)),
            gravity=self.scene.gravity,
            nodeType=node,
        )

    def ends(self, element):
        """The numbers of the two bodies that an element joins, and its two anchors."""
        a = self.bodies[element["a"]]
        b = self.ground
        if element["b"] >= 0:
            b = self.bodies[element["b"]]
        return [a, b], element["anchor_a"], element["anchor_b"]

    def put_spring(self, spring):
        """Puts a linear spring; one without length needs no direction."""
        is_linear = spring["exponent"] == 1 and spring["quadratic"] == spring["cubic"] == 0
        cannot(not is_linear, "springs that are not linear")
        bodies, first, second = self.ends(spring)
        ends = {"bodyNumbers": bodies, "localPosition0": first, "localPosition1": second}
        stiffness = spring["stiffness"]
        if spring["length"] == 0:
            self.system.CreateCartesianSpringDamper(stiffness=[stiffness] * 3, **ends)
        else:
            length = spring["length"]
            self.system.CreateSpringDamper(stiffness=stiffness, referenceLength=length, **ends)

    def put_rod(self, rod):
        """Puts a rod as a distance constraint."""
        bodies, first, second = self.ends(rod)
        self.system.CreateDistanceConstraint(
            bodyNumbers=bodies,
            localPosition0=first,
            localPosition1=second,
            distance=rod["length"],
        )

    def put_joint(self, joint):
        """Puts a ball joint to the world."""
        cannot(joint["b"] != -1, "ball joints between bodies")
        bodies, _, place = self.ends(joint)
        self.system.CreateSphericalJoint(bodyNumbers=bodies, position=place)

    def run(self):
        """All steps in one call; the rows of the trajectory are kept at the samples."""
        scene = self.scene
        count = scene.stride * (len(scene.times) - 1)
        # Exudyn calls the function at the start too, before any step.
        steps = -1

        def after(system, time):
            nonlocal steps
            steps += 1
            if steps % scene.stride == 0:
                self.keep(steps // scene.stride)
            return True

        self.system.SetPostStepUserFunction(after)
        settings = exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.timeIntegration.endTime = scene.step * count
        settings.timeIntegration.numberOfSteps = count
        settings.timeIntegration.automaticStepSize = False
        settings.timeIntegration.adaptiveStep = False
        settings.timeIntegration.newton.absoluteTolerance = 1e-13
        settings.timeIntegration.newton.relativeTolerance = 1e-13
        settings.timeIntegration.newton.useModifiedNewton = False
        self.system.SolveDynamic(settings, solverType=SOLVERS[scene.method])

    def keep(self, sample):
        """Keeps the rows of all bodies at a sample."""
        for number, state in enumerate(self.states()):
            self.scene.rows.append((self.scene.times[sample], number, *state))

    def output(self, number, name):
        """A quantity of a body at its centre."""
        now = exudyn.ConfigurationType.Current
        return self.system.GetObjectOutputBody(number, name, [0.0, 0.0, 0.0], now)

    def states(self):
        """Position, velocity, attitude (w first) and omega of each body."""
        for body, number in zip(self.scene.bodies, self.bodies, strict=True):
            position = self.output(number, OUTPUT.Position)
            velocity = self.output(number, OUTPUT.Velocity)
            if not any(body["inertia"]):
                yield position, velocity, body["attitude"], body["omega"]
                continue
            rows = np.reshape(self.output(number, OUTPUT.RotationMatrix), (3, 3))
            attitude = border.quaternion(rows.tolist())
            omega = self.output(number, OUTPUT.AngularVelocity)
            yield position, velocity, attitude, omega


def solve(scene):
    """One run of the method that was asked for."""
    World(scene).run()


served.run(solve, *KNOWN)
