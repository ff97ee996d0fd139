"""Many spheres with friction: against the method for two, the laws of momentum, and themselves with
other numbers of threads.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.mechanics import momentum
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

COLUMNS = ("position", "velocity", "omega", "attitude")
STEP = 2.0**-10


def sphere(position, velocity, omega=(0.0, 0.0, 0.0)):
    return Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        shape=Sphere(radius=0.5),
        position=position,
        velocity=velocity,
        omega=omega,
    )


def law(**given):
    return Contact(
        law="linear",
        **{"stiffness": 1000.0, "tangential_stiffness": 300.0, "friction": 0.3} | given,
    )


def two(overlap, *, sideways, spin=0.2):
    """Spheres on x that meet, slide and spin."""
    u = (0.3, *sideways)
    return [
        sphere((5.0, 5.0, 5.0), u, (0.1, spin, 0.3)),
        sphere((6.0 - overlap, 5.0, 5.0), tuple(-x for x in u), (0.05, -0.1, 0.2)),
    ]


def moved(bodies, elements, times, method="gas", step=STEP):
    return ENGINE.run(
        Request(
            problem=Motion(Scene.of(bodies, elements), np.asarray(times)), method=method, step=step
        )
    )[0]


def apart(one, other, names=COLUMNS, bodies=slice(None)):
    return max(
        np.abs(getattr(one, name)[:, bodies] - getattr(other, name)[:, bodies]).max()
        for name in names
    )


@pytest.mark.parametrize("branch", ["R", "R-d", "R-d/2"])
def test_a_contact_that_sticks_moves_as_the_method_for_two_has_it(branch):
    bodies = two(0.01, sideways=(0.05, 0.02))
    contact = law(friction=5.0, branch=branch)
    times = np.arange(21) * 2 * STEP
    many = moved(bodies, [contact, PeriodicBox(size=50.0)], times)
    few = moved(bodies, [contact], times, "velocity-verlet")
    assert np.ptp(few.velocity[:, 0, 1]) > 0.01
    assert apart(many, few) < 1e-12


def test_a_contact_that_slides_moves_as_the_method_for_two_has_it():
    bodies = two(0.0, sideways=(0.5, 0.0), spin=0.0)
    contact = law(friction=0.2)
    times = np.arange(21) * 2 * STEP
    bodies = [sphere(b.position, b.velocity, (0.0, 0.0, b.omega[2])) for b in bodies]
    many = moved(bodies, [contact, PeriodicBox(size=50.0)], times)
    few = moved(bodies, [contact], times, "velocity-verlet")
    assert np.ptp(few.omega[:, 0, 2]) > 0.1
    assert apart(many, few) < 1e-12


@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_a_whole_collision_errs_by_less_than_the_force_of_half_a_step(damping):
    """A contact begins within a step: what the dashpot then gives at once, c v h/2, is what may be
    missed.
    """
    bodies = two(-0.003, sideways=(0.12, 0.07))
    contact = law(damping=damping)
    exact = moved(bodies, [contact], [0.0, 0.25], "contact-events", 2.0**-8)
    for step in (2.0**-9, 2.0**-11, 2.0**-13):
        many = moved(bodies, [contact, PeriodicBox(size=50.0)], [0.0, 0.25], step=step)
        assert apart(many, exact, ("velocity",)) < step * (damping * 0.6 / 2 + 0.05)


def bystander(fast):
    return sphere((15.0, 15.0, 15.0), (fast, fast, -fast))


@pytest.mark.parametrize("carried", [0.0, 40.0])
def test_a_tangential_spring_outlasts_lists_that_are_rebuilt(carried):
    """A third sphere is so fast that the list is rebuilt every few steps; carried along, the pair
    passes cells and the edge of the box.
    """
    contact = law(friction=5.0)
    times = np.arange(21) * 2 * STEP
    wind = np.array([carried, -carried, carried])
    pair = two(0.01, sideways=(0.05, 0.02))
    blown = [sphere(b.position, tuple(np.array(b.velocity) + wind), b.omega) for b in pair]
    hurried = moved([*blown, bystander(90.0)], [contact, PeriodicBox(size=20.0)], times)
    calm = moved(pair, [contact, PeriodicBox(size=20.0)], times)
    assert np.abs(hurried.velocity[:, :2] - wind - calm.velocity[:, :2]).max() < 2e-11
    assert apart(hurried, calm, ("omega", "attitude"), slice(0, 2)) < 1e-11


def cloud(n=120, seed=3):
    """Spheres on a lattice that is shaken: dense, fast and spinning."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(n ** (1 / 3)))
    places = (
        np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[:n]
        * 1.02
        + 0.6
    )
    places += rng.uniform(-0.05, 0.05, places.shape)
    return [
        sphere(tuple(x), tuple(v), tuple(w))
        for x, v, w in zip(places, rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), strict=True)
    ]


