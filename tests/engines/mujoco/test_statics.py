"""Solids that MuJoCo's compiler does not take are refused with a sentence."""

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.errors import UnsupportedError


def test_a_solid_that_is_too_light_is_refused_by_its_name():
    problem = discovery.case("moments-of-inertia").at(c="1/1048576").problem
    request = Request(problem=problem, method="compiler", step=problem.interval)
    with pytest.raises(UnsupportedError, match=r"of stick is below mjMINVAL = 1e-15"):
        discovery.engine("mujoco").run(request)
