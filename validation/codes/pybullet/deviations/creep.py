"""Bullet's box creeps down a slope that friction just holds, however many iterations there are.

The slope is 3 in 4 and the friction 3/4: the whole limit is needed, and nothing is left to brake a
speed once it is there. The box gains its speed in its first steps, while points of contact still
arrive, and keeps it. Stopped once, when all points are there, it keeps a sixtieth of it, 0.11 m/s
times the step in seconds, which is unexplained. With more friction it comes to rest.
"""

import pybullet as bullet

GRAVITY = 9.8125  # [m/s^2]
SECONDS = 0.5  # as the gate asks: the speed has come within 20 steps
STEP = 1 / 1024  # [s]


def creep(iterations, friction=0.75, stop_after=None):
    """Speed [m/s] along the slope and number of points of contact, after each step.

    `stop_after` is a number of steps after which the box is stopped once.
    """
    bullet.connect(bullet.DIRECT)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=STEP,
        numSolverIterations=iterations,
        solverResidualThreshold=0.0,
        contactERP=0.0,
        restitutionVelocityThreshold=0.0,
    )
    # The slope is the plane y = 0, and gravity is turned.
    bullet.setGravity(0.6 * GRAVITY, -0.8 * GRAVITY, 0.0)
    shape = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=[0.0, 1.0, 0.0])
    slope = bullet.createMultiBody(0.0, shape)
    shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=[0.5, 0.5, 0.5])
    box = bullet.createMultiBody(1.0, shape, -1, [0.0, 0.5, 0.0])
    # Bullet multiplies the frictions of two that meet.
    bullet.changeDynamics(slope, -1, lateralFriction=1.0)
    bullet.changeDynamics(box, -1, lateralFriction=friction, linearDamping=0.0, angularDamping=0.0)
    speeds = []
    points = []
    for number in range(round(SECONDS / STEP)):
        if number == stop_after:
            bullet.resetBaseVelocity(box, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
        bullet.stepSimulation()
        velocity, _ = bullet.getBaseVelocity(box)
        speeds.append(velocity[0])
        points.append(len(bullet.getContactPoints(slope, box)))
    bullet.disconnect()
    return speeds, points


for iterations in (50, 200, 5000):
    speeds, points = creep(iterations)
    print(f"{iterations:4} iterations: {speeds[-1]:.3e} m/s at the end; points {points[:6]}")
for stop_after in (1, 2, 4, 8):
    speeds, points = creep(200, stop_after=stop_after)
    print(f"stopped after {stop_after} steps: {speeds[-1]:.3e} m/s at the end")
for friction in (0.76, 0.9):
    speeds, points = creep(200, friction=friction)
    print(f"friction {friction}: at most {max(speeds):.3e} m/s, {speeds[-1]:.3e} m/s at the end")
