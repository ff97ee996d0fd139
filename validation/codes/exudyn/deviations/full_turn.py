"""Exudyn's rotation vectors lose half of the digits where a step ends at a whole turn.

An explicit step turns a rotation vector by `CompositionRotationVector` (RigidBodyMath.h): the new
angle is pi - 2 atan2(x, sqrt(|1 - x^2|)), x the cosine of half of it. At no turn or a whole one
x is 1 but for rounding: 1 - x^2 is 0, or some u = 1e-16 whose root is 1e-8. Exudyn's list of
changes says of a whole turn that the formulas "take noise and pass it on rather than snapping to a
boundary". Here the end is varied: d away from no turn the attitude is off by about u/d, and not at
all elsewhere, half a turn included. A body that runs back to where it started ends at no turn.
"""

import exudyn
import exudyn.utilities as made
import numpy as np


def error(start, end):
    """The largest error of the matrix of a body that turns from one angle about z to another."""
    steps = 64
    system = exudyn.SystemContainer().AddSystem()
    body = system.CreateRigidBody(
        referencePosition=[0, 0, 0],
        referenceRotationMatrix=made.RotationMatrixZ(start),
        initialAngularVelocity=[0, 0, end - start],
        inertia=made.RigidBodyInertia(mass=1, inertiaTensor=np.eye(3)),
        nodeType=exudyn.NodeType.RotationRotationVector,
    )
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime = 1
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.automaticStepSize = False
    settings.timeIntegration.adaptiveStep = False
    system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
    now = exudyn.ConfigurationType.Current
    output = exudyn.OutputVariableType.RotationMatrix
    rows = np.reshape(system.GetObjectOutputBody(body, output, [0, 0, 0], now), (3, 3))
    return np.abs(rows - made.RotationMatrixZ(end)).max()


STARTS = np.linspace(0.5, 3.0, 41)
ENDS = {"no turn": 0.0, "half a turn": -np.pi, "a whole turn": -2 * np.pi, "0.3 rad": 0.3}
for name, end in ENDS.items():
    errors = [error(start, end) for start in STARTS]
    lossy = sum(off > 1e-9 for off in errors)
    print(
        f"to {name}: off by {max(errors):.0e} at most, by more than 1e-9 from {lossy} of 41 starts"
    )
for distance in (1e-2, 1e-4, 1e-6, 1e-8):
    errors = [error(start, distance) for start in STARTS]
    print(f"to {distance:.0e} rad before no turn: off by {max(errors):.0e} at most")
