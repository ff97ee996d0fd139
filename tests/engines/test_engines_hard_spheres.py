"""Two rigid spheres that meet once, by the engines' own collisions: against exact truth, in every
regime of friction that the engine has, and with errors planted in what the adapter says.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import angular, angular_scale, linear, momentum_scale
from refdem.core.problem import Request
from refdem.engines.pymunk import shapes
from refdem.engines.rebound import simulation

IN_PLANE = [
    ("pymunk", "semi-implicit-euler"),
    ("rebound", "leapfrog"),
    ("rebound", "leapfrog-line"),
    ("rebound", "leapfrog-uncut"),
]
UNEQUAL = {"masses": "1,3", "radii": "1/2,3/4"}
FRICTIONLESS = [
    {},
    {"restitution": "0", "offset": "0,0"},
    {"restitution": "1", "offset": "-1/4,0", **UNEQUAL},
    {"masses": "1e6,1", "closing_speed": "1e3", "distance": "3/2"},
    {"restitution": "1/8", "closing_speed": "1e-4", "offset": "9/10,0"},
]
ROUGH = [
    {"friction": "1/10", **UNEQUAL},
    {"friction": "2", "restitution": "1", "inertia_factors": "1/2,1"},
    {"friction": "1/4", "spins": "0,0,1,0,0,-2", **UNEQUAL},
    {"friction": "1", "spins": "0,0,-3,0,0,-3", "offset": "0,0", "inertia_factors": "2/3,2/5"},
]
SETTINGS = [(*method, given) for method in IN_PLANE for given in FRICTIONLESS]
SETTINGS += [(*IN_PLANE[0], given) for given in ROUGH]
OUT_OF_PLANE = {"offset": "1/4,1/3", **UNEQUAL}
SETTINGS += [(*method, OUT_OF_PLANE) for method in IN_PLANE[1:]]
COUNTS = (27, 33, 37, 43)
"""Steps a sample: where in its step the impact lies scatters the error, and the largest counts.

The impact is in the middle between two samples: of an even number of steps one would end there.
"""
FINER = 65


def played(engine, method, given, count):
    """The instance, and its trajectory with `count` steps a sample."""
    instance = discovery.case("hard-spheres").at(samples="8", **given)
    adapter = discovery.engine(engine)
    assert adapter.unsupported(instance.problem, adapter.method(method)) is None
    step = instance.problem.interval / count
    run, _ = adapter.run(Request(problem=instance.problem, method=method, step=step))
    return instance, run


def error(engine, method, given, count):
    """The largest error of any quantity at any sample, in units of its scale."""
    instance, run = played(engine, method, given, count)
    seen = instance.observe(run)
    truth = instance.truth()
    largest = 0.0
    for row, t in enumerate(instance.problem.times):
        certified = truth.at(Fraction(float(t)))
        for name, quantity in instance.quantities.items():
            departure = abs(seen[name][row] - float(certified[name].mid)) / quantity.scale
            largest = max(largest, departure)
    return largest


@pytest.mark.parametrize(("engine", "method", "given"), SETTINGS, ids=str)
def test_an_impact_is_that_of_exact_truth_at_first_order(engine, method, given):
    coarse = max(error(engine, method, given, count) for count in COUNTS)
    fine = max(error(engine, method, given, FINER * count) for count in COUNTS)
    assert fine < 2e-3
    assert np.log(coarse / fine) / np.log(FINER) == pytest.approx(1, abs=0.25)


@pytest.mark.parametrize(("engine", "method", "given"), SETTINGS, ids=str)
def test_an_impact_keeps_momentum_and_angular_momentum_as_claimed(engine, method, given):
    instance, run = played(engine, method, given, 27)
    total = linear(instance.scene, run)
    assert np.abs(total - total[0]).max() < 1e-14 * momentum_scale(instance)
    turn = angular(instance.scene, run)["total"]
    change = np.abs(turn - turn[0]).max() / angular_scale(instance)
    claims = discovery.engine(engine).method(method)
    if claims.keeps("angular-momentum", instance.scene.features):
        # A rounding of r x v a step; an arm that is wrong changes L by more than 1e-3.
        assert change < 2e-13
    else:
        assert change < 1e-2


@pytest.mark.parametrize("power", [0.5, 2.0])
@pytest.mark.parametrize(("engine", "method"), IN_PLANE)
def test_a_restitution_that_is_combined_wrongly_shows(monkeypatch, engine, method, power):
    always = simulation._always
    factors = shapes.factors

    def wrong(value, *, is_alone):
        return factors(value**power, is_alone=is_alone)

    monkeypatch.setattr(simulation, "_always", lambda value: always(value**power))
    monkeypatch.setattr(shapes, "factors", wrong)
    assert error(engine, method, {"restitution": "1/2"}, 1024) > 3e-2


def test_a_friction_that_is_combined_wrongly_shows(monkeypatch):
    factors = shapes.factors

    def wrong(value, *, is_alone):
        return tuple(1.5 * x for x in factors(value, is_alone=is_alone))

    monkeypatch.setattr(shapes, "factors", wrong)
    rough = {"friction": "1/10", "restitution": "0"}
    assert error("pymunk", "semi-implicit-euler", rough, 1024) > 3e-2


def test_collisions_of_rebound_are_the_same_to_the_bit_in_every_run():
    """REBOUND resolves the collisions of a step in a random order, whose seed is the clock's."""
    runs = [played("rebound", "leapfrog", {}, 4)[1] for _ in range(16)]
    for run in runs[1:]:
        assert np.array_equal(run.position, runs[0].position)
        assert np.array_equal(run.velocity, runs[0].velocity)


REFUSED = [
    (
        "pymunk",
        "semi-implicit-euler",
        OUT_OF_PLANE,
        "the engine does not support motion or rotation in three",
    ),
    (
        "pymunk",
        "semi-implicit-euler",
        {"friction": "1", "tangential_restitution": "1/2"},
        "the engine does not support an impact that reverses the slip",
    ),
    (
        "rebound",
        "leapfrog",
        {"friction": "1/4"},
        "the engine does not support friction between particles",
    ),
    ("rebound", "leapfrog", {"spins": "0,0,1,0,0,0"}, "the engine does not support rotation"),
    ("rebound", "ias15", {}, "the adapter does not support yet: hard spheres by an integrator"),
    (
        "rebound",
        "leapfrog-8",
        {},
        "the adapter does not support yet: hard spheres by an integrator",
    ),
    ("mujoco", "rk4", {}, "a coefficient of restitution"),
]


@pytest.mark.parametrize(("engine", "method", "given", "words"), REFUSED)
def test_an_impact_that_an_engine_cannot_say_is_refused(engine, method, given, words):
    adapter = discovery.engine(engine)
    problem = discovery.case("hard-spheres").at(**given).problem
    assert words in str(adapter.unsupported(problem, adapter.method(method)))
