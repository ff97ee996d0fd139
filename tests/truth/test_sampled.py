"""Truth at the samples, and at times before them for velocities that lag."""

import math

import numpy as np

from refdem.core import discovery
from refdem.truth.sampled import sampled


def test_earlier_samples_are_those_of_the_earlier_times_and_nothing_is_known_before_the_first() -> (
    None
):
    instance = discovery.case("harmonic-oscillator").at(samples="8", duration="2")
    times = instance.times
    delay = 2.0**-6
    found = sampled(instance.truth(), times.tolist(), [delay])
    late = found.delayed(delay)
    assert np.allclose(late.value("v")[1:], -np.sin(times[1:] - delay), rtol=0, atol=1e-15)
    assert late.radius("v")[0] == math.inf
    assert np.all(late.radius("v")[1:] < 1e-15)
    assert found.value("v")[1] != late.value("v")[1]
    assert sampled(instance.truth(), times.tolist()).earlier == {}
