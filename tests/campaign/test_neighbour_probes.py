"""The probes of neighbour lists against soft spheres in numpy: right with all pairs, and wrong with
lists that miss some.
"""

import numpy as np
import pytest

from refdem.campaign.neighbour_probes import neighbour_probes
from refdem.campaign.smoke import BOUND
from refdem.campaign.suspicion import distance
from refdem.scene.elements.contact import Contact

PROBES = {probe.name: probe for probe in neighbour_probes()}
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


def two_each(start, position, reach, touching):
    """The first two contacts of each sphere."""
    kept = touching & (np.cumsum(touching, axis=1) <= 2)
    return kept & kept.T


def within_a_word(start, position, reach, touching):
    """Pairs whose numbers differ by less than 64."""
    numbers = np.arange(len(start))
    return touching & (abs(numbers[:, None] - numbers) < 64)


def simulated(probe, listed):
    """Position and velocity (T, N, 3) by velocity Verlet, with the contacts that `listed` keeps."""
    bodies = probe.scene.bodies
    stiffness = probe.scene.all(Contact)[0].stiffness
    reach = bodies.radius[:, None] + bodies.radius
    start = bodies.position

    def acceleration(position):
        branch = position[:, None] - position
        apart = np.linalg.norm(branch, axis=-1)
        touching = (apart < reach) & (apart > 0)
        touching = listed(start, position, reach, touching)
        apart[apart == 0] = 1.0
        push = stiffness * (reach - apart) * touching / apart
        return np.sum(push[..., None] * branch, axis=1) / bodies.mass[:, None]

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


def largest_error(probe, listed):
    seen = simulated(probe, listed)
    return max(distance(seen[name], probe.right[name], name) for name in seen)


@pytest.mark.parametrize("name", PROBES)
def test_spheres_of_which_every_pair_is_looked_at_move_as_the_formula_says(name):
    assert largest_error(PROBES[name], all_pairs) < BOUND / 10


@pytest.mark.parametrize(
    ("listed", "seen_by"),
    [
        (never_renewed, "meeting later"),
        (renewed_late, "meeting later"),
        (two_each, "surrounded"),
        (within_a_word, "many"),
    ],
)
def test_a_list_that_misses_pairs_is_seen(listed, seen_by):
    assert largest_error(PROBES[seen_by], listed) > 2 * BOUND
