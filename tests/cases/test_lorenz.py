"""Lorenz' equations: what is chaotic and what is not, and the horizon of binary64."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.judgement import errors
from refdem.core.refinement import bound, scored
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.planning import plan
from refdem.planning.in_process import run_of, task_of, truth_of

CASE = discovery.case("lorenz")
LONG = CASE.at(n="176")
"""44 units of time; its truth is proved once for both tests."""


@pytest.mark.parametrize(
    ("given", "chaotic"),
    [
        ({}, True),
        ({"start": "0,1,0", "n": "200"}, True),
        ({"start": "0,0,1"}, False),
        ({"rho": "1"}, False),
        ({"rho": "14"}, None),
    ],
)
def test_chaos_is_claimed_where_it_is_proved(given, chaotic):
    instance = CASE.at(**given)
    assert instance.case.is_chaotic(instance.p) is chaotic


def test_binary64_keeps_the_motion_to_its_horizon_and_loses_it_after():
    """At 44 units of time the certified motion is known to 40 digits, and a run is nowhere near."""
    truth = truth_of(LONG)
    task = task_of(ENGINE, "lorenz-taylor", LONG, truth, 3, ("error",))
    run = run_of(ENGINE, plan.request(task, Variant(0.0), ulps=1)).trajectory
    allowed = bound(LONG, task.method, 0.0, truth)
    count = scored(allowed)
    worst = np.maximum.reduce(list(errors(LONG, run, truth).values()))
    horizon = LONG.times[count] * float(LONG.p["interval"])
    assert 20 < horizon < 40
    assert np.all(worst[:count] <= allowed[:count])
    assert np.max(worst[count:]) > 0.1


def test_the_growth_is_that_of_the_known_exponent():
    """0.9056 per unit of time (Sparrow 1982, and others since), over 24 units, within a fifth."""
    growth = truth_of(LONG).growth()[96]
    assert np.log(growth) / 24 == pytest.approx(0.9056, rel=0.2)
