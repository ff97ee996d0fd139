"""Overlap and contact force that a run writes are those of its state; the reference's pass, spoiled
ones do not.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.contact_channels import CHECK
from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Request
from refdem.core.trajectory import Cost

REFERENCE = discovery.engine("reference")


def outcomes(case, spoiled=lambda channels: channels, named=None, **given):
    """Outcome by quantity of the reference's cheapest method, or of the one named."""
    instance = discovery.case(case).at(**given)
    method = next(
        m
        for m in REFERENCE.methods
        if REFERENCE.unsupported(instance.problem, m) is None and named in (None, m.name)
    )
    if method.control == "exact":
        levels = (0.0,)
    else:
        levels = (float(instance.times[1]) / 64,)
    if method.control == "exact":
        step = None
    else:
        step = levels[0]
    run, _ = REFERENCE.run(Request(problem=instance.problem, method=method.name, step=step))
    subject = Subject(instance, method, levels, None)
    assert CHECK.applies(subject) is None
    found = CHECK.judge(
        subject,
        {
            subject.finest: CompletedRun(
                replace(run, channels=spoiled(dict(run.channels))), Cost(seconds=0.0)
            )
        },
    )
    return {finding.quantity: finding.outcome for finding in found}


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("two-spheres", {}),
        ("two-spheres", {"damping": "1"}),
        ("two-spheres", {"cutoff": "zero_force", "damping": "4", "masses": "1,3"}),
        (
            "two-spheres",
            {"damping": "1", "angle": "1/2", "friction": "1/16", "spins": "0,0,1,0,0,2"},
        ),
        ("hertz-spheres", {}),
    ],
)
def test_what_the_reference_writes_belongs_to_its_state(case, given):
    found = outcomes(case, **given)
    assert set(found) <= {"overlap", "contact_force"}
    assert found
    assert set(found.values()) == {"pass"}


@pytest.mark.parametrize(
    ("channel", "spoil"),
    [
        ("overlap", lambda d: 2 * d),
        ("overlap", lambda d: 1000 * d),
        ("contact_force", lambda f: -f),
        ("contact_force", lambda f: np.concatenate([f[:1], f[:-1]])),
        ("contact_force", lambda f: 0 * f),
        ("contact_force", lambda f: f * (1 + 1e-9)),
    ],
)
def test_channels_of_another_state_are_seen(channel, spoil):
    found = outcomes(
        "two-spheres",
        lambda channels: {**channels, channel: spoil(channels[channel])},
        damping="1",
    )
    assert found[channel] == "fail"


def test_a_run_without_them_is_not_judged():
    assert outcomes("two-spheres", lambda channels: {}, damping="1") == {}


DAMPED = {"damping": "4", "masses": "1,3"}
EFFECTIVE_MASS = 0.75


def of_velocities(steps):
    """Where the dashpot of the reference's leapfrog takes its velocities so many steps before the
    row.
    """
    instance = discovery.case("two-spheres").at(**DAMPED)
    part = 1.0 - 4.0 * steps * float(instance.times[1]) / 64 / EFFECTIVE_MASS
    return lambda channels: {**channels, "contact_force": channels["contact_force"] / part}


@pytest.mark.parametrize(
    ("steps", "outcome"), [(0.0, "pass"), (0.5, "pass"), (1.0, "fail"), (-0.5, "fail")]
)
def test_a_dashpot_may_have_the_velocities_of_half_a_step_before_as_a_leapfrog_has(steps, outcome):
    assert (
        outcomes("two-spheres", of_velocities(steps), "velocity-verlet", **DAMPED)["contact_force"]
        == outcome
    )


def test_a_force_that_a_truncation_error_would_hide_is_seen():
    """In steps too it is a number of its row: a stiffness that is a billionth too large where it is
    written.
    """
    found = outcomes(
        "hertz-spheres",
        lambda channels: {**channels, "contact_force": channels["contact_force"] * (1 + 1e-9)},
        "velocity-verlet",
    )
    assert found["contact_force"] == "fail"