SIDE = 5 * 1.02 + 0.3
BOUNDS = {
    "open": [],
    "periodic": [PeriodicBox(size=SIDE)],
    "walls": [
        Plane(point=(s, s, s), normal=tuple(float(sign * (k == axis)) for k in range(3)))
        for axis in range(3)
        for s, sign in ((0.0, 1), (SIDE, -1))
    ],
}


@pytest.mark.parametrize("bounds", list(BOUNDS))
def test_the_bits_are_the_same_for_any_number_of_threads(bounds, monkeypatch):
    runs = []
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("REFDEM_THREADS", threads)
        runs.append(moved(cloud(), [law(damping=1.0), *BOUNDS[bounds]], np.arange(4) * 300 * STEP))
    assert runs[0].channels["contacts"].max() > 50
    assert len(runs[0].events) > 100
    for other in runs[1:]:
        assert all(np.array_equal(getattr(runs[0], name), getattr(other, name)) for name in COLUMNS)
        assert all(
            np.array_equal(runs[0].channels[name], other.channels[name])
            for name in runs[0].channels
        )
        assert runs[0].events == other.events


def test_momentum_and_angular_momentum_of_a_cloud_are_kept():
    bodies = cloud()
    run = moved(bodies, [law(damping=1.0)], np.arange(5) * 200 * STEP)
    mass = np.ones(len(bodies))
    inertia = np.full((len(bodies), 3), 0.1)
    total = momentum.orbital(mass, run.position, run.velocity) + momentum.spin(
        inertia, run.attitude, run.omega
    )
    assert np.abs(np.ptp(run.omega, axis=0)).max() > 1
    assert np.abs(run.velocity.sum(axis=1) - run.velocity[0].sum(axis=0)).max() < 1e-13 * len(
        bodies
    )
    assert np.abs(total - total[0]).max() < 1e-12 * len(bodies)
    assert np.abs(np.linalg.norm(run.attitude, axis=2) - 1).max() < 1e-14


def test_what_energy_a_cloud_loses_is_told_as_work():
    """Less what springs of contacts that last still hold: 0.5 k_t bend^2, at most (friction
    force)^2/(2 k_t).
    """
    bodies = cloud()
    contact = law(damping=1.0)
    scene = Scene.of(bodies, [contact])
    run = moved(bodies, [contact], np.arange(9) * 400 * STEP, step=STEP / 4)
    kinetic = 0.5 * np.sum(run.velocity**2, axis=(1, 2)) + 0.05 * np.sum(run.omega**2, axis=(1, 2))
    energy = kinetic + scene.potential(run.position, run.attitude)
    work = run.channels["dissipated_work"]
    still = run.channels["contacts"][-1] == 0
    assert still
    assert work[-1] > 0.2 * energy[0]
    assert abs(energy[-1] + work[-1] - energy[0]) < 1e-3 * energy[0]


@pytest.mark.parametrize("said", ["0", "two", "65", "-1"])
def test_a_number_of_threads_that_is_none_is_refused(said, monkeypatch):
    monkeypatch.setenv("REFDEM_THREADS", said)
    with pytest.raises(UsageError, match="REFDEM_THREADS"):
        moved(cloud(), [law()], [0.0, STEP])
