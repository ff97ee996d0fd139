"""The motions that probes are compared with are as right as they say."""

import pytest

from refdem.scene.elements.spring import Spring
from refdem.smoke.battery import BOUND
from refdem.smoke.diagnosis import distance
from refdem.smoke.force_probes import force_probes
from refdem.smoke.probe_motion import LONGEST_STEP, motion
from refdem.smoke.probes import Probe, probes
from refdem.smoke.turning_probes import turning_probes

PROBES = [
    probe
    for probe in (*probes(), *force_probes(), *turning_probes())
    if probe.scene.all(Spring) or "tumbling" in probe.scene.features
]


@pytest.mark.parametrize("probe", PROBES, ids=lambda probe: probe.name)
def test_steps_sixteen_times_shorter_change_a_motion_by_less_than_a_400th_of_the_bound(
    probe: Probe,
) -> None:
    assert change(probe, LONGEST_STEP) < BOUND / 400


def test_steps_four_times_as_long_would_not_do() -> None:
    (worst,) = [probe for probe in PROBES if probe.name == "spring off the centre in a plane"]
    assert change(worst, 4 * LONGEST_STEP) > BOUND / 400


def change(probe: Probe, step: float) -> float:
    """The largest change of a motion, in units of its scales, from steps [s] to very short ones."""
    t = probe.times - probe.times[0]
    seen = motion(probe.scene, t, longest_step=step)
    exact = motion(probe.scene, t, longest_step=LONGEST_STEP / 16)
    return max(distance(seen[name], exact[name], name) for name in seen)
