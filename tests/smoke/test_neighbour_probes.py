"""The probes of neighbour lists against soft spheres in numpy: right with all pairs, and wrong with
lists that miss some.
"""

import numpy as np
import pytest

from refdem.core.engine import Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.faults.transparent import Transparent
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.smoke.battery import BOUND, smoke
from refdem.smoke.diagnosis import distance
from refdem.smoke.neighbour_probes import PERIOD, neighbour_probes

PROBES = {probe.name: probe for probe in neighbour_probes()}
ACROSS = "across a periodic boundary"
SUBSTEPS = 32
SKIN = 0.25


def all_pairs(start, position, reach, touching):
    return touching


def never_renewed(start, position, reach, touching):
    """Pairs that were near at the start."""
    return touching & (np.linalg.norm(start[:, None] - start, axis=-1) < reach + SKIN)


def renewed_late(start, position, reach, touching):
    """The list of the start, until a sphere has moved by the whole skin, not by half of it."""
    if np.linalg.norm(position - start, axis=-1).max() > SKIN:
        return touching
    return never_renewed(start, position, reach, touching)


def renewed_by_the_last(start, position, reach, touching):
    """The list of the start, until the last sphere of all has moved by half of the skin."""
    if np.linalg.norm(position[-1] - start[-1]) > SKIN / 2:
        return touching
    return never_renewed(start, position, reach, touching)


def two_each(start, position, reach, touching):
    """The first two contacts of each sphere."""
    kept = touching & (np.cumsum(touching, axis=1) <= 2)
    return kept & kept.T


def within_a_word(start, position, reach, touching):
    """Pairs whose numbers differ by less than 64."""
    numbers = np.arange(len(start))
    return touching & (abs(numbers[:, None] - numbers) < 64)


def twice(start, position, reach, touching):
    """Every contact twice, as in lists of cells of which two are beside each other both ways."""
    return 2 * touching


def every_wall(overlaps):
    return overlaps


def first_wall(overlaps):
    """The first wall alone of those that a sphere touches."""
    touches = overlaps > 0
    return overlaps * (touches & (np.cumsum(touches, axis=0) == 1))


def deepest_wall(overlaps):
    """The wall alone that a sphere presses most."""
    return overlaps * (overlaps == overlaps.max(axis=0))


def simulated(probe, listed, image=np.round, felt=every_wall):
    """Position and velocity (T, N, 3) by velocity Verlet, with the contacts that `listed` keeps and
    the overlaps with walls (W, N) that are `felt`.

    `image` gives the number of periods (N, N, 3) by which a branch vector is shifted.
    """
    bodies = probe.scene.bodies
    boxes = probe.scene.all(PeriodicBox)
    walls = probe.scene.all(Plane)
    stiffness = probe.scene.all(Contact)[0].stiffness
    reach = bodies.radius[:, None] + bodies.radius
    start = bodies.position

    def acceleration(position):
        branch = position[:, None] - position
        for box in boxes:
            branch = branch - box.size * image(branch / box.size)
        apart = np.linalg.norm(branch, axis=-1)
        touching = (apart < reach) & (apart > 0)
        touching = listed(start, position, reach, touching)
        apart[apart == 0] = 1.0
        push = stiffness * (reach - apart) * touching / apart
        force = np.sum(push[..., None] * branch, axis=1)
        if walls:
            heights = [(position - np.array(wall.point)) @ np.array(wall.normal) for wall in walls]
            overlaps = felt(np.maximum(bodies.radius - np.array(heights), 0.0))
            force += stiffness * overlaps.T @ np.array([wall.normal for wall in walls])
        return force / bodies.mass[:, None]

    h = (probe.times[1] - probe.times[0]) / SUBSTEPS
    position, velocity = start, bodies.velocity
    rows = [(position, velocity)]
    pull = acceleration(position)
    for step in range(SUBSTEPS * (len(probe.times) - 1)):
        half = velocity + h / 2 * pull
        position = position + h * half
        pull = acceleration(position)
        velocity = half + h / 2 * pull
        if (step + 1) % SUBSTEPS == 0:
            rows.append((position, velocity))
    positions, velocities = zip(*rows, strict=True)
    return {"position": np.array(positions), "velocity": np.array(velocities)}


def largest_error(probe, listed, image=np.round, felt=every_wall):
    seen = simulated(probe, listed, image, felt)
    return max(
        distance(seen[name], probe.expected_values[name], name) for name in probe.expected_values
    )


@pytest.mark.parametrize("name", PROBES)
def test_spheres_of_which_every_pair_is_looked_at_move_as_the_formula_says(name):
    assert largest_error(PROBES[name], all_pairs) < BOUND / 10


@pytest.mark.parametrize(
    ("listed", "seen_by"),
    [
        (never_renewed, "meeting later"),
        (renewed_late, "meeting later"),
        (renewed_by_the_last, "meeting one at rest"),
        (two_each, "surrounded"),
        (within_a_word, "many"),
        (twice, "in a small periodic box"),
    ],
)
def test_a_list_that_misses_pairs_is_seen(listed, seen_by):
    assert largest_error(PROBES[seen_by], listed) > 2 * BOUND


def along_two_axes(branch):
    """Images along x and y alone."""
    return np.round(branch) * [1, 1, 0]


def across_faces(branch):
    """Images beyond faces and edges; a pair that meets across a corner has none."""
    nearest = np.round(branch)
    return nearest * (np.abs(nearest).sum(axis=-1, keepdims=True) < 3)


def truncated(branch):
    """Images of branches that are longer than the box alone."""
    return np.trunc(branch)


@pytest.mark.parametrize("image", [along_two_axes, across_faces, truncated])
def test_a_pair_that_is_lost_across_a_periodic_boundary_is_seen(image):
    assert largest_error(PROBES[ACROSS], all_pairs, image) > 2 * BOUND


@pytest.mark.parametrize("felt", [first_wall, deepest_wall])
def test_a_second_wall_that_is_not_felt_is_seen(felt):
    assert largest_error(PROBES["in a corner"], all_pairs, felt=felt) > 2 * BOUND


class Wrapping(Transparent):
    """Spheres whose places are told between -`period`/2 and `period`/2."""

    methods = (Method(name="verlet", summary="velocity Verlet", control="step", order=2),)

    def __init__(self, period):
        super().__init__()
        self.period = period

    def unsupported_motion(self, problem, method):
        if problem.scene.all(PeriodicBox):
            return None
        return "no box"

    def run(self, request):
        seen = simulated(PROBES[ACROSS], all_pairs)
        place = seen["position"]
        bodies = request.problem.scene.bodies
        still = np.zeros((len(place), *bodies.attitude.shape)) + bodies.attitude
        trajectory = Trajectory(
            t=request.problem.times,
            position=place - self.period * np.round(place / self.period),
            velocity=seen["velocity"],
            attitude=still,
            omega=0 * place,
        )
        return trajectory, Cost(seconds=0.0)


@pytest.mark.parametrize(("part_of_period", "outcome"), [(1.0, "pass"), (0.5, "fail")])
def test_the_first_sample_may_be_any_image_of_a_place(part_of_period, outcome):
    findings = {f.quantity: f.outcome for f in smoke(Wrapping(part_of_period * PERIOD))}
    assert findings[f"{ACROSS}: first sample"] == outcome
    assert findings[f"{ACROSS}: velocity"] == "pass"
