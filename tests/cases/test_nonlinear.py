"""Drives that carry a mass over the rim of its well are refused; those that do not are not."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.errors import UsageError

OUT = [
    ("driven-duffing", {"beta": "-0.235", "f0": "1440", "duration": "0.25", "samples": "16"}),
    ("driven-duffing", {"beta": "-0.4", "x0": "0"}),
    ("driven-duffing", {"beta": "-1", "f0": "-0.9", "drive": "0", "x0": "0", "delta": "1"}),
    ("quadratic-response", {"f0": "5,5"}),
    ("quadratic-response", {"f0": "0,-3", "drive": "0,0", "eps": "0.1"}),
]
INSIDE = [
    ("driven-duffing", {"beta": "-0.1", "f0": "0.1"}),
    # Faster than the well can follow: strong, but the mass hardly moves.
    ("driven-duffing", {"beta": "-0.235", "f0": "1440", "drive": "100", "x0": "0"}),
    ("driven-duffing", {"beta": "0.235", "f0": "1440", "duration": "0.25"}),
    ("quadratic-response", {"f0": "-0.2,0.2", "duration": "1000"}),
]


@pytest.mark.parametrize(("name", "given"), OUT)
def test_a_drive_that_carries_the_mass_over_the_rim_is_refused(name, given):
    with pytest.raises(UsageError, match="over the rim of its well"):
        discovery.case(name).at(**given)


@pytest.mark.parametrize(("name", "given"), INSIDE)
def test_a_drive_that_does_not_is_accepted(name, given):
    assert discovery.case(name).at(**given).scales.length > 0


def test_a_motion_that_is_accepted_stays_inside_by_its_certified_places():
    accepted = 0
    rng = np.random.default_rng(5)
    for f0 in rng.uniform(0, 2, 20):
        given = {"beta": "-0.4", "f0": f"{f0:.3g}", "x0": "0.3", "duration": "8", "samples": "16"}
        try:
            instance = discovery.case("driven-duffing").at(**given)
        except UsageError:
            continue
        accepted += 1
        places = [float(instance.truth().at(t)["x"].mid) for t in range(1, 9)]
        assert max(np.abs(places)) < np.sqrt(1 / 0.4)
    assert 3 < accepted < 18
