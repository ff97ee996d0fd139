"""A gate that names no case runs also what the defaults of a case keep still."""

import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.gate.gate import supported
from refdem.gate.telling import TELLING


@pytest.mark.parametrize(("case", "number"), [(case, k) for case, sets in TELLING.items() for k in range(len(sets))])
def test_every_setting_is_one_that_a_case_knows_and_is_certified_to_the_end(case, number):
    instance = discovery.case(case).at(**TELLING[case][number])
    last = instance.truth().at(instance.times[-1])
    assert all(float(ball.radius) < 1e-12 for ball in last.values())


def test_a_gate_of_all_cases_has_them_beside_the_defaults():
    entries = [entry for entry in supported(ENGINE) if entry.id == "two-spheres"]
    assert [entry.set for entry in entries] == [{}, *(dict(given) for given in TELLING["two-spheres"])]
