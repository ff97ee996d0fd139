"""The sizes of what the cases of algebra and of solids ask for: a right program is accused at no
setting of their parameters.
"""

import random

import numpy as np
import pytest

from refdem.cases._nine_entries import DECOMPOSED, condition_of_nearest_turn
from refdem.core import discovery
from refdem.core.problem import Identity, Solid
from refdem.core.selection import Selection
from refdem.errors import RefdemError
from refdem.mechanics import rotation
from refdem.planning.in_process import record_of, task_of, truth_of

STATIC = [
    name
    for name in discovery.names("cases")
    if not isinstance(discovery.case(name), Selection)
    and isinstance(discovery.case(name).at().problem, Identity | Solid)
]
EACH = 12
"""Settings that are drawn of a case."""
PROVED_STEP_BY_STEP = {"poincare-sections": (1, 0.1)}
"""Settings, and decades either way of a default, of a case whose truth costs as much as the time
that its motion takes.
"""
DECADES = 3.0
SEED = 5
TRIES = 200


def drawn_number(rng, parameter, default, decades):
    """A number over the whole range of a parameter: over decades either way of its default, or
    evenly between its bounds.
    """
    low = parameter.at_least
    if parameter.above is not None:
        low = parameter.above
    if decades == DECADES and None not in (low, parameter.at_most) and rng.random() < 0.5:
        return rng.uniform(low, parameter.at_most)
    value = (abs(default) or 1.0) * 10 ** rng.uniform(-decades, decades)
    if low is None or (low < 0 and rng.random() < 0.5):
        value *= rng.choice([-1, 1])
    if parameter.at_most is not None:
        value = min(value, parameter.at_most)
    if low is not None:
        value = max(value, low)
    return value


def drawn(rng, parameter, decades):
    """A value of a parameter, as text."""
    if parameter.choices:
        return rng.choice(parameter.choices)
    exact = parameter.parsed(parameter.default)
    if isinstance(exact, tuple):
        defaults = exact
    else:
        defaults = (exact,)
    numbers = [drawn_number(rng, parameter, float(default), decades) for default in defaults]
    if parameter.whole:
        return ",".join(str(round(number)) for number in numbers)
    return ",".join(f"{number:.4g}" for number in numbers)


def settings(name):
    """Instances of a case at the random settings that it accepts."""
    rng = random.Random(f"{SEED} {name}")
    case = discovery.case(name)
    found = []
    count, decades = PROVED_STEP_BY_STEP.get(name, (EACH, DECADES))
    for _ in range(TRIES):
        part = rng.choice([0.2, 0.5, 1.0])
        given = {p.name: drawn(rng, p, decades) for p in case.parameters if rng.random() < part}
        try:
            instance = case.at(**given)
            instance.refuse_unjudgeable()
        except RefdemError:
            continue
        found.append(instance)
        if len(found) == count:
            break
    return found


@pytest.mark.parametrize("name", STATIC)
def test_the_reference_is_accused_at_no_random_setting(name):
    reference = discovery.engine("reference")
    accused = []
    instances = settings(name)
    assert instances
    for instance in instances:
        truth = truth_of(instance)
        for method in reference.methods:
            if reference.unsupported(instance.problem, method):
                continue
            findings = record_of(task_of(reference, method.name, instance, truth, 4)).findings
            accused += [
                (instance.label, finding.sentence)
                for finding in findings
                if finding.outcome in ("fail", "error")
            ]
    assert accused == []


@pytest.mark.parametrize("omega", ["1e-3,2e-3,0", "1,-2,1/2", "0.998,1410,-0.00351", "1e6,0,1"])
def test_an_error_of_nine_entries_counts_less_than_twice_in_the_nearest_turn(omega):
    p = discovery.case("rotations").at(omega=omega, step="1/8").p
    matrix = rotation.first_order_turn(rotation.matrix_of_euler(*p.euler), p.step * p.omega)
    size = np.linalg.norm(matrix, 2)
    nearest = rotation.nearest_turn(matrix)
    rng = np.random.default_rng(3)
    condition = condition_of_nearest_turn(p)
    largest = 0.0
    for _ in range(200):
        # Antisymmetric as seen from the rotation: the part of a change that turns it.
        change = rng.normal(size=(3, 3))
        change = nearest @ (change - change.T)
        change *= 1e-6 * size / np.linalg.norm(change)
        moved = np.linalg.norm(rotation.nearest_turn(matrix + change) - nearest)
        largest = max(largest, moved / 1e-6)
    assert 0.9 * condition < largest < 1.001 * condition < 2.002


def test_decomposed_matrices_stay_within_what_lapack_neglects():
    # u^(7/8) of 8 u, the bound of a result of size 1.
    u = 2.0**-53
    assert u ** (7 / 8) / (8 * u) == pytest.approx(DECOMPOSED, rel=0.06)
