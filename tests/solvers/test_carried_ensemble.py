"""Many starts at once: the same as one by one, refused where one of them is; and the question's way
through JSON.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.ensemble import Ensemble
from refdem.core.problem import Request
from refdem.errors import UsageError

ENGINE = discovery.engine("reference")
FLOWS = ("harmonic", "viscous", "coulomb", "pendulum")


def asked(flow="harmonic", **given):
    return discovery.case("phase-flow").at(flow=flow, points="64", samples="6", **given).problem


def answer(problem):
    return ENGINE.run(Request(problem=problem, method=ENGINE.best(problem).name))[0]


@pytest.mark.parametrize("flow", FLOWS)
def test_every_start_moves_as_it_does_alone(flow):
    problem = asked(flow)
    together = answer(problem)
    for member in (0, 17, len(problem.position) - 1):
        alone = answer(problem.motion(member))
        assert np.abs(together.values["position"][:, member] - alone.position).max() < 4e-15
        assert np.abs(together.values["velocity"][:, member] - alone.velocity).max() < 4e-15


@pytest.mark.parametrize("flow", FLOWS)
def test_an_ensemble_survives_json_to_the_last_bit(flow):
    problem = asked(flow)
    request = Request(problem=problem, method="carried-ensemble")
    again = Request.from_json(request.to_json())
    assert again.to_json() == request.to_json()
    assert np.array_equal(again.problem.position, problem.position)
    assert np.array_equal(again.problem.velocity, problem.velocity)


def test_starts_off_the_line_or_the_rod_are_refused():
    line = asked()
    rod = asked("pendulum")
    off = np.zeros_like(line.position)
    off[3, 0, 1] = 1e-3
    for problem in (line, rod):
        astray = Ensemble(problem.scene, problem.times, problem.position + off, problem.velocity)
        assert ENGINE.unsupported(problem, ENGINE.method("carried-ensemble")) is None
        assert ENGINE.unsupported(astray, ENGINE.method("carried-ensemble")) is not None


def test_starts_of_a_wrong_shape_and_starts_that_are_not_finite_are_refused():
    problem = asked()
    for position in (problem.position[:-1], problem.position * np.nan):
        with pytest.raises(UsageError, match="ensemble"):
            Ensemble(problem.scene, problem.times, position, problem.velocity)


def test_other_engines_refuse_ensembles():
    problem = asked()
    for name in ("mujoco", "pymunk", "rebound"):
        engine = discovery.engine(name)
        assert all(engine.unsupported(problem, method) for method in engine.methods)


def test_a_head_on_both_sides_of_the_axis_is_refused_under_dry_friction():
    with pytest.raises(UsageError, match="one side"):
        asked("coulomb", centre="1,0")
