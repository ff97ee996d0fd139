"""The kernel of a gas against a plain numpy twin that looks at every pair and every image, step by
step, and with planted faults.
"""

import math

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import EngineError
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

IMAGES = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], float)


class Twin:
    """O(N^2) velocity Verlet in wrapped coordinates;

    `fault` is one of the wrong ways that a gas code has.
    """

    def __init__(self, scene, fault=""):
        b = scene.bodies
        self.law = scene.all(Contact)[0]
        self.fault = fault
        self.x, self.v, self.m, self.d = (
            np.array(b.position),
            np.array(b.velocity),
            b.mass[0],
            2 * b.radius[0],
        )
        if scene.all(PeriodicBox):
            self.size = scene.all(PeriodicBox)[0].size
        else:
            self.size = 0.0
        self.planes = [(np.array(p.point), np.array(p.normal)) for p in scene.all(Plane)]
        self.boxes = np.zeros_like(self.x)
        self.listed = None
        self.a = self.accelerations(self.v)

    def accelerations(self, v):
        """(N, 3) of every pair with each of 27 images, and of the planes."""
        n = len(self.x)
        law = self.law
        if self.size:
            shifts = IMAGES * self.size
        else:
            shifts = np.zeros((1, 3))
        damping = law.damping * (2 if self.fault == "restitution" else 1)
        if self.fault == "one box off":
            shifts = shifts + np.array([self.size, 0.0, 0.0]) * (shifts[:, :1] > 0)
        line = self.x[None, :, None] + shifts - self.x[:, None, None]
        distance = np.linalg.norm(line, axis=-1)
        touching = (distance < self.d) & ~np.eye(n, dtype=bool)[:, :, None]
        if self.fault == "stale":
            if self.listed is None:
                self.listed = distance < 1.2 * self.d
            else:
                self.listed = self.listed
            touching &= self.listed
        if self.fault == "one-sided":
            touching &= np.triu(np.ones((n, n), bool))[:, :, None]
        force = np.zeros_like(self.x)
        for i, j, k in zip(*np.nonzero(touching), strict=True):
            normal = line[i, j, k] / distance[i, j, k]
            force[i] -= (
                law.stiffness * (self.d - distance[i, j, k]) + damping * ((v[i] - v[j]) @ normal)
            ) * normal
        for point, normal in self.planes:
            overlap = self.d / 2 - (self.x - point) @ normal
            push = np.where(overlap > 0, law.stiffness * overlap - damping * (v @ normal), 0.0)
            force += push[:, None] * normal
        return force / self.m

    def step(self, h):
        """Kick, drift, wrap, kick; the dashpot sees the velocity that the last acceleration
        predicts.
        """
        half = self.v + h / 2 * self.a
        self.x = self.x + h * half
        if self.size:
            boxes = np.floor(self.x / self.size)
            self.x = self.x - boxes * self.size
            self.boxes = self.boxes + boxes
            if self.fault == "wrap":
                half = half - boxes * 0.01
        self.a = self.accelerations(half + h / 2 * self.a)
        self.v = half + h / 2 * self.a

    @property
    def unwrapped(self):
        """Positions as a trajectory has them."""
        return self.x + self.boxes * self.size


def gas(samples, stride, **given):
    """An instance of the case, and the run of the kernel with steps of a fifth of tau."""
    instance = discovery.case("granular-gas").at(**given)
    step = 2.0 ** np.floor(np.log2(instance.scales.tau / 4))
    times = np.arange(samples + 1) * (stride * step)
    return (
        instance.scene,
        step,
        ENGINE.run(Request(problem=Motion(instance.scene, times), method="gas", step=step))[0],
    )


def apart(scene, step, run, stride, fault=""):
    """Largest difference of position and velocity between kernel and twin at the samples."""
    twin = Twin(scene, fault)
    worst = 0.0
    for k in range(len(run.t)):
        for _ in range(stride if k else 0):
            twin.step(step)
        worst = max(
            worst,
            np.abs(run.position[k] - twin.unwrapped).max(),
            np.abs(run.velocity[k] - twin.v).max(),
        )
    return worst


DENSE = {"n": "12", "density": "1/4", "restitution": "1/2"}


@pytest.mark.parametrize("boundary", ["periodic", "walls"])
def test_the_kernel_moves_as_the_twin_does(boundary):
    scene, step, run = gas(20, 50, boundary=boundary, **DENSE)
    assert len(run.events) > 5
    assert apart(scene, step, run, 50) < 1e-9


@pytest.mark.parametrize("fault", ["restitution", "one box off", "stale", "one-sided", "wrap"])
def test_the_twin_with_a_fault_moves_otherwise(fault):
    scene, step, run = gas(20, 50, **DENSE)
    assert apart(scene, step, run, 50, fault) > 1e-4


@pytest.mark.parametrize("n", ["2", "100", "3000"])
def test_momentum_is_kept_exactly_over_contacts_and_wraps(n):
    _, _, run = gas(2, 1000, n=n)
    assert [math.fsum(run.velocity[-1, :, k]) for k in range(3)] == [0.0, 0.0, 0.0]
    assert np.any(run.velocity[-1] != run.velocity[0]) or n == "2"


def test_velocities_change_in_contacts_alone():
    """A body that crosses the box keeps its velocity to the last bit, and its position goes on."""
    scene, _, run = gas(200, 20, n="20", density="1/50", restitution="1")
    met = {event.body for event in run.events}
    moved = np.any(run.velocity[-1] != run.velocity[0], axis=1)
    free = np.flatnonzero(~moved)
    assert len(free) > 0
    assert len(met) > 0
    flown = run.position[-1, free] - run.position[0, free] - run.t[-1] * run.velocity[0, free]
    assert np.abs(flown).max() < 1e-10
    size = scene.all(PeriodicBox)[0].size
    assert run.position.max() > size or run.position.min() < 0


def test_output_does_not_change_the_motion_of_many():
    instance = discovery.case("granular-gas").at(n="2000", density="1/10")
    step = 2.0 ** np.floor(np.log2(instance.scales.tau / 4))
    runs = [
        ENGINE.run(
            Request(
                problem=Motion(instance.scene, np.arange(0, 601, every) * step),
                method="gas",
                step=step,
            )
        )[0]
        for every in (600, 25)
    ]
    assert np.array_equal(runs[0].position[-1], runs[1].position[-1])
    assert runs[0].events == runs[1].events


def test_a_motion_that_diverges_is_an_error_that_says_so() -> None:
    """Positions beyond what 32 bits count in boxes overflowed, which C leaves undefined."""
    problem = discovery.case("granular-gas").at().problem
    request = Request(problem=problem, method="gas", step=abs(problem.interval))
    with pytest.raises(EngineError, match="the motion diverged"):
        ENGINE.run(request)
