"""The reference finds its methods by folder and a method for a scene by the scene's content."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import UnsupportedError, UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

TIMES = np.arange(5) * 0.25


def oscillator(*elements) -> Motion:
    """A point on a spring, and what else acts."""
    return Motion(
        Scene.of(
            [Body(mass=1.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=1.0), *elements]
        ),
        TIMES,
    )


def test_reference_is_found_and_never_ranked():
    engine = discovery.engine("reference")
    assert engine is ENGINE
    assert engine.is_reference
    assert engine.missing() is None


def test_every_file_in_solvers_is_a_method_with_a_name_of_its_own():
    names = [method.name for method in ENGINE.methods]
    assert len(set(names)) == len(names)
    assert {"velocity-verlet", "rk4", "contact-events", "exact-coulomb", "equilibrium"} <= set(
        names
    )
    assert all(ENGINE.solvers[name].claims.name == name for name in names)


def test_methods_come_cheapest_first():
    ranks = [method.cost_rank for method in ENGINE.methods]
    assert ranks == sorted(ranks)


def test_fingerprint_is_stable_and_differs_from_method_to_method():
    prints = {method.name: ENGINE.fingerprint(method) for method in ENGINE.methods}
    assert len(set(prints.values())) == len(prints)
    assert prints == {method.name: ENGINE.fingerprint(method) for method in ENGINE.methods}


def test_closed_form_is_chosen_where_the_scene_has_one():
    assert ENGINE.best(oscillator()).name == "exact-harmonic"
    assert (
        ENGINE.best(oscillator(Slider(a=0, friction=0.25, normal_force=1.0))).name
        == "exact-coulomb"
    )


def test_a_method_takes_over_where_there_is_no_closed_form():
    stiffening = Motion(
        Scene.of(
            [Body(mass=1.0, position=(1.0, 0.0, 0.0))],
            [Spring(a=0, stiffness=1.0, length=0.5, exponent=1.5)],
        ),
        TIMES,
    )
    assert ENGINE.best(stiffening).control == "step"


def test_a_scene_that_no_method_can_run_is_unsupported_with_every_reason():
    impossible = oscillator(Slider(a=0, friction=0.25, normal_force=1.0), Rod(a=0, length=1.0))
    with pytest.raises(
        UnsupportedError, match=r"velocity-verlet: .*exact-coulomb|exact-coulomb: .*velocity-verlet"
    ):
        ENGINE.best(impossible)


def test_a_refused_request_raises_with_the_missing_feature():
    problem = oscillator(Slider(a=0, friction=0.25, normal_force=1.0))
    with pytest.raises(UnsupportedError, match="slider"):
        ENGINE.run(Request(problem=problem, method="velocity-verlet", step=0.125))


def test_an_unknown_method_is_bad_usage():
    with pytest.raises(UsageError, match="velocity-verlet"):
        ENGINE.run(Request(problem=oscillator(), method="velocity-verlot", step=0.125))


@pytest.mark.parametrize(
    "method",
    [
        method
        for method in ENGINE.methods
        if ENGINE.unsupported_motion(oscillator(), method) is None
    ],
    ids=lambda m: m.name,
)
def test_every_method_that_takes_the_oscillator_solves_it(method):
    request = Request(
        problem=oscillator(), method=method.name, step=2.0**-8 if method.control == "step" else None
    )
    trajectory, cost = ENGINE.run(request)
    request.refuse_misaligned(trajectory.t)
    assert np.abs(trajectory.position[:, 0, 0] - np.cos(TIMES)).max() < 1e-5
    assert cost.seconds > 0
