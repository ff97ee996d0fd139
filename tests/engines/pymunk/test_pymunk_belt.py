"""A belt in pymunk: Coulomb's law against a body that moves, compared with certified truth; so is
the law that fades, said by callbacks.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.pymunk import ENGINE

COULOMB = {"lambda0": "0", "lambda1": "0", "mu1": "2/5", "gamma": "0"}


@pytest.mark.parametrize(
    "given", [{"x0": "2"}, {"x0": "2", "belt": "-0.5"}, {"x0": "5", "belt": "0.25"}], ids=str
)
def test_a_mass_on_a_belt_is_carried_and_let_go(given):
    instance = discovery.case("stick-slip").at(**COULOMB, **given, duration="8", samples="8")
    assert ENGINE.unsupported_motion(instance.problem, ENGINE.methods[0]) is None
    seen, _ = ENGINE.run(
        Request(problem=instance.problem, method=ENGINE.methods[0].name, step=2.0**-9)
    )
    truth = instance.truth()
    for row, t in enumerate(seen.t):
        assert seen.position[row, 0, 0] == pytest.approx(
            float(truth.at(Fraction(float(t)))["x"].mid), abs=5e-3
        )


def test_it_is_carried_at_the_speed_of_the_belt():
    instance = discovery.case("stick-slip").at(
        **COULOMB, x0="5", belt="0.25", duration="6", samples="24"
    )
    seen, _ = ENGINE.run(
        Request(problem=instance.problem, method=ENGINE.methods[0].name, step=2.0**-9)
    )
    late = seen.t > 3.5
    np.testing.assert_allclose(seen.velocity[late, 0, 0], 0.25, atol=1e-12)


@pytest.mark.parametrize(
    "given",
    [{}, {"friction_law": "linear", "gamma": "2", "eta": "5/4"}, {"gamma": "0", "x0": "2"}],
    ids=str,
)
def test_stribecks_law_and_the_drive_are_said_by_callbacks_at_first_order(given):
    instance = discovery.case("stick-slip").at(**given, duration="8", samples="8")
    truth = instance.truth()
    exact = np.array([float(truth.at(Fraction(float(t)))["x"].mid) for t in instance.problem.times])
    errors = []
    for step in (2.0**-9, 2.0**-10):
        seen, _ = ENGINE.run(
            Request(problem=instance.problem, method=ENGINE.methods[0].name, step=step)
        )
        errors.append(np.abs(seen.position[:, 0, 0] - exact).max())
    assert errors[1] < 0.03
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1, abs=0.25)
