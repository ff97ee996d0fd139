"""A scene in PyBullet: free bodies, rigid spheres and boxes, planes, uniform gravity.

Bullet's world is three-dimensional, its quaternions are (x, y, z, w), and every body is the base of
a multi-body (Featherstone's algorithm), which is what PyBullet makes of a body by itself.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import served
from served import cannot, half_sides

# What Bullet prints when it is imported must not come among the answers: the helper is first.
# isort: split
import pybullet as bullet

LEAST_MOMENT = 1e-3
"""Of a point [kg m^2], which feels no torque: Bullet takes 0 for a body that cannot turn."""
MOST_SPEED = 1e9
"""Of a coordinate; Bullet cuts at 100 by itself."""
KNOWN = ("uniform_gravity", "plane", "contact")


def seen_from(bodies):
    """The distance [m] below which Bullet has a contact.

    A sphere that is seen before it touches may lose its bounce (deviations/touch.py); a box that is
    at rest needs contacts that last.
    """
    if any(body["shape"]["kind"] == "polyhedron" for body in bodies):
        return 0.02
    return 1e-9


def shape_of(body):
    """The collision shape of a body; -1 for a point."""
    shape = body["shape"]
    if shape["kind"] == "sphere":
        return bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=shape["radius"])
    if shape["kind"] == "polyhedron":
        return bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half_sides(shape))
    return -1


def surface(law):
    """The settings of a surface; Bullet multiplies those of two that meet."""
    if law is None:
        return {}
    restitution = law["restitution"] ** 0.5
    friction = law["friction"] ** 0.5
    return {"restitution": restitution, "lateralFriction": friction}


def put_body(scene, body, law):
    """Puts a body of the scene into Bullet's world; its number there."""
    shape = -1
    if law is not None:
        shape = shape_of(body)
    w, x, y, z = body["attitude"]
    number = bullet.createMultiBody(body["mass"], shape, -1, body["position"], [x, y, z, w])
    bullet.changeDynamics(
        number,
        -1,
        localInertiaDiagonal=scene.moments(body, LEAST_MOMENT),
        linearDamping=0.0,
        angularDamping=0.0,
        maxJointVelocity=MOST_SPEED,
        **surface(law),
    )
    bullet.resetBaseVelocity(number, body["velocity"], body["omega"])
    return number


def put_plane(plane, law):
    """Puts a plane, which rests, into Bullet's world."""
    shape = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=plane["normal"])
    number = bullet.createMultiBody(0.0, shape, -1, plane["point"])
    bullet.changeDynamics(number, -1, **surface(law))


def state(number):
    """Position, velocity, attitude (w first) and omega of a body."""
    position, (x, y, z, w) = bullet.getBasePositionAndOrientation(number)
    velocity, omega = bullet.getBaseVelocity(number)
    return position, velocity, (w, x, y, z), omega


def solve(scene):
    """One run, in a world of its own."""
    law = scene.rigid_contact()
    world = bullet.connect(bullet.DIRECT)
    try:
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=scene.step,
            numSolverIterations=200,
            solverResidualThreshold=0.0,
            contactERP=0.0,
            contactSlop=0.0,
            contactBreakingThreshold=seen_from(scene.bodies),
            restitutionVelocityThreshold=0.0,
            deterministicOverlappingPairs=1,
        )
        bullet.setGravity(*scene.gravity)
        numbers = [put_body(scene, body, law) for body in scene.bodies]
        for plane in scene.of_kind("plane"):
            cannot(law is None, "planes without a contact law")
            put_plane(plane, law)
        scene.sampled(bullet.stepSimulation, lambda: [state(number) for number in numbers])
    finally:
        bullet.disconnect(world)


served.run(solve, *KNOWN)
