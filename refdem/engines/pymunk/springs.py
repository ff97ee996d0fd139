"""Force laws between two points that Chipmunk asks for in every step (`DampedSpring.force_func`):
springs that are not linear, and soft contacts of discs.

Chipmunk's sign: the force of a spring is positive where it pushes its two ends apart.
"""

from itertools import combinations

import pymunk

from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring

CENTRE = (0.0, 0.0)


def bent(joint: pymunk.DampedSpring, link: Spring) -> pymunk.DampedSpring:
    """The joint with the force law of a spring that is not linear.

    Pull = k |s|^n sgn(s) + a s^2 + b s^3 in the stretch s = distance - length.
    """

    def push(joint: pymunk.DampedSpring, distance: float) -> float:
        stretch = distance - link.length
        power = link.stiffness * abs(stretch) ** link.exponent
        if stretch < 0:
            power = -power
        pull: float = power + (link.quadratic + link.cubic * stretch) * stretch * stretch
        return -pull

    joint.force_func = push
    return joint


def add_soft_contacts(space: pymunk.Space, scene: Scene, bodies: list[pymunk.Body]) -> None:
    """Adds a one-sided spring for every pair of spheres, where the contact law has a stiffness."""
    for law in scene.all(Contact):
        if law.law == "rigid":
            continue
        balls = [
            (body, shape.radius)
            for body, shape in zip(bodies, scene.bodies.shape, strict=True)
            if isinstance(shape, Sphere)
        ]
        for (a, radius_a), (b, radius_b) in combinations(balls, 2):
            if a.body_type == b.body_type == pymunk.Body.STATIC:
                continue
            space.add(_pressing(a, b, radius_a + radius_b, law))


def _pressing(a: pymunk.Body, b: pymunk.Body, touching: float, law: Contact) -> pymunk.DampedSpring:
    """A spring between two centres that pushes while these are nearer than the sum of the radii.

    F = k d^n of the force function, with the overlap d = touching - distance, and c dd/dt of the
    joint's own damper. The damper acts at any distance, so that it is switched before each step: on
    while the discs overlap, for `zero_force` only while both forces together push.
    """
    joint = pymunk.DampedSpring(a, b, CENTRE, CENTRE, touching, law.stiffness, 0.0)
    may_pull = law.cutoff == "zero_overlap"

    def is_pressed(distance: float) -> bool:
        overlap = touching - distance
        if overlap <= 0:
            return False
        if may_pull or not law.damping:
            return True
        elastic = law.stiffness * overlap**law.exponent
        viscous = law.damping * _closing_speed(joint)
        return bool(elastic + viscous > 0)

    def push(joint: pymunk.DampedSpring, distance: float) -> float:
        if not is_pressed(distance):
            return 0.0
        pushing: float = law.stiffness * (touching - distance) ** law.exponent
        return pushing

    def switched(_: pymunk.Constraint, space: pymunk.Space) -> None:
        joint.damping = 0.0
        if is_pressed((b.position - a.position).length):
            joint.damping = law.damping

    joint.force_func = push
    if law.damping:
        joint.pre_solve = switched
    return joint


def _closing_speed(joint: pymunk.DampedSpring) -> float:
    """The speed [m/s] at which the centres of the joint's two bodies approach each other."""
    branch = joint.b.position - joint.a.position
    relative = joint.b.velocity - joint.a.velocity
    # -d|r|/dt = -v . r/|r| with the branch vector r.
    return float(-relative.dot(branch) / branch.length)
