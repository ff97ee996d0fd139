"""The contact kernel against a transparent numpy twin of its law and of velocity Verlet, step by
step.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

STEP = 2.0**-9
STEPS = 24
SLIP = {"R": 0.0, "R-d": 1.0, "R-d/2": 0.5, "slip-R": 0.0}
TORQUE = {"R": 0.0, "R-d": 1.0, "R-d/2": 0.5, "slip-R": 0.5}


class Twin:
    """Spheres in lasting contact whose tangential springs stick; everything as vectors, one pair
    after the other.
    """

    def __init__(self, scene: Scene) -> None:
        b = scene.bodies
        self.law = scene.all(Contact)[0]
        self.b = b
        self.planes = [(np.array(p.point), np.array(p.normal)) for p in scene.all(Plane)]
        self.gravity = sum((np.array(g.g) for g in scene.all(UniformGravity)), np.zeros(3))
        self.springs = scene.all(Spring)
        self.x, self.v, self.w, self.q = (
            np.array(a) for a in (b.position, b.velocity, b.omega, b.attitude)
        )
        n = len(b)
        self.pairs = [(i, j) for i in range(n) for j in range(i + 1, n)] + [
            (i, -1 - k) for i in range(n) for k in range(len(self.planes))
        ]
        self.s = {pair: np.zeros(3) for pair in self.pairs}
        self.a, self.alpha = self.accelerations(self.v, self.w)

    def geometry(self, pair, v, w):
        """Normal, overlap, its rate, slip, lever arms of the torque."""
        i, j = pair
        radius = self.b.radius
        if j < 0:
            point, normal = self.planes[-1 - j]
            n = -normal
            overlap = radius[i] - (self.x[i] - point) @ normal
            relative = v[i]
        else:
            line = self.x[j] - self.x[i]
            n = line / np.sqrt(line @ line)
            overlap = radius[i] + radius[j] - np.sqrt(line @ line)
            relative = v[i] - v[j]
        slip_arms, arms = (
            (
                radius[i] - share[self.law.branch] * overlap,
                (0.0 if j < 0 else radius[j] - share[self.law.branch] * overlap),
            )
            for share in (SLIP, TORQUE)
        )
        spin = slip_arms[0] * w[i] + (slip_arms[1] * w[j] if j >= 0 else 0.0)
        surface = relative + np.cross(spin, n)
        return n, overlap, relative @ n, surface - (surface @ n) * n, arms

    def accelerations(self, v, w):
        """Linear and angular accelerations (N, 3)."""
        force = np.outer(self.b.mass, self.gravity)
        torque = np.zeros_like(self.x)
        for spring in self.springs:
            line = self.x[spring.b] - self.x[spring.a]
            pull = (
                spring.stiffness
                * (np.linalg.norm(line) - spring.length)
                * line
                / np.linalg.norm(line)
            )
            force[spring.a] += pull
            force[spring.b] -= pull
        for pair in self.pairs:
            (i, j), (n, overlap, rate, _, arms) = pair, self.geometry(pair, v, w)
            if overlap <= 0:
                continue
            tangential = -self.law.tangential_stiffness * self.s[pair]
            total = -(self.law.stiffness * overlap + self.law.damping * rate) * n + tangential
            force[i] += total
            torque[i] += arms[0] * np.cross(n, tangential)
            if j >= 0:
                force[j] -= total
                torque[j] += arms[1] * np.cross(n, tangential)
        return force / self.b.mass[:, None], torque / self.b.inertia

    def slip(self, v, w, h):
        """Half a step of the springs of pairs that touch; returns the normals."""
        normals = {}
        for pair in self.pairs:
            n, overlap, _, slip, _ = self.geometry(pair, v, w)
            normals[pair] = n
            if overlap > 0 and self.law.friction > 0:
                self.s[pair] = self.s[pair] + h * slip
        return normals

    def carry(self, before, v, w):
        """The springs turn with their normals: Rodrigues' rotation about the axis across both."""
        for pair in self.pairs:
            now = self.geometry(pair, v, w)[0]
            axis = np.cross(before[pair], now)
            sine = np.linalg.norm(axis)
            cosine = before[pair] @ now
            if sine > 0:
                e = axis / sine
                s = self.s[pair]
                self.s[pair] = cosine * s + sine * np.cross(e, s) + (1 - cosine) * (e @ s) * e

    def step(self, h):
        """Kick, drift, kick; the second kick with a velocity predicted and corrected once."""
        v = self.v + h / 2 * self.a
        w = self.w + h / 2 * self.alpha
        before = self.slip(v, w, h / 2)
        self.x = self.x + h * v
        self.turn(w, h)
        self.carry(before, v, w)
        self.slip(v, w, h / 2)
        guess = v + h / 2 * self.a, w + h / 2 * self.alpha
        for _ in range(2):
            self.a, self.alpha = self.accelerations(*guess)
            guess = v + h / 2 * self.a, w + h / 2 * self.alpha
        self.v, self.w = guess

    def turn(self, w, h):
        """q = exp(w h/2) q."""
        for i, (rate, q) in enumerate(zip(w, self.q, strict=True)):
            angle = np.linalg.norm(rate) * h / 2
            if angle:
                u = rate / np.linalg.norm(rate) * np.sin(angle)
            else:
                u = np.zeros(3)
            c = np.cos(angle)
            self.q[i] = np.array(
                [c * q[0] - u @ q[1:], *(c * q[1:] + q[0] * u + np.cross(u, q[1:]))]
            )


