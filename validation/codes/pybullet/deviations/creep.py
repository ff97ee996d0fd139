"""Bullet's block creeps down a slope that friction just holds, however many iterations there are.

The slope is 3 in 4 and the friction 3/4: the whole limit is needed, and nothing is left to brake a
speed once it is there. The block gains its speed in its first steps, while points of contact still
arrive, and keeps it: 0.45 m/s times the step h in seconds. Stopped once, when all points are there,
it keeps 0.010 h to 0.015 h, which is unexplained. With more friction it comes to rest. The default
slop of 1e-5 m (slop.py) delays points of contact at small steps, and the speed is up to 1.7 h.
"""

import pybullet as bullet

GRAVITY = 9.8125  # [m/s^2]
MASS = 3.0  # [kg], and half the sides [m]: the block of the gate
HALF_SIDES = [1.0, 0.125, 1.0]
SECONDS = 0.5  # as the gate asks: the speed has come within 20 steps
STEP = 2.0**-11  # [s]: the finest of the gate


def creep(step=STEP, iterations=200, friction=0.75, slop=0.0, stop_after=None):
    """Speed [m/s] along the slope and number of points of contact, after each step.

    `stop_after` is a number of steps after which the block is stopped once.
    """
    bullet.connect(bullet.DIRECT)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=step,
        numSolverIterations=iterations,
        solverResidualThreshold=0.0,
        contactERP=0.0,
        contactSlop=slop,
        restitutionVelocityThreshold=0.0,
    )
    # The slope is the plane y = 0, and gravity is turned.
    bullet.setGravity(0.6 * GRAVITY, -0.8 * GRAVITY, 0.0)
    shape = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=[0.0, 1.0, 0.0])
    slope = bullet.createMultiBody(0.0, shape)
    shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=HALF_SIDES)
    block = bullet.createMultiBody(MASS, shape, -1, [0.0, HALF_SIDES[1], 0.0])
    # Bullet multiplies the frictions of two that meet.
    bullet.changeDynamics(slope, -1, lateralFriction=1.0)
    undamped = {"linearDamping": 0.0, "angularDamping": 0.0}
    bullet.changeDynamics(block, -1, lateralFriction=friction, **undamped)
    speeds = []
    points = []
    for number in range(round(SECONDS / step)):
        if number == stop_after:
            bullet.resetBaseVelocity(block, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
        bullet.stepSimulation()
        velocity, _ = bullet.getBaseVelocity(block)
        speeds.append(velocity[0])
        points.append(len(bullet.getContactPoints(slope, block)))
    bullet.disconnect()
    return speeds, points


def arrivals(points):
    """The steps after which a point of contact more is there."""
    before = [0, *points[:-1]]
    return [number for number, (a, b) in enumerate(zip(before, points, strict=True), 1) if b > a]


for power in range(8, 13):
    step = 2.0**-power
    speeds, points = creep(step)
    stopped, _ = creep(step, stop_after=16)
    end, left = speeds[-1], stopped[-1]
    arrive = ", ".join(map(str, arrivals(points)))
    found = f"points arrive in the steps {arrive}; {end:.3e} m/s = {end / step:.3f} h at the end"
    kept = f"{left:.1e} m/s = {left / step:.4f} h, 1/{end / left:.0f} of it"
    print(f"h = 2^-{power} s: {found}; stopped once after 16 steps {kept}")
for power in range(10, 13):
    step = 2.0**-power
    speeds, points = creep(step, slop=1e-5)
    arrive = ", ".join(map(str, arrivals(points)))
    found = f"points arrive in the steps {arrive}; {speeds[-1] / step:.3f} h at the end"
    print(f"with slop 1e-5 m, h = 2^-{power} s: {found}")
for iterations in (50, 200, 5000):
    speeds, _ = creep(iterations=iterations)
    print(f"{iterations:4} iterations: {speeds[-1]:.3e} m/s at the end")
for stop_after in (1, 3, 4, 8, 16):
    speeds, _ = creep(stop_after=stop_after)
    print(f"stopped after {stop_after} steps: {speeds[-1]:.3e} m/s at the end")
for friction in (0.76, 0.9):
    speeds, _ = creep(friction=friction)
    print(f"friction {friction}: at most {max(speeds):.3e} m/s, {speeds[-1]:.3e} m/s at the end")
