"""The motions that probes are compared with are as right as they say."""

import pytest

from refdem.scene.elements.spring import Spring
from refdem.smoke.diagnosis import distance
from refdem.smoke.force_probes import force_probes
from refdem.smoke.probe_motion import LONGEST_STEP, SHORT_STEP, UNCERTAINTY, motion
from refdem.smoke.probes import Probe, probes
from refdem.smoke.turning_probes import turning_probes

PROBES = [
    probe
    for probe in (*probes(), *force_probes(), *turning_probes())
    if probe.scene.all(Spring) or "tumbling" in probe.scene.features
]


CLOSE = "spring off the centre in a plane"
"""The probe whose spring has ends that pass close to each other."""


@pytest.mark.parametrize("probe", PROBES, ids=lambda probe: probe.name)
def test_steps_sixteen_times_shorter_change_a_motion_by_less_than_its_uncertainty(
    probe: Probe,
) -> None:
    step = SHORT_STEP if probe.name == CLOSE else LONGEST_STEP
    assert change(probe, step) < UNCERTAINTY


def test_steps_as_long_as_others_would_not_do_for_ends_that_pass_close() -> None:
    (close,) = [probe for probe in PROBES if probe.name == CLOSE]
    assert change(close, LONGEST_STEP) > UNCERTAINTY


def test_the_motions_of_probes_are_those_of_these_steps() -> None:
    (close,) = [probe for probe in PROBES if probe.name == CLOSE]
    t = close.times - close.times[0]
    right = motion(close.scene, t, longest_step=SHORT_STEP / 4)
    assert (
        max(distance(close.expected_values[name], right[name], name) for name in right)
        < UNCERTAINTY
    )
    assert close.uncertainty == UNCERTAINTY


def change(probe: Probe, step: float) -> float:
    """The largest change of a motion, in units of its scales, from steps [s] to very short ones."""
    t = probe.times - probe.times[0]
    seen = motion(probe.scene, t, longest_step=step)
    exact = motion(probe.scene, t, longest_step=step / 16)
    return max(distance(seen[name], exact[name], name) for name in seen)
