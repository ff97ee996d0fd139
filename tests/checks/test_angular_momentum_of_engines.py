"""Angular momentum that an engine keeps exactly is held to round-off, and where it does not is the
scene's to say.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.faults.fault import Fault
from refdem.planning.in_process import record_of, task_of, truth_of

OBLIQUE = {"masses": "1,3", "angle": "1/2", "damping": "0", "samples": "16"}


def off_centre(part):
    """A pair of opposite kicks in x off the line of centres: momentum is kept, L is not."""

    def after(request, run):
        mass = request.problem.scene.bodies.mass
        kick = np.zeros_like(run.velocity)
        moved = run.t > run.t[-1] / 2
        kick[moved, 0, 0] = part / mass[0]
        kick[moved, 1, 0] = -part / mass[1]
        return replace(run, velocity=run.velocity + kick)

    return Fault(
        name="off-centre",
        kind="",
        sentence="",
        on=(),
        sees=("angular-momentum", "total"),
        after=after,
    )


def found(engine, method, case, given):
    instance = discovery.case(case).at(**given)
    task = task_of(engine, method, instance, truth_of(instance), 3, ("angular-momentum",))
    return record_of(task).findings


@pytest.mark.parametrize("method", ["euler", "implicitfast"])
@pytest.mark.parametrize("friction", ["0", "1/4"])
def test_a_contact_whose_forces_do_not_meet_is_seen_far_below_the_truncation_error(
    method, friction
):
    """The error of first order that the method has elsewhere would hide a hundredth of L."""
    mujoco = discovery.engine("mujoco")
    given = {**OBLIQUE, "friction": friction}
    (sound,) = found(mujoco, method, "two-spheres", given)
    assert sound.outcome == "pass"
    (wrong,) = found(off_centre(1e-9).carrier(mujoco), method, "two-spheres", given)
    assert wrong.outcome == "fail"


def test_a_body_with_unequal_moments_is_held_to_the_order():
    mujoco = discovery.engine("mujoco")
    findings = found(mujoco, "euler", "free-rigid-body", {"duration": "2", "samples": "8"})
    assert {finding.outcome for finding in findings} == {"pass"}
    (total,) = (finding for finding in findings if finding.quantity == "total")
    assert "truncation error" in total.basis
