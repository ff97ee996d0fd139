"""A scene in Box2D: discs and boxes in a plane, edges for planes, distance joints for rods.

Box2D is planar and in single precision. The plane of a scene is x, y; restitution and friction of
two surfaces are mixed (the larger restitution, the geometric mean of frictions). Box2D counts
lengths in units of its own: bodies slower than 1 unit a second do not bounce, and edges have a skin
of 0.01 units, a step is 2 units long at most (deviations/). The driver takes 128 units to the metre
where bodies meet, and 1 elsewhere: both are powers of two.
"""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import served
from served import cannot, half_sides

# isort: split
import Box2D

KNOWN = ("uniform_gravity", "plane", "contact", "rod")
UNITS_OF_CONTACT = 128.0
"""Units of Box2D's length in a metre, where bodies meet; more would meet b2_maxTranslation."""
FAR = 100.0
"""Half the length [m] of the edge that stands for a plane."""
LEAST_MOMENT = 1e-3
"""Of a point [kg m^2], which feels no torque: Box2D takes 0 for a body that cannot turn."""


class World:
    """Box2D's world of a scene, and its bodies."""

    def __init__(self, scene):
        self.law = scene.rigid_contact()
        self.units = 1.0
        if self.law is not None:
            self.units = UNITS_OF_CONTACT
        self.world = Box2D.b2World(gravity=self.scaled(scene.gravity), doSleep=False)
        self.made = []
        for body in scene.bodies:
            self.put_body(body)
        for plane in scene.of_kind("plane"):
            cannot(self.law is None, "planes without a contact law")
            self.put_plane(plane)
        for rod in scene.of_kind("rod"):
            self.put_rod(rod, scene.bodies)

    def scaled(self, vector):
        """The first two components of a vector in units of Box2D's length."""
        return (self.units * vector[0], self.units * vector[1])

    def put_body(self, body):
        """Puts a body into the world."""
        _, _, z = body["position"]
        w, qx, qy, qz = body["attitude"]
        cannot(z != 0 or body["velocity"][2] != 0, "motion out of the plane x, y")
        cannot(
            qx != 0 or qy != 0 or any(body["omega"][:2]), "a body that turns out of the plane x, y"
        )
        made = self.world.CreateDynamicBody(
            position=self.scaled(body["position"]),
            angle=2 * math.atan2(qz, w),
            linearVelocity=self.scaled(body["velocity"]),
            angularVelocity=body["omega"][2],
            allowSleep=False,
        )
        if self.law is not None:
            self.put_shape(made, body["shape"])
        moment = self.units**2 * (body["inertia"][2] or LEAST_MOMENT)
        made.massData = Box2D.b2MassData(mass=body["mass"], I=moment, center=(0.0, 0.0))
        self.made.append(made)

    def put_shape(self, made, shape):
        """Puts the shape of a body on it; points have none."""
        surface = {
            "density": 1.0,
            "friction": self.law["friction"],
            "restitution": self.law["restitution"],
        }
        if shape["kind"] == "sphere":
            made.CreateCircleFixture(radius=self.units * shape["radius"], **surface)
        elif shape["kind"] == "polyhedron":
            half = half_sides(shape)
            made.CreatePolygonFixture(box=self.scaled(half), **surface)

    def put_plane(self, plane):
        """Puts a plane as a long edge into the world."""
        nx, ny, nz = plane["normal"]
        cannot(nz != 0, "planes that are not upright on the plane x, y")
        px, py, _ = plane["point"]
        first = (px - FAR * ny, py + FAR * nx)
        second = (px + FAR * ny, py - FAR * nx)
        edge = Box2D.b2EdgeShape(vertices=[self.scaled(first), self.scaled(second)])
        ground = self.world.CreateStaticBody()
        ground.CreateFixture(
            shape=edge, friction=self.law["friction"], restitution=self.law["restitution"]
        )

    def put_rod(self, rod, bodies):
        """Puts a rod between centres, or from a centre to the world, as a distance joint."""
        cannot(any(rod["anchor_a"]), "anchors off the centre")
        a = self.made[rod["a"]]
        if rod["b"] == -1:
            b = self.world.CreateStaticBody()
            end = rod["anchor_b"]
        else:
            cannot(any(rod["anchor_b"]), "anchors off the centre")
            b = self.made[rod["b"]]
            end = bodies[rod["b"]]["position"]
        start = bodies[rod["a"]]["position"]
        joint = self.world.CreateDistanceJoint(
            bodyA=a, bodyB=b, anchorA=self.scaled(start), anchorB=self.scaled(end)
        )
        joint.length = self.units * rod["length"]

    def state(self, made):
        """Position, velocity, attitude (w first) and omega of a body."""
        half = made.angle / 2
        x, y = made.position
        vx, vy = made.linearVelocity
        position = (x / self.units, y / self.units, 0.0)
        velocity = (vx / self.units, vy / self.units, 0.0)
        attitude = (math.cos(half), 0.0, 0.0, math.sin(half))
        return position, velocity, attitude, (0.0, 0.0, made.angularVelocity)

    def states(self):
        """The states of all bodies."""
        return [self.state(made) for made in self.made]


def solve(scene):
    """One run, in a world of its own."""
    cannot(scene.gravity[2] != 0, "gravity out of the plane x, y")
    made = World(scene)
    scene.sampled(lambda: made.world.Step(scene.step, 200, 200), made.states)


served.run(solve, *KNOWN)