def cluster(**law) -> Scene:
    """Three unequal spinning spheres that overlap one another and a tilted plane."""
    radii = (0.5, 0.7, 0.6)
    masses = (1.0, 2.0, 1.5)
    places = ((0.0, 0.0, 0.0), (1.1, 0.1, 0.2), (0.4, 0.95, -0.1))
    speeds = ((0.2, 0.1, -0.3), (-0.3, 0.05, 0.2), (0.1, -0.4, 0.1))
    spins = ((0.3, -0.2, 0.5), (-0.4, 0.6, 0.1), (0.2, 0.2, -0.7))
    columns = zip(masses, radii, places, speeds, spins, strict=True)
    bodies = [
        Body(
            mass=m,
            inertia=(0.4 * m * r * r,) * 3,
            position=x,
            velocity=v,
            omega=w,
            shape=Sphere(radius=r),
        )
        for m, r, x, v, w in columns
    ]
    elements = [
        Plane(point=(0.0, 0.0, -0.55), normal=(0.0, 0.6, 0.8)),
        UniformGravity(g=(0.0, 1.0, -9.0)),
    ]
    elements += [
        Spring(a=0, b=2, stiffness=30.0, length=1.0),
        Contact(law="linear", stiffness=500.0, **law),
    ]
    return Scene.of(bodies, elements)


LAWS = [
    {"damping": 3.0},
    {"damping": 3.0, "friction": 1e6, "tangential_stiffness": 300.0, "branch": "R-d/2"},
    {"friction": 1e6, "tangential_stiffness": 300.0, "branch": "R"},
    {"damping": 1.0, "friction": 1e6, "tangential_stiffness": 90.0, "branch": "R-d"},
    {"damping": 1.0, "friction": 1e6, "tangential_stiffness": 300.0, "branch": "slip-R"},
]


@pytest.mark.parametrize("law", LAWS, ids=["damped", "sticking", "arm R", "arm R-d", "two arms"])
def test_every_step_of_the_kernel_is_that_of_the_twin(law):
    scene = cluster(**law)
    twin = Twin(scene)
    assert sum(twin.geometry(pair, twin.v, twin.w)[1] > 0 for pair in twin.pairs) >= 4
    run, _ = ENGINE.run(
        Request(
            problem=Motion(scene, np.arange(STEPS + 1) * STEP), method="velocity-verlet", step=STEP
        )
    )
    assert not any(event.kind == "release" for event in run.events)
    for k in range(STEPS):
        if k:
            twin.step(STEP)
        for name, mine in (
            ("position", twin.x),
            ("velocity", twin.v),
            ("omega", twin.w),
            ("attitude", twin.q),
        ):
            assert np.abs(getattr(run, name)[k] - mine).max() < 2e-14 * max(
                1.0, np.abs(mine).max()
            ), (name, k)


def test_the_twin_sees_a_wrong_lever_arm():
    """The comparison can fail: the same twin with another branch is far off."""
    scene = cluster(**LAWS[2])
    other = Twin(cluster(**{**LAWS[2], "branch": "R-d/2"}))
    run, _ = ENGINE.run(
        Request(
            problem=Motion(scene, np.arange(STEPS + 1) * STEP), method="velocity-verlet", step=STEP
        )
    )
    for _ in range(STEPS):
        other.step(STEP)
    assert np.abs(run.omega[-1] - other.w).max() > 1e-6
