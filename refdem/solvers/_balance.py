"""Whether a scene at rest certainly stays at rest: forces that add up to zero, or stacks that stand
on a plane.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import rotated
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _particles

Array = NDArray[np.float64]

SLACK = 8 * 2.0**-52
"""Positions and sums of forces are rounded a few times; what is off by no more balances."""


def unbalanced(scene: Scene) -> str | None:
    """None if springs, fields and contacts add up to zero on every body that is not fixed."""
    bodies = scene.bodies
    net = np.zeros_like(bodies.position)
    size = np.zeros(len(bodies))

    def push(body: int, force: Array) -> None:
        if body >= 0:
            net[body] += force
            size[body] += np.linalg.norm(force)

    for spring in scene.all(Spring):
        line = _end(scene, spring) - bodies.position[spring.a]
        distance = float(np.linalg.norm(line))
        stretch = distance - spring.length
        pull = float(spring.pull(np.array(stretch)))
        if distance == 0.0 and spring.length > 0:
            return "a spring without direction"
        force = pull * line / (distance or 1.0)
        push(spring.a, force)
        push(spring.b, -force)
    for number, mass in enumerate(bodies.mass):
        for gravity in scene.all(UniformGravity):
            push(number, mass * np.array(gravity.g))
        place = bodies.position[number]
        for field in scene.all(CentralField):
            # F = -gm m r/|r|^3.
            push(number, -field.gm * mass * place / np.linalg.norm(place) ** 3)
    for i, j in _particles.pairs(scene):
        overlap, normal = _overlap(scene, i, j)
        law = scene.all(Contact)[0]
        force = law.stiffness * max(overlap, 0.0) ** law.exponent * normal
        push(i, -force)
        push(j, force)
    free = ~bodies.fixed
    off = np.linalg.norm(net[free], axis=1) > SLACK * size[free]
    if off.any():
        return "the forces do not add up to zero"
    return None


def _end(scene: Scene, spring: Spring) -> Array:
    """Where the second end of a spring is (3,) [m]: at a body, or fixed in space."""
    if spring.b >= 0:
        end: Array = scene.bodies.position[spring.b]
        return end
    return np.array(spring.anchor_b)


def _overlap(scene: Scene, i: int, j: int) -> tuple[float, Array]:
    """Overlap [m] of sphere i with sphere j or plane -1 - j, and the unit normal from i to the
    other.
    """
    bodies = scene.bodies
    if j < 0:
        plane = scene.all(Plane)[-1 - j]
        normal = -np.array(plane.normal)
        depth = (bodies.position[i] - np.array(plane.point)) @ normal
        return float(bodies.radius[i] + depth), normal
    line = bodies.position[j] - bodies.position[i]
    distance = float(np.linalg.norm(line))
    return float(bodies.radius[i] + bodies.radius[j] - distance), line / distance


def falling(scene: Scene, law: Contact) -> str | None:
    """None if every body stands on the one plane, or on exactly one other body, with its load's
    centre over the support.
    """
    load = pressed(scene)
    if isinstance(load, str):
        return load
    if load.steepness > law.friction * (1 + SLACK):
        return "static friction does not hold them"
    down = load.gravity / load.pressing
    return _Standing(scene, load.normal, load.point, down).fault()


@dataclass(frozen=True)
class Load:
    """Gravity (3,) [m/s^2] on one plane: its part `pressing` against the `normal`, and `along` (3,)
    the plane.
    """

    normal: Array
    point: Array
    gravity: Array
    pressing: float

    @property
    def along(self) -> Array:
        """What is left of gravity without its part against the normal."""
        return np.asarray(self.gravity + self.pressing * self.normal)

    @property
    def steepness(self) -> float:
        """The tangent of the plane's slope: gravity along the plane over gravity against it."""
        return float(np.linalg.norm(self.along)) / self.pressing


def pressed(scene: Scene) -> Load | str:
    """Gravity on the one plane, or why there is no such thing."""
    planes = scene.all(Plane)
    fields = [np.array(field.g) for field in scene.all(UniformGravity)]
    gravity = np.sum([np.zeros(3), *fields], axis=0)
    if len(planes) != 1:
        return f"{len(planes)} planes; expected one"
    normal = np.array(planes[0].normal)
    pressing = -float(gravity @ normal)
    if not pressing > 0:
        return "gravity does not press the bodies on the plane"
    return Load(normal, np.array(planes[0].point), gravity, pressing)


