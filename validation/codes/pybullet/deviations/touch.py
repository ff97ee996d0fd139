"""Bullet's ball that comes within the contact distance at the end of a step loses its bounce.

Contacts begin at `contactBreakingThreshold` = 0.02 m by default. A ball that is seen in the step
before it touches is slowed by the distance over the step, and not by its speed, so that it creeps
to the wall. PyBullet's guide says of this setting only that contacts beyond it are taken away.
With 1e-9 m every ball bounces.
"""

import pybullet as bullet

STEP = 0.01  # [s]: the ball moves 0.01 m in a step


def bounced(height, threshold):
    """The velocity [m/s] 0.7 s after the start of a ball of 1 m/s at that height above a plane."""
    bullet.connect(bullet.DIRECT)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=STEP,
        contactERP=0.0,
        restitutionVelocityThreshold=1e-9,
        contactBreakingThreshold=threshold,
    )
    plane = bullet.createMultiBody(0.0, bullet.createCollisionShape(bullet.GEOM_PLANE))
    sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.5)
    ball = bullet.createMultiBody(1.0, sphere, -1, [0.0, 0.0, 0.5 + height])
    bullet.changeDynamics(plane, -1, restitution=1.0)
    bullet.changeDynamics(ball, -1, restitution=0.75, linearDamping=0.0)
    bullet.resetBaseVelocity(ball, [0.0, 0.0, -1.0])
    for _ in range(70):
        bullet.stepSimulation()
    velocity, _ = bullet.getBaseVelocity(ball)
    bullet.disconnect()
    return velocity[2]


for part in range(8):
    height = 0.5 + STEP * part / 8
    default = bounced(height, 0.02)
    close = bounced(height, 1e-9)
    print(
        f"{part}/8 of a step above: {default:8.5f} by default, {close:8.5f} with 1e-9 (law: 0.75)"
    )
