"""Bullet's spheres lose a part of their bounce where they overlap by less than its slop.

By default `contactSlop` is 1e-5 m, whatever the size of a scene. Bullet's solver of multi-bodies
adds it to the distance of a contact, `cp.getDistance() + infoGlobal.m_linearSlop`, and takes what
is above 0 off the speed of the bounce, `velocityError -= distance / infoGlobal.m_timeStep`. With
the overlap d at the end of the step in which two spheres meet, their closing speed g along the
normal and the step h, the restitution that is seen is

    e - (slop - d)/(g h) for d < slop, at least 0;    e for d >= slop.

As d is at most g h, every impact loses bounce at steps below slop/g, and the smaller the step, the
more: the error grows as h falls. With slop 0 the error falls with the step, and what is left is
that of a normal that is up to one step late. The lines are those of Bullet's sources, in
btMultiBodyConstraintSolver.cpp; the package has none, and says of `setPhysicsEngineParameter` only
"Set some internal physics engine parameter, such as cfm or erp etc."
"""

import math

import pybullet as bullet

RESTITUTION = 0.75
"""Of the two surfaces together."""
RADIUS = 0.5  # [m]
SPEED = 1.0  # [m/s]: closing, along x
START = [2.0, 0.6]  # [m]: from centre to centre along x and y; the spheres meet 0.8 m apart along x
TIME = 2.375  # [s]: half of it after the impact at 1.2 s
NORMAL_SPEED = 0.8  # [m/s]: closing, along the normal of the impact


def impact(step, **settings):
    """The restitution along the normal of the exact impact, and the overlap [m] of the spheres at
    the end of the step in which they meet.
    """
    bullet.connect(bullet.DIRECT)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=step,
        contactERP=0.0,
        contactBreakingThreshold=1e-9,
        restitutionVelocityThreshold=0.0,
        **settings,
    )
    sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=RADIUS)
    balls = []
    for side in (-0.5, 0.5):
        place = [side * START[0], side * START[1], 0.0]
        ball = bullet.createMultiBody(1.0, sphere, -1, place)
        bullet.changeDynamics(
            ball,
            -1,
            restitution=math.sqrt(RESTITUTION),
            lateralFriction=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
        )
        bullet.resetBaseVelocity(ball, [-side * SPEED, 0.0, 0.0])
        balls.append(ball)
    overlap = None
    for _ in range(round(TIME / step)):
        places = [bullet.getBasePositionAndOrientation(ball)[0] for ball in balls]
        apart = math.dist(*places)
        if overlap is None and apart <= 2 * RADIUS:
            overlap = 2 * RADIUS - apart
        bullet.stepSimulation()
    (first, _), (second, _) = (bullet.getBaseVelocity(ball) for ball in balls)
    bullet.disconnect()
    parting = 0.8 * (second[0] - first[0]) + 0.6 * (second[1] - first[1])
    return parting / NORMAL_SPEED, overlap


def by_formula(step, overlap, slop):
    """The restitution that the formula above gives."""
    taken = max(0.0, slop - overlap) / (NORMAL_SPEED * step)
    return max(0.0, RESTITUTION - taken)


print("step [s], overlap [m]: restitution by default (by the formula), with slop 0 (law: 0.75)")
for power in range(9, 18):
    step = 2.0**-power
    default, overlap = impact(step)
    none, _ = impact(step, contactSlop=0.0)
    expected = by_formula(step, overlap, 1e-5)
    print(f"2^-{power}, {overlap:.1e}: {default:.5f} ({expected:.5f}), {none:.5f}")

print("the slop is varied, at 2^-11 s")
for slop in (0.0, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3):
    step = 2.0**-11
    seen, overlap = impact(step, contactSlop=slop)
    print(f"slop {slop:7.0e} m: {seen:.5f} ({by_formula(step, overlap, slop):.5f})")
