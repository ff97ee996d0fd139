"""Many rigid spheres by cells and a queue of events: the same impacts as when every pair is looked
at, and what neither sampling nor a box may change.
"""

import numpy as np
import pytest

from refdem.core.balance import angular, kinetic, linear
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import impacts
from refdem.solvers.impacts import METHOD

U = 2.0**-53
SHIFT = 1e-12
GROWTH = 30.0
"""Times that an impact multiplies errors, at most: about 2 (1 + flight/radius), and flights of
these gases are some diameters long."""


def gas(
    seed: int,
    *,
    count: int = 64,
    spacing: float = 2.0,
    radii: tuple[float, float] = (0.4, 0.9),
    boundary: str = "walls",
    fixed: int = 0,
    gravity: float = 0.0,
    **law: float,
) -> Scene:
    """Spheres of many sizes and masses that start on a lattice `spacing` apart, with spins."""
    rng = np.random.default_rng(seed)
    along = int(np.ceil(count ** (1 / 3) - 1e-9))
    size = along * spacing
    bodies = []
    for k in range(count):
        cell = np.array([k % along, k // along % along, k // along**2])
        place = spacing * (cell + 0.5)
        radius = float(rng.uniform(*radii))
        mass = float(rng.uniform(0.5, 2.0))
        moment = 0.4 * mass * radius**2
        is_fixed = k < fixed
        velocity = (0.0 if is_fixed else 1.0) * rng.normal(size=3)
        if boundary == "open":
            velocity += size / 2 - place
        omega = (0.0 if is_fixed else 1.0) * rng.normal(size=3)
        body = Body(
            mass=mass,
            inertia=(moment, moment, moment),
            shape=Sphere(radius=radius),
            position=tuple(place.tolist()),
            velocity=tuple(velocity.tolist()),
            omega=tuple(omega.tolist()),
            fixed=is_fixed,
        )
        bodies.append(body)
    elements = [Contact(law="rigid", **law)]
    if boundary == "walls":
        for axis in range(3):
            for side in (0, 1):
                normal = [0.0, 0.0, 0.0]
                normal[axis] = 1.0 - 2.0 * side
                point = [0.0, 0.0, 0.0]
                point[axis] = side * size
                elements.append(Plane(point=tuple(point), normal=tuple(normal)))
    if boundary == "periodic":
        elements.append(PeriodicBox(size=size))
    if gravity:
        elements.append(UniformGravity(g=(0.25 * gravity, 0.0, -gravity)))
    return Scene.of(bodies, elements)


@pytest.fixture
def by_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    """However few there are, they look in cells."""
    monkeypatch.setattr(impacts, "FEW", 0)


def run(scene: Scene, end: float, samples: int = 2) -> Trajectory:
    """The motion up to `end`."""
    return run_by_table(scene, end, samples)[0]


def run_by_table(scene: Scene, end: float, samples: int = 2) -> tuple[Trajectory, np.ndarray]:
    """The motion, and the kernel's table of impacts: time, and the two that meet."""
    problem = Motion(scene, np.linspace(0.0, end, samples))
    assert METHOD.unsupported(problem) is None
    request = Request(problem=problem, method="impacts", step=None)
    call = METHOD.prepare(request)
    status = call.made("impacts")
    trajectory = METHOD.finish(request, call, status)
    return trajectory, call.outputs[1][:status]


SMOOTH = {"restitution": 1.0}
ROUGH = {"restitution": 0.8, "friction": 0.3}
GRIPPING = {"restitution": 0.9, "friction": 50.0, "tangential_restitution": 0.7}


@pytest.mark.parametrize(
    "given",
    [
        {"boundary": "walls", **SMOOTH},
        {"boundary": "walls", **ROUGH},
        {"boundary": "open", **GRIPPING},
        {"boundary": "walls", "spacing": 6.0, **SMOOTH},
        {"boundary": "walls", "radii": (0.05, 0.95), **ROUGH},
        {"boundary": "walls", "fixed": 9, **ROUGH},
        {"boundary": "open", "spacing": 3.0, "gravity": 4.0, **SMOOTH},
        {"boundary": "walls", "gravity": 4.0, **SMOOTH},
        {"boundary": "walls", "spacing": 4.0, "gravity": 4.0, **GRIPPING},
        {"boundary": "walls", "count": 200, "spacing": 1.9, **SMOOTH},
    ],
    ids=str,
)
def test_cells_see_the_impacts_that_a_look_at_every_pair_sees(given, monkeypatch) -> None:
    """Event by event, until chaos has made different motions of nearly the same start: how errors
    grow is seen from a start that is shifted by SHIFT. The two may differ by what a shift of a
    thousand roundings makes, and are compared while that of SHIFT leaves the order as it is.
    """
    scene = gas(3, **given)
    rng = np.random.default_rng(0)
    shift = SHIFT * rng.uniform(-1.0, 1.0, size=scene.bodies.position.shape)
    shift[scene.bodies.fixed] = 0.0
    shifted = scene.with_state(position=scene.bodies.position + shift)
    monkeypatch.setattr(impacts, "FEW", 0)
    cells = run_by_table(scene, 2.0)[1]
    monkeypatch.setattr(impacts, "FEW", 10**6)
    pairs = run_by_table(scene, 2.0)[1]
    others = run_by_table(shifted, 2.0)[1]
    grown = SHIFT
    compared = 0
    for seen, expected, other in zip(cells, pairs, others, strict=False):
        if set(other[1:]) != set(expected[1:]):
            break
        grown = max(grown, abs(other[0] - expected[0]))
        assert set(seen[1:]) == set(expected[1:])
        assert abs(seen[0] - expected[0]) < 1000 * U / SHIFT * grown
        compared += 1
    assert compared >= 2 * len(scene.bodies) or compared == len(pairs) == len(cells)


def test_an_image_is_met_as_a_sphere_in_its_place_is(by_cells) -> None:
    """Around a periodic box all bodies again, 27 times: those of the middle meet the same."""
    scene = gas(5, count=125, spacing=2.0, boundary="periodic", **SMOOTH)
    bodies = scene.bodies
    size = scene.all(PeriodicBox)[0].size
    copies = []
    for shift in np.ndindex(3, 3, 3):
        for k in range(125):
            place = bodies.position[k] + size * (np.array(shift) - 1.0)
            copies.append(
                Body(
                    mass=float(bodies.mass[k]),
                    inertia=tuple(bodies.inertia[k].tolist()),
                    shape=Sphere(radius=float(bodies.radius[k])),
                    position=tuple(place.tolist()),
                    velocity=tuple(bodies.velocity[k].tolist()),
                )
            )
    # In so short a time no news comes in from beyond the copies.
    end = 0.6
    inside = run(scene, end)
    outside = run(Scene.of(copies, [Contact(law="rigid", **SMOOTH)]), end)
    middle = slice(13 * 125, 14 * 125)
    assert len(inside.events) >= 10
    assert np.abs(inside.position[-1] - outside.position[-1, middle]).max() < 1e-10
    assert np.abs(inside.velocity[-1] - outside.velocity[-1, middle]).max() < 1e-10


@pytest.mark.parametrize("boundary", ["walls", "open", "periodic"])
@pytest.mark.parametrize("few", [0, 10**6])
def test_the_motion_does_not_depend_on_its_samples(boundary, few, monkeypatch) -> None:
    """To the bit: a sample is a copy, advanced to its time."""
    monkeypatch.setattr(impacts, "FEW", few)
    scene = gas(1, count=125, boundary=boundary, **ROUGH)
    seldom = run(scene, 4.0)
    often = run(scene, 4.0, 1001)
    assert len(seldom.events) > 125
    assert [event.time for event in seldom.events] == [event.time for event in often.events]
    for name in ("position", "velocity", "omega", "attitude"):
        assert np.array_equal(getattr(seldom, name)[-1], getattr(often, name)[-1])


def test_reversed_smooth_elastic_spheres_go_back_to_where_they_came_from(by_cells) -> None:
    scene = gas(2, count=125, spacing=3.0, **SMOOTH)
    there = run(scene, 2.0)
    turned = scene.with_state(position=there.position[-1], velocity=-there.velocity[-1])
    back = run(turned, 2.0)
    assert len(there.events) == len(back.events) > 60
    # Some spheres have met four times, there and back.
    assert np.abs(back.position[-1] - scene.bodies.position).max() < 64 * U * GROWTH**6
    assert np.abs(back.velocity[-1] + scene.bodies.velocity).max() < 64 * U * GROWTH**6


def test_a_sphere_whose_partner_was_hit_before_flies_on(by_cells) -> None:
    """The first event of sphere 0 is with sphere 1, which sphere 2 takes out of its way; it then
    meets sphere 3, which was behind.
    """
    places = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 3.0, 0.0), (8.0, 0.0, 0.0)]
    velocities = [(1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 0.0)]
    bodies = []
    for place, velocity in zip(places, velocities, strict=True):
        shape = Sphere(radius=0.5)
        moment = (0.1, 0.1, 0.1)
        bodies.append(
            Body(mass=1.0, inertia=moment, shape=shape, position=place, velocity=velocity)
        )
    # Spheres 2 and 1 exchange their velocities at 1 s: sphere 2 then lies in the way, at (4, 1, 0).
    _, table = run_by_table(Scene.of(bodies, [Contact(law="rigid", **SMOOTH)]), 12.0)
    assert table[0].tolist() == [1.0, 1.0, 2.0]
    # It grazes neither: 0 passes below 2 at a distance of exactly one diameter.
    assert table[1].tolist() == [7.0, 0.0, 3.0]


