"""DART's exponential map is cut off after two terms below 1e-3 rad, so that steps turn too far.

`expMapRot` of a rotation vector shorter than 1e-3 is 1 + [q] + [q]^2/2: an error of q^3/6, which
is 1.7e-10 where the branches meet, in place of 1e-16. A body that spins at 1 rad/s turns 2.7e-7
rad too far in 2 s at a step of 0.9 ms, and not at all too far at 1.1 ms. At a step of 1 ms it is
the speed that decides, at 1 rad/s. The attitude is kept as a rotation vector too, which is expanded
in the same way while it is shorter than 1e-3: a body that starts without turn is off by once more
than one that starts turned. DART's documentation says of the function that it "computes the
Rotation matrix from a given expmap vector" (Geometry.hpp), and of no error.
"""

import dartpy as dart
import numpy as np

for angle in (2e-3, 1.1e-3, 9e-4, 1e-4):
    rotation = dart.math.expMapRot(np.array([0.0, 0.0, angle]))
    print(f"expMapRot of {angle:.1e} rad: sine off by {rotation[1, 0] - np.sin(angle):.1e}")


def too_far(step, speed, start, count):
    """The turn [rad] beyond count steps at that speed about z, from a turn about z at the start."""
    world = dart.simulation.World()
    world.setGravity([0.0, 0.0, 0.0])
    world.setTimeStep(step)
    skeleton = dart.dynamics.Skeleton("body")
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dart.dynamics.Inertia(1.0, np.zeros(3), np.eye(3)))
    world.addSkeleton(skeleton)
    joint.setPositions(np.array([0.0, 0.0, start, 0.0, 0.0, 0.0]))
    joint.setAngularVelocity(np.array([0.0, 0.0, speed]))
    for _ in range(count):
        world.step()
    rotation = body.getWorldTransform().rotation()
    return np.arctan2(rotation[1, 0], rotation[0, 0]) - start - count * speed * step


for step in (2e-3, 1.1e-3, 9e-4, 5e-4):
    off = too_far(step, 1.0, 0.0, round(2.0 / step))
    print(f"steps of {step:.1e} s at 1 rad/s: {off:.1e} rad too far")
for speed in (2.0, 1.001, 0.999, 0.5):
    off = too_far(1e-3, speed, 0.0, 1000)
    expected = 1000 * (speed * 1e-3) ** 3 / 6 * (speed < 1)
    print(f"1000 steps of 1 ms at {speed} rad/s: {off:.2e} rad too far, q^3/6 each: {expected:.2e}")
for start in (0.0, 5e-4, 0.1):
    off = too_far(9e-4, 1.0, start, 1)
    print(f"one step of 0.9 ms from a turn of {start} rad: {off:.2e} rad too far")
