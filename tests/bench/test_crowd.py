"""The cost of many spheres: every code moves the gas that it is given, and the table compares what
was measured in the same rounds.
"""

import numpy as np
import pytest

from refdem.bench.crowd import Cost, costs, table
from refdem.bench.crowds import crowds
from refdem.bench.crowds._crowd import Gas
from refdem.cli.bench import crowded
from refdem.core import discovery
from refdem.errors import UsageError


def gas(**given: str) -> Gas:
    return Gas(discovery.case("granular-gas").at(n="100", **given), 2.0**-10)


@pytest.mark.parametrize("crowd", crowds(), ids=lambda crowd: crowd.name)
def test_every_code_moves_a_gas_or_says_why_not(crowd) -> None:
    for boundary in ("periodic", "walls"):
        for friction in ("0", "1/2"):
            asked = gas(boundary=boundary, friction=friction)
            assert crowd.unsupported(asked) or crowd.seconds(asked, 20) > 0
    assert not all(crowd.unsupported(gas(boundary=boundary)) for boundary in ("periodic", "walls"))


def test_the_reference_comes_first_and_is_compared_in_the_same_rounds(monkeypatch) -> None:
    monkeypatch.setattr("refdem.bench.crowd.LONG", 1e-4)
    found = costs([100], rounds=3)
    assert crowds()[0].is_reference
    assert all(cost.ratio == 1 for cost in found if cost.name == "reference gas")
    assert {(cost.law, cost.boundary) for cost in found} == {
        (law, b) for law in ("smooth", "rough") for b in ("periodic", "walls")
    }
    assert all(len(cost.rounds) == len(cost.beside) == 3 and min(cost.rounds) > 0 for cost in found)


def test_a_ratio_is_the_median_of_rounds_not_a_ratio_of_medians() -> None:
    cost = Cost(
        100, "smooth", "walls", "slow", "", rounds=[10.0, 40.0, 90.0], beside=[1.0, 2.0, 3.0]
    )
    assert cost.ratio == 20
    assert table([cost]).rows[0][1:5] == ("slow", "40", "10 to 90", "20")


def test_a_gas_says_its_box_by_periods_or_by_walls() -> None:
    periodic = gas()
    walls = gas(boundary="walls")
    assert periodic.size == pytest.approx(walls.size, rel=1e-15)
    assert (periodic.periodic, walls.periodic) == (True, False)
    assert np.all(walls.position < walls.size)


@pytest.mark.parametrize("sizes", ["ten", "10", "1000,"])
def test_sizes_that_are_none_are_refused(sizes: str) -> None:
    with pytest.raises(UsageError, match="--crowd"):
        crowded(sizes, 1)
