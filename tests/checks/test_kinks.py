"""What a step that straddles a kink may leave of error in each quantity."""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks._kinks import least_shares
from refdem.core import discovery
from refdem.faults.fault import Fault
from refdem.planning.in_process import record_of, task_of, truth_of


@pytest.mark.parametrize(
    ("own", "share"),
    [
        # Parts 2e-3, 3e-3 and 4e-3 of the largest change: the same within a factor of 2.
        ((0.8e-2, 0.6e-2, 0.4e-2), 0.01),
        # 1e-3, 3e-3 and 4e-3: terms cancel at the first halving.
        ((0.4e-2, 0.6e-2, 0.4e-2), 0.1),
        # Terms that cancel altogether have no part.
        ((0.8e-2, 0.0, 0.4e-2), 0.1),
        # Two halvings may agree by chance.
        ((0.8e-2, 0.6e-2), 0.1),
    ],
)
def test_a_part_that_is_the_same_at_three_halvings_is_that_of_the_quantity(own, share):
    largest = (4.0, 2.0, 1.0)[: len(own)]
    changes = {
        "x": [np.array([0.0, change]) for change in largest],
        "z": [np.array([0.0, change]) for change in own],
    }
    shares = least_shares(changes)
    # Nothing has changed at the start.
    assert shares["z"] == pytest.approx([0.1, share])
    assert shares["x"][1] == pytest.approx(0.01 if len(own) == 3 else 0.1)


def lifted(part):
    """The velocities along z go wrong in the course of time, at the end by `part` of the fastest
    that is seen at the start.
    """

    def after(request, run):
        velocity = run.velocity.copy()
        velocity[:, :, 2] += part * np.max(np.abs(velocity[0])) * (run.t / run.t[-1])[:, None]
        return replace(run, velocity=velocity)

    return Fault(name="lifted", kind="", sentence="", on=(), sees=("error", "v2.z"), after=after)


@pytest.mark.parametrize(("part", "outcome"), [(0.0, "pass"), (3e-4, "fail")])
def test_a_small_component_of_a_pair_that_slides_is_held_to_its_own_changes(part, outcome):
    """A tenth of the largest change of any quantity would allow 7e-4 of the scale."""
    carrier = lifted(part).carrier(discovery.engine("mujoco"))
    spins = "1,3,1,2,-1,3"
    instance = discovery.case("two-spheres").at(
        masses="1,3", radii="0.5,0.75", friction="0.125", angle="1/3", spins=spins
    )
    record = record_of(task_of(carrier, "euler", instance, truth_of(instance), 4, ("error",)))
    outcomes = {finding.quantity: finding.outcome for finding in record.findings}
    assert outcomes["v2.z"] == outcome
    assert outcomes["v1.x"] == "pass"
