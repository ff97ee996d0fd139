"""Pinocchio's free flyer bends the way of a body that spins and on which nothing acts.

Its velocities are in body axes, where a body that spins has the acceleration -omega x v; an Euler
step of it, as Pinocchio's examples write it, changes the momentum by an error of first order. The
documentation of `integrate` says that velocities are in the frame of the joint, and does not say
this. A joint that slides and one that turns keep momentum to round-off, and so does a free flyer
that does not spin; the error grows with the square of the spin, and falls with the step.
"""

import numpy as np
import pinocchio as pin


def drift(joints, q, v, steps):
    """The change of the momentum of 1 kg in one second, with nothing that acts."""
    model = pin.Model()
    model.gravity.setZero()
    parent = 0
    for number, joint in enumerate(joints):
        parent = model.addJoint(parent, joint, pin.SE3.Identity(), str(number))
    model.appendBodyToJoint(parent, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    data = model.createData()
    momenta = []
    for _ in range(steps + 1):
        momenta.append(pin.computeCentroidalMomentum(model, data, q, v).linear.copy())
        acceleration = pin.aba(model, data, q, v, np.zeros(model.nv))
        v = v + acceleration / steps
        q = pin.integrate(model, q, v / steps)
    return max(np.linalg.norm(momentum - momenta[0]) for momentum in momenta)


start = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
motion = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
print("change of the momentum of 1 kg at 1 m/s")
for steps in (10, 100, 1000):
    flyer = drift([pin.JointModelFreeFlyer()], start, motion, steps)
    two = drift([pin.JointModelTranslation(), pin.JointModelSpherical()], start, motion, steps)
    print(f"{steps:5} steps a second: {flyer:.1e} as a free flyer, {two:.0e} as two joints")
for spin in (0.0, 0.5, 1.0, 2.0):
    spinning = motion.copy()
    spinning[5] = spin
    flyer = drift([pin.JointModelFreeFlyer()], start, spinning, 1000)
    print(f"spin {spin} rad/s, 1000 steps a second: {flyer:.1e} as a free flyer")
