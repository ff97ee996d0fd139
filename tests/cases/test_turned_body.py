"""The body and the triangle of the case rotations: errors of a right program stay below the bound
at random settings, and a triangle without a base is refused.
"""

import random

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.errors import UsageError
from refdem.truth.closed_forms import rotations
from refdem.truth.closed_forms.quaternions import listed
from tests.cases.test_algebra import DECADES, drawn

BOUND = 8 * 2.0**-53
"""Four units in the last place: the bound of a result over its size."""
ROWS = (
    "cosine-product",
    "cosines-mixed",
    "spin-energy",
    "spin-momentum",
    "momentum-energy",
    "half-turned-tensor",
    "turned-tensor",
    "principal-moments",
    "turned-momentum",
    "rejection",
    "height",
    "corner-by-base",
    "twice-area",
    "base",
    "height-by-area",
)
SETTINGS = 100
SEED = 7


def instances():
    """Instances of rotations at random settings of what these rows use."""
    rng = random.Random(SEED)
    case = discovery.case("rotations")
    used = [
        parameter
        for parameter in case.parameters
        if parameter.name in ("angle", "omega", "frequency", "shifts", "masses")
    ]
    for _ in range(SETTINGS):
        given = {parameter.name: drawn(rng, parameter, DECADES) for parameter in used}
        angles = (rng.uniform(-3.1, 3.1), rng.uniform(0.02, 3.1), rng.uniform(-3.1, 3.1))
        given["euler"] = ",".join(f"{angle:.4g}" for angle in angles)
        yield case.at(**given)


def test_errors_stay_below_the_bound_at_random_settings():
    engine = discovery.engine("reference")
    largest = dict.fromkeys(ROWS, 0.0)
    for instance in instances():
        truth = listed(rotations.values(instance.p))
        problem = instance.problem
        request = Request(problem=problem, method="rotation-algebra", step=problem.interval)
        trajectory, _ = engine.run(request)
        seen = instance.case.observe(instance.p, trajectory)
        for quantity in instance.case.quantities(instance.p):
            row = quantity.name.partition(".")[0]
            if row in largest:
                error = abs(seen[quantity.name][0] - float(truth[quantity.name].mid()))
                largest[row] = max(largest[row], error / quantity.scale)
    assert {row: error for row, error in largest.items() if error > 0.7 * BOUND} == {}
    assert all(error > 0 for error in largest.values())


def test_a_triangle_without_a_base_is_refused():
    with pytest.raises(UsageError, match="parameter shifts: got a second shift of 0,0,0"):
        discovery.case("rotations").at(shifts="1,2,3,0,0,0")
