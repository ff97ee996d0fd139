"""Tests whether a scene at rest stays at rest: forces that add up to zero, or stacks that stand on
a plane.

A stack stands if every body rests on exactly one support, and the centre of mass of all that it
carries, projected along gravity, lies in the convex hull of the common face.
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
"""Relative rounding of positions and of sums of forces; a smaller imbalance counts as none."""


def _spring_force(scene: Scene, spring: Spring) -> Array | None:
    """The force (3,) [N] of a spring on its first end, None if it is undetermined: a spring with a
    natural length whose ends coincide has no direction.

    F = f(|d| - l) d/|d|, where d is the vector from the first end to the second, l the natural
    length and f the pull.
    """
    line = _end(scene, spring) - scene.bodies.position[spring.a]
    distance = float(np.linalg.norm(line))
    pull = float(spring.pull(np.array(distance - spring.length)))
    if distance > 0:
        return np.asarray(pull * line / distance)
    if spring.length > 0:
        return None
    return np.zeros(3)


def unbalanced(scene: Scene) -> str | None:
    """None if springs, gravity, central field and contacts add up to zero on every free body, else
    the reason.
    """
    bodies = scene.bodies
    net = np.zeros_like(bodies.position)
    total_magnitude = np.zeros(len(bodies))

    def push(body: int, force: Array) -> None:
        """Adds a force [N] to the net force on a body; the world, index -1, is skipped."""
        if body >= 0:
            net[body] += force
            total_magnitude[body] += np.linalg.norm(force)

    for spring in scene.all(Spring):
        force = _spring_force(scene, spring)
        if force is None:
            return "a spring without direction"
        push(spring.a, force)
        push(spring.b, -force)
    for body, mass in enumerate(bodies.mass):
        for gravity in scene.all(UniformGravity):
            push(body, mass * np.array(gravity.g))
        position = bodies.position[body]
        for field in scene.all(CentralField):
            # F = -gm m r/|r|^3.
            push(body, -field.gm * mass * position / np.linalg.norm(position) ** 3)
    for i, j in _particles.pairs(scene):
        overlap, normal = _overlap(scene, i, j)
        law = scene.all(Contact)[0]
        # F = k d^e along the normal; nothing moves, so dashpots have no force.
        force = law.stiffness * max(overlap, 0.0) ** law.exponent * normal
        push(i, -force)
        push(j, force)
    free = ~bodies.fixed
    imbalanced = np.linalg.norm(net[free], axis=1) > SLACK * total_magnitude[free]
    if imbalanced.any():
        return "the forces do not add up to zero"
    return None


def _end(scene: Scene, spring: Spring) -> Array:
    """Position (3,) [m] of a spring's second end: on a body, or fixed in space."""
    if spring.b >= 0:
        end: Array = scene.bodies.position[spring.b]
        return end
    return np.array(spring.anchor_b)


def _overlap(scene: Scene, i: int, j: int) -> tuple[float, Array]:
    """Overlap [m] of sphere i with sphere j (or with plane k, given as j = -1 - k), and the unit
    normal from i to it.
    """
    bodies = scene.bodies
    if j < 0:
        plane = scene.all(Plane)[-1 - j]
        normal = -np.array(plane.normal)
        # d = R - h, where h is the height of the centre above the plane; `depth` is -h.
        depth = (bodies.position[i] - np.array(plane.point)) @ normal
        return float(bodies.radius[i] + depth), normal
    # Two spheres: d = R_i + R_j - |r_j - r_i|.
    line = bodies.position[j] - bodies.position[i]
    distance = float(np.linalg.norm(line))
    return float(bodies.radius[i] + bodies.radius[j] - distance), line / distance


def falling(scene: Scene, law: Contact) -> str | None:
    """None if every body stands stably on the plane or on exactly one other body, else the
    reason.
    """
    load = pressed(scene)
    if isinstance(load, str):
        return load
    if load.steepness > law.friction * (1 + SLACK):
        return "static friction does not hold them"
    down = load.gravity / load.pressing
    return _Standing(scene, load.normal, load.point, down).instability()


@dataclass(frozen=True)
class Load:
    """Gravity [m/s^2] on one plane with unit `normal` (3,) through `point` (3,).

    `gravity` (3,) has the component `pressing` against the normal, and `along` (3,) in the plane.
    """

    normal: Array
    point: Array
    gravity: Array
    pressing: float

    @property
    def along(self) -> Array:
        """The component of gravity in the plane (3,) [m/s^2]."""
        return np.asarray(self.gravity + self.pressing * self.normal)

    @property
    def steepness(self) -> float:
        """The tangent of the plane's slope, |along| / pressing."""
        return float(np.linalg.norm(self.along)) / self.pressing


def pressed(scene: Scene) -> Load | str:
    """Gravity resolved on the one plane, or the reason why there is no such plane."""
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
    """None if the one body slides down the plane without tipping over, else the reason.

    The plane exerts the normal force N and the friction mu N uphill on a sliding body. The body
    does not rotate if the line through the centre of mass along that force meets the face on which
    the body slides.
    """
    if not load.steepness > law.friction * (1 + SLACK):
        return "static friction holds it"
    downhill = load.along / np.linalg.norm(load.along)
    # The reverse of the plane's force n - mu downhill, in units of N.
    down = law.friction * downhill - load.normal
    return _Standing(scene, load.normal, load.point, down).instability()


