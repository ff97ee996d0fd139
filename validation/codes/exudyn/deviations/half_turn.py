"""Exudyn's rigid body starts with half of the digits near half a turn.

`CreateRigidBody` makes the coordinates of its node, a rotation vector or Euler parameters, of the
matrix that it is given. Near half a turn they come from a number that is almost 0: the attitude is
off by 2e-8 where the turn lacks 1e-8 rad of half a turn. The documentation of rotation vectors
speaks of the turn by 2 pi alone.
"""

import exudyn
import exudyn.utilities as made
import numpy as np


def error(angle, kind):
    """The error of the matrix of a body that starts turned by that angle about z."""
    system = exudyn.SystemContainer().AddSystem()
    body = system.CreateRigidBody(
        referencePosition=[0, 0, 0],
        referenceRotationMatrix=made.RotationMatrixZ(angle),
        inertia=made.RigidBodyInertia(mass=1, inertiaTensor=np.eye(3)),
        nodeType=kind,
    )
    system.Assemble()
    output = exudyn.OutputVariableType.RotationMatrix
    start = exudyn.ConfigurationType.Initial
    rows = np.reshape(system.GetObjectOutputBody(body, output, [0, 0, 0], start), (3, 3))
    return np.abs(rows - made.RotationMatrixZ(angle)).max()


for offset in (1.0, 1e-1, 1e-2, 1e-4, 1e-6, 1e-8):
    vector = error(np.pi - offset, exudyn.NodeType.RotationRotationVector)
    parameters = error(np.pi - offset, exudyn.NodeType.RotationEulerParameters)
    before = f"{offset:.0e} rad before half a turn"
    print(f"{before}: rotation vector {vector:.0e}, Euler parameters {parameters:.0e}")
