"""A belt in pymunk: Coulomb's law against a body that moves, compared with certified truth; a law that fades is refused."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.pymunk import ENGINE

COULOMB = {"lambda0": "0", "lambda1": "0", "mu1": "2/5", "gamma": "0"}


@pytest.mark.parametrize("given", [{"x0": "2"}, {"x0": "2", "belt": "-0.5"}, {"x0": "5", "belt": "0.25"}], ids=str)
def test_a_mass_on_a_belt_is_carried_and_let_go(given):
    instance = discovery.case("stick-slip").at(**COULOMB, **given, duration="8", samples="8")
    assert ENGINE.refusal(instance.problem, ENGINE.methods[0]) is None
    seen, _ = ENGINE.run(Request(problem=instance.problem, method=ENGINE.methods[0].name, step=2.0**-9))
    truth = instance.truth()
    for row, t in enumerate(seen.t):
        assert seen.position[row, 0, 0] == pytest.approx(float(truth.at(Fraction(float(t)))["x"].mid), abs=5e-3)


def test_it_is_carried_at_the_speed_of_the_belt():
    instance = discovery.case("stick-slip").at(**COULOMB, x0="5", belt="0.25", duration="6", samples="24")
    seen, _ = ENGINE.run(Request(problem=instance.problem, method=ENGINE.methods[0].name, step=2.0**-9))
    late = seen.t > 3.5
    np.testing.assert_allclose(seen.velocity[late, 0, 0], 0.25, atol=1e-12)


def test_friction_that_falls_with_the_speed_is_refused():
    problem = discovery.case("stick-slip").at(gamma="0").problem
    assert "depends on the speed" in (ENGINE.refusal(problem, ENGINE.methods[0]) or "")
