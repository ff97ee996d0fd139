"""Impacts a second of rigid spheres in a box, by the event-driven method of the reference."""

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from refdem.bench.tables import Table, duration, two
from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

PARTS = (0.01, 0.3, 0.4)
"""Filled fractions of the box: a gas, and two fluids."""
IMPACTS = 50_000
"""Approximate number of impacts of a round; the method counts them instead of listing them."""
LEAST_GAP = 1.02
"""Smallest distance of the lattice points at which spheres start, in diameters."""


@dataclass(frozen=True)
class Rate:
    """Seconds an impact in each round, of so many spheres that fill this part of their box."""

    n: int
    part: float
    rounds: Sequence[float]


def box_of_spheres(n: int, part: float) -> Scene:
    """Smooth elastic spheres of unit mass and diameter on a lattice between six planes, with
    normally distributed velocities of variance 1 (always the same).
    """
    # The least cube of cells that has one for each sphere.
    cells_a_side = int(np.ceil(np.cbrt(n) - 1e-9))
    # Volume of the box: n spheres of volume pi/6 fill the fraction `part`.
    volume = n * np.pi / 6 / part
    box_side = max(float(np.cbrt(volume)), LEAST_GAP * cells_a_side)
    cells = np.indices((cells_a_side, cells_a_side, cells_a_side)).reshape(3, -1).T[:n]
    places = (cells + 0.5) * (box_side / cells_a_side)
    velocities = np.random.default_rng(0).normal(size=(n, 3))
    bodies = []
    for place, velocity in zip(places.tolist(), velocities.tolist(), strict=True):
        shape = Sphere(radius=0.5)
        moments = (0.1, 0.1, 0.1)
        body = Body(
            mass=1.0,
            inertia=moments,
            shape=shape,
            position=tuple(place),
            velocity=tuple(velocity),
        )
        bodies.append(body)
    walls = []
    for axis in np.eye(3):
        walls.append(Plane(point=(0.0, 0.0, 0.0), normal=tuple(axis.tolist())))
        walls.append(Plane(point=tuple((box_side * axis).tolist()), normal=tuple((-axis).tolist())))
    return Scene.of(bodies, [Contact(law="rigid", restitution=1.0), *walls])


SPACING = 1.1
"""Diameters between the places of a cage: no sphere fits through the gap between four of it."""
HEAVY = 1e9
"""Mass of a sphere of a cage, in units of those inside: ten million impacts move it by a hundredth
of a diameter."""


def caged_spheres(along: int, friction: float) -> Scene:
    """Rough elastic spheres of unit diameter on a cubic lattice, alone in space. The heavy ones on
    the surface of the lattice form a cage, in which the others move and spin.

    There are no external forces and no sphere escapes, so that impacts continue without end while
    momentum and angular momentum are conserved. Planes or a periodic box would change the angular
    momentum.
    """
    cells = np.indices((along, along, along)).reshape(3, -1).T
    is_cage = np.any((cells == 0) | (cells == along - 1), axis=1)
    places = (cells - (along - 1) / 2) * SPACING
    draws = np.random.default_rng(0).normal(size=(2, len(cells), 3))
    draws[:, is_cage] = 0.0
    bodies = []
    for place, velocity, omega, caging in zip(places, draws[0], draws[1], is_cage, strict=True):
        mass = 1.0
        if caging:
            mass = HEAVY
        body = Body(
            mass=mass,
            inertia=(0.1 * mass, 0.1 * mass, 0.1 * mass),
            shape=Sphere(radius=0.5),
            position=tuple(place.tolist()),
            velocity=tuple(velocity.tolist()),
            omega=tuple((2.0 * omega).tolist()),
        )
        bodies.append(body)
    law = Contact(law="rigid", restitution=1.0, friction=friction, tangential_restitution=1.0)
    return Scene.of(bodies, [law])


def rates(
    sizes: Sequence[int], rounds: int = 5, progress: Callable[[str], None] = lambda line: None
) -> list[Rate]:
    """The rate of every box of so many spheres, one thread."""
    measured = []
    for n in sizes:
        for part in PARTS:
            progress(f"{n} hard spheres, {part:g} of the box")
            scene = box_of_spheres(n, part)
            # The impact rate of a short run gives the duration of one with IMPACTS impacts.
            short = 1e-2 / part / np.cbrt(n)
            impacts, _ = _seconds(scene, short)
            while impacts < IMPACTS / 100:
                short *= 2.0
                impacts, _ = _seconds(scene, short)
            end = short * IMPACTS / impacts
            timed = [_seconds(scene, end) for _ in range(rounds)]
            measured.append(Rate(n, part, [seconds / count for count, seconds in timed]))
    return measured


def _seconds(scene: Scene, end: float) -> tuple[int, float]:
    """The number of impacts up to `end` [s], and the time [s] that the kernel takes."""
    motion = Motion(scene, np.array([0.0, end]))
    request = Request(problem=motion, method="impacts", step=None)
    trajectory, cost = discovery.engine("reference").run(request)
    return len(trajectory.events), cost.seconds


def table(measured: Sequence[Rate]) -> Table:
    """The rates as a table: a line for each box."""
    header = ("box", "impacts a second", "an impact", "least to most")
    rows = []
    for rate in measured:
        median = statistics.median(rate.rounds)
        extremes = f"{duration(min(rate.rounds))} to {duration(max(rate.rounds))}"
        box = f"{rate.n} spheres, {rate.part:g} of the box"
        rows.append((box, two(1 / median), duration(median), extremes))
    return Table("Impacts of rigid spheres", header, rows)
