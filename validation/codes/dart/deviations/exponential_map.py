"""DART's exponential map is cut off after two terms below 1e-3 rad, so that steps turn too far.

`expMapRot` of a rotation vector shorter than 1e-3 is 1 + [q] + [q]^2/2: an error of q^3/6, which
is 1.7e-10 where the branches meet, in place of 1e-16. A body that spins at 1 rad/s turns 2.7e-7
rad too far in 2 s at a step of 0.9 ms, and not at all too far at 1.1 ms. Nothing in DART's
documentation of the function or of FreeJoint speaks of it.
"""

import dartpy as dart
import numpy as np

for angle in (2e-3, 1.1e-3, 9e-4, 1e-4):
    rotation = dart.math.expMapRot(np.array([0.0, 0.0, angle]))
    print(f"expMapRot of {angle:.1e} rad: sine off by {rotation[1, 0] - np.sin(angle):.1e}")

for step in (2e-3, 1.1e-3, 9e-4, 5e-4):
    world = dart.simulation.World()
    world.setGravity([0.0, 0.0, 0.0])
    world.setTimeStep(step)
    skeleton = dart.dynamics.Skeleton("body")
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dart.dynamics.Inertia(1.0, np.zeros(3), np.eye(3)))
    world.addSkeleton(skeleton)
    joint.setAngularVelocity(np.array([0.0, 0.0, 1.0]))
    count = round(2.0 / step)
    for _ in range(count):
        world.step()
    rotation = body.getWorldTransform().rotation()
    angle = np.arctan2(rotation[1, 0], rotation[0, 0])
    print(f"steps of {step:.1e} s at 1 rad/s: {angle - count * step:.1e} rad too far")
