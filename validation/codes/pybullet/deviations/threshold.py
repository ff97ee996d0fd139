"""Bullet's ball does not bounce below a speed: restitution by the speed of the impact.

By default `restitutionVelocityThreshold` is 0.2 m/s, whatever the size and the gravity of a scene;
PyBullet's guide names it "below which restitution is 0". The driver sets 0.
"""

import pybullet as bullet

RESTITUTION = 0.75
"""Of the two surfaces together."""


def bounced(speed, **settings):
    """The speed [m/s] after the impact of a ball that falls on a plane without gravity."""
    bullet.connect(bullet.DIRECT)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=0.001, contactERP=0.0, contactBreakingThreshold=1e-9, **settings
    )
    plane = bullet.createMultiBody(0.0, bullet.createCollisionShape(bullet.GEOM_PLANE))
    sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.5)
    ball = bullet.createMultiBody(1.0, sphere, -1, [0.0, 0.0, 0.60037])
    bullet.changeDynamics(plane, -1, restitution=1.0)
    bullet.changeDynamics(ball, -1, restitution=RESTITUTION, linearDamping=0.0)
    bullet.resetBaseVelocity(ball, [0.0, 0.0, -speed])
    for _ in range(round(200 / speed)):
        bullet.stepSimulation()
    velocity, _ = bullet.getBaseVelocity(ball)
    bullet.disconnect()
    return velocity[2]


for speed in (1.0, 0.3, 0.21, 0.19, 0.1):
    as_shipped = bounced(speed) / speed
    tuned = bounced(speed, restitutionVelocityThreshold=0.0) / speed
    print(f"{speed:5} m/s: restitution {as_shipped:7.4f} by default, {tuned:.4f} with threshold 0")