def overturning(scene: Scene, load: Load, line: Array) -> str | None:
    """None if the one body slides in both directions of a line (3,) of the plane without tipping
    over, driven by a force at its centre along that line, else the reason.

    The plane exerts the normal force N and a friction of at most mu N against the motion. This
    force can have zero torque about the centre if the line through the centre along it meets the
    face on which the body slides.
    """
    friction = scene.all(Contact)[0].friction
    for heading in (line, -line):
        # The reverse of the plane's force n - mu heading, in units of N.
        down = friction * heading - load.normal
        reason = _Standing(scene, load.normal, load.point, down).instability()
        if reason is not None:
            return reason
    return None


class _Standing:
    """Bodies in stacks on a plane: the lowest and highest face of each, and its supports.

    Heights are measured from the plane along its `normal`; `down` is the direction in which weight
    acts, scaled so that down . normal = -1.
    """

    def __init__(self, scene: Scene, normal: Array, point: Array, down: Array) -> None:
        self.scene = scene
        self.normal = normal
        self.down = down
        self.vertices = [_outline(scene, body, normal) - point for body in range(len(scene.bodies))]
        self.heights = [v @ normal for v in self.vertices]
        self.size = max(float(np.abs(v).max()) for v in self.vertices)

    def faces(self, body: int, highest: bool) -> Array:
        """Vertices (M, 3) of the highest or of the lowest face."""
        height = self.heights[body]
        if highest:
            edge = height.max()
        else:
            edge = height.min()
        level: Array = self.vertices[body][np.abs(height - edge) <= SLACK * self.size]
        return level

    def below(self, body: int) -> list[int]:
        """The supports at the height of the body's lowest face and underneath it; -1 is the
        plane.
        """
        lowest = self.heights[body].min()
        rounding = SLACK * self.size
        if abs(lowest) <= rounding:
            supports = [-1]
        else:
            supports = []
        for other in range(len(self.heights)):
            if other == body:
                continue
            is_level = abs(self.heights[other].max() - lowest) <= rounding
            if is_level and self._over(body, other):
                supports.append(other)
        return supports

    def _over(self, body: int, other: int) -> bool:
        """True if the centre of a body's lowest face lies over the highest face of another."""
        centre = self.faces(body, highest=False).mean(axis=0)
        return self._inside(centre, self.faces(other, highest=True))

    def _inside(self, point: Array, face: Array) -> bool:
        """True if the point, projected along `down` onto the face's plane, lies in the face's
        convex hull.
        """
        # The projection of the point p is p + h down, with h = (p - face) . n, as down . n = -1.
        height = (point - face[0]) @ self.normal
        corners = face - (point + height * self.down)
        reference = np.eye(3)[int(np.argmin(np.abs(self.normal)))]
        tangent = np.cross(self.normal, reference)
        tangent /= np.linalg.norm(tangent)
        # Coordinates of the corners in the plane, relative to the projected point.
        x = corners @ tangent
        y = corners @ np.cross(self.normal, tangent)
        if np.any(np.hypot(x, y) <= SLACK * self.size):
            return True
        # A point is inside if and only if no two neighbouring corners subtend more than pi at it.
        angles = np.sort(np.arctan2(y, x))
        gaps = np.diff([*angles, angles[0] + 2 * np.pi])
        return bool(gaps.max() <= np.pi * (1 + SLACK))

    def instability(self) -> str | None:
        """None if all bodies stand, else the first reason why not."""
        support: dict[int, int] = {}
        for body in range(len(self.heights)):
            supports = self.below(body)
            if self.scene.bodies.fixed[body] or len(supports) != 1:
                return f"body {body} does not stand on exactly one thing"
            support[body] = supports[0]
        for body in support:
            carried = [other for other in support if body in _support_path(other, support)]
            mass = self.scene.bodies.mass[carried]
            position = self.scene.bodies.position[carried]
            # Centre of mass sum m r/sum m of all bodies that this one carries, itself included.
            centre = mass @ position / mass.sum() - self._origin(body)
            faces = [self.faces(body, highest=False)]
            if support[body] >= 0:
                faces.append(self.faces(support[body], highest=True))
            if not all(self._inside(centre, face) for face in faces):
                return (
                    f"the centre of mass of what stands on the foot of body {body} is not over it"
                )
        return None

    def _origin(self, body: int) -> Array:
        """The plane's point, from which vertices are measured."""
        origin: Array = _outline(self.scene, body, self.normal)[0] - self.vertices[body][0]
        return origin


def _support_path(body: int, support: dict[int, int]) -> list[int]:
    """The body, its support, the support of that, and so on down to the plane."""
    path = []
    while body >= 0 and body not in path:
        path.append(body)
        body = support[body]
    return path


def _outline(scene: Scene, body: int, normal: Array) -> Array:
    """Vertices (M, 3) [m] of a body in space; of a sphere its lowest and its highest point."""
    shape = scene.bodies.shape[body]
    centre = scene.bodies.position[body]
    if isinstance(shape, Polyhedron):
        from_centre = rotated(scene.bodies.attitude[body], np.array(shape.vertices, float))
    else:
        if isinstance(shape, Sphere):
            radius = shape.radius
        else:
            radius = 0.0
        from_centre = np.array([-1.0, 1.0])[:, None] * radius * normal
    outline: Array = centre + from_centre
    return outline