def test_spheres_that_fly_apart_do_not_cross_cells_without_end(by_cells) -> None:
    """In 1e7 s each passes as many times the cells of the start; larger ones take their place."""
    scene = gas(4, count=64, boundary="open", **SMOOTH)
    soon = run(scene, 100.0)
    late = run(scene, 1e7)
    assert len(soon.events) == len(late.events)
    flown = soon.position[-1] + (1e7 - 100.0) * soon.velocity[-1]
    assert np.abs(late.position[-1] - flown).max() < 1e7 * 64 * U


@pytest.mark.parametrize("law", [SMOOTH, ROUGH], ids=str)
def test_momentum_and_angular_momentum_of_a_crowd_that_falls_together(law, by_cells) -> None:
    """Each impact rounds the momenta of two, and impulses across their distance: the errors of so
    many impacts add up as a random walk, here ten times as wide.
    """
    scene = gas(8, count=1000, spacing=1.9, boundary="open", **law)
    trajectory = run(scene, 3.0, 5)
    events = len(trajectory.events)
    assert events > 1000
    momentum = linear(scene, trajectory)
    total = angular(scene, trajectory)["total"]
    speed = np.abs(trajectory.velocity).max()
    farthest = np.abs(trajectory.position).max()
    walk = 10 * U * np.sqrt(events) * 2.0 * speed
    # The sum over all bodies is rounded as well, once a body.
    summed = 1000 * U * 2.0 * speed
    assert np.abs(momentum - momentum[0]).max() < walk + summed
    assert np.abs(total - total[0]).max() < farthest * (walk + summed)