def tipping(scene: Scene, law: Contact, load: Load) -> str | None:
    """None if the one body slides down the plane without turning: what carries it, tilted by
    friction, goes through its foot.
    """
    if not load.steepness > law.friction * (1 + SLACK):
        return "static friction holds it"
    downhill = load.along / np.linalg.norm(load.along)
    # What carries the body is the normal force with friction mu of it, uphill: this is its reverse.
    down = law.friction * downhill - load.normal
    return _Standing(scene, load.normal, load.point, down).fault()


class _Standing:
    """Bodies on a plane as columns over it: heights of their lowest and highest vertices, and who
    stands on whom.
    """

    def __init__(self, scene: Scene, normal: Array, point: Array, down: Array) -> None:
        self.scene = scene
        self.normal = normal
        self.down = down
        self.vertices = [
            _outline(scene, number, normal) - point for number in range(len(scene.bodies))
        ]
        self.heights = [v @ normal for v in self.vertices]
        self.size = max(float(np.abs(v).max()) for v in self.vertices)

    def faces(self, body: int, highest: bool) -> Array:
        """Points (M, 3) of the highest or the lowest face."""
        height = self.heights[body]
        if highest:
            edge = height.max()
        else:
            edge = height.min()
        level: Array = self.vertices[body][np.abs(height - edge) <= SLACK * self.size]
        return level

    def below(self, body: int) -> list[int]:
        """What the lowest face is level with, of that which it stands over: -1 is the plane."""
        low = self.heights[body].min()
        rounding = SLACK * self.size
        if abs(low) <= rounding:
            found = [-1]
        else:
            found = []
        for other in range(len(self.heights)):
            if other == body:
                continue
            is_level = abs(self.heights[other].max() - low) <= rounding
            if is_level and self._over(body, other):
                found.append(other)
        return found

    def _over(self, body: int, other: int) -> bool:
        """Whether the centre of the lowest face of a body lies over the highest face of another."""
        centre = self.faces(body, highest=False).mean(axis=0)
        return self._inside(centre, self.faces(other, highest=True))

    def _inside(self, point: Array, face: Array) -> bool:
        """The point, carried down along gravity, lies in the convex hull of the face."""
        drop = (point - face[0]) @ self.normal
        flat = face - (point + drop * self.down)
        axis = np.eye(3)[int(np.argmin(np.abs(self.normal)))]
        first = np.cross(self.normal, axis)
        first /= np.linalg.norm(first)
        x = flat @ first
        y = flat @ np.cross(self.normal, first)
        if np.any(np.hypot(x, y) <= SLACK * self.size):
            return True
        # Inside, no two neighbouring corners are seen more than half a turn apart.
        angles = np.sort(np.arctan2(y, x))
        gaps = np.diff([*angles, angles[0] + 2 * np.pi])
        return bool(gaps.max() <= np.pi * (1 + SLACK))

    def fault(self) -> str | None:
        """None if all stand, else what is missing."""
        under: dict[int, int] = {}
        for body in range(len(self.heights)):
            found = self.below(body)
            if self.scene.bodies.fixed[body] or len(found) != 1:
                return f"body {body} does not stand on exactly one thing"
            under[body] = found[0]
        for body in under:
            load = [other for other in under if body in _path(other, under)]
            mass = self.scene.bodies.mass[load]
            place = self.scene.bodies.position[load]
            centre = mass @ place / mass.sum() - self._origin(body)
            faces = [self.faces(body, highest=False)]
            if under[body] >= 0:
                faces.append(self.faces(under[body], highest=True))
            if not all(self._inside(centre, face) for face in faces):
                return (
                    f"the centre of mass of what stands on the foot of body {body} is not over it"
                )
        return None

    def _origin(self, body: int) -> Array:
        """The plane's point, from which vertices are measured."""
        origin: Array = _outline(self.scene, body, self.normal)[0] - self.vertices[body][0]
        return origin


def _path(body: int, under: dict[int, int]) -> list[int]:
    """The body and all that it stands on."""
    found = []
    while body >= 0 and body not in found:
        found.append(body)
        body = under[body]
    return found


def _outline(scene: Scene, body: int, normal: Array) -> Array:
    """Vertices (M, 3) in space; of a sphere its lowest and its highest point."""
    shape = scene.bodies.shape[body]
    place = scene.bodies.position[body]
    if isinstance(shape, Polyhedron):
        from_centre = rotated(scene.bodies.attitude[body], np.array(shape.vertices, float))
    else:
        if isinstance(shape, Sphere):
            radius = shape.radius
        else:
            radius = 0.0
        from_centre = np.array([-1.0, 1.0])[:, None] * radius * normal
    outline: Array = place + from_centre
    return outline