def test_energy_and_momentum_in_a_periodic_box_over_many_impacts(by_cells) -> None:
    scene = gas(9, count=216, spacing=1.9, boundary="periodic", **SMOOTH)
    trajectory = run(scene, 100.0, 9)
    events = len(trajectory.events)
    assert events > 10_000
    energy = kinetic(scene, trajectory)
    momentum = linear(scene, trajectory)
    walk = 10 * U * np.sqrt(events)
    assert np.abs(energy / energy[0] - 1).max() < walk
    assert np.abs(momentum - momentum[0]).max() < walk * 2 * np.abs(trajectory.velocity).max()


@pytest.mark.parametrize("few", [0, 10**6])
def test_a_ball_that_comes_to_rest_is_told_in_a_sentence(few, monkeypatch) -> None:
    """Its bounces end at 1.5 s, infinitely many."""
    monkeypatch.setattr(impacts, "FEW", few)
    ball = Body(
        mass=1.0, inertia=(0.1, 0.1, 0.1), shape=Sphere(radius=0.5), position=(0.0, 1.5, 0.0)
    )
    floor = Plane(normal=(0.0, 1.0, 0.0))
    law = Contact(law="rigid", restitution=0.5)
    scene = Scene.of([ball], [law, floor, UniformGravity(g=(0.0, -8.0, 0.0))])
    with pytest.raises(EngineError, match=r"between t = 1 s and 2 s .*inelastic collapse"):
        run(scene, 3.0, 4)


@pytest.mark.parametrize("few", [0, 10**6])
def test_three_spheres_in_a_line_stay_together_below_the_known_restitution(
    few, monkeypatch
) -> None:
    """Below e = 7 - 4 sqrt(3) = 0.0718 the middle one is hit for ever in finite time (Bernu and
    Mazighi 1990): speeds go down to the rounding of the common one, at which nobody closes in, and
    the three go on as one. Above they part.
    """
    monkeypatch.setattr(impacts, "FEW", few)
    widths = {}
    for restitution in (0.05, 0.08):
        bodies = []
        for x, v in ((-2.0, 3.0), (0.0, 0.0), (1.0, 0.0)):
            bodies.append(
                Body(
                    mass=1.0,
                    inertia=(0.1, 0.1, 0.1),
                    shape=Sphere(radius=0.5),
                    position=(x, 0.0, 0.0),
                    velocity=(v, 0.0, 0.0),
                )
            )
        found = run(Scene.of(bodies, [Contact(law="rigid", restitution=restitution)]), 40.0)
        assert 3 < len(found.events) < 100
        assert np.abs(found.velocity[-1].sum(axis=0) - [3.0, 0.0, 0.0]).max() < 100 * U
        widths[restitution] = found.position[-1, 2, 0] - found.position[-1, 0, 0] - 2.0
    # 40 s at a rounding of the speed, and the part that is left of it after ten impacts.
    assert abs(widths[0.05]) < 40.0 * 100 * U
    assert widths[0.08] > 1e-5


def test_refusals_name_the_pair_and_the_size_of_the_box() -> None:
    scene = gas(1, count=125, boundary="periodic", **SMOOTH)
    times = np.array([0.0, 1.0])
    moved = scene.bodies.position.copy()
    # Across the side of the box: sphere 4 is the last of its row, 0 the first.
    moved[4, 0] += 1.0
    overlapping = scene.with_state(position=moved)
    assert METHOD.unsupported(Motion(overlapping, times)) == "body 0 overlaps body 4 at the start"
    small = gas(1, count=8, spacing=2.0, boundary="periodic", **SMOOTH)
    assert "5 diameters" in str(METHOD.unsupported(Motion(small, times)))
