"""A body that slides until it rolls: names, scene, clock, and which methods and engines answer."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.uniform_gravity import UniformGravity

CASE = discovery.case("rolling")


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "mass radius inertia_factor speed spin friction slope gravity"
    assert [p.name for p in CASE.parameters] == names.split()
    assert list(CASE.at().quantities) == ["x", "y", "vx", "vy", "omega"]


def test_the_body_lies_on_the_plane_and_gravity_is_tilted() -> None:
    scene = CASE.at(slope="3/4", gravity="10", radius="1/4", speed="-2", spin="5").scene
    assert scene.bodies.position[0].tolist() == [0.0, 0.25, 0.0]
    assert scene.bodies.velocity[0].tolist() == [-2.0, 0.0, 0.0]
    assert scene.bodies.omega[0].tolist() == [0.0, 0.0, 5.0]
    assert np.allclose(scene.all(UniformGravity)[0].g, (6.0, -8.0, 0.0), rtol=1e-15, atol=0)
    assert scene.all(Contact)[0].restitution == 0


@pytest.mark.parametrize(
    "given",
    [{}, {"spin": "20"}, {"slope": "3/4", "speed": "-2"}, {"slope": "2", "speed": "-4"}],
    ids=str,
)
def test_the_slip_ends_within_the_run_and_at_the_end_of_no_step(given: dict[str, str]) -> None:
    instance = CASE.at(**given)
    scalars = instance.truth().scalars()
    end = float(next(scalars[k].mid for k in ("roll_time", "reversal_time") if k in scalars))
    assert 0.05 < end / instance.times[-1] < 0.6
    for stride in (1, 2, 4, 8):
        past = np.modf(end / (instance.times[1] / stride))[0]
        assert 1e-2 < past < 1 - 1e-2


def test_a_slip_that_does_not_end_is_not_waited_for() -> None:
    for given in ({"friction": "0"}, {"friction": "1/100000"}, {"spin": "-8"}):
        instance = CASE.at(**given)
        assert 7 < instance.scales.duration / instance.scales.tau < 70


@pytest.mark.parametrize(
    ("given", "words"),
    [({"slope": "-1"}, "slope"), ({"friction": "-1"}, "friction"), ({"gravity": "0"}, "gravity")],
)
def test_numbers_out_of_bounds_are_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        CASE.at(**given)


@pytest.mark.parametrize("slope", ["0", "3/4", "7/8", "2"])
def test_one_method_of_the_reference_answers_it_and_no_impact_is_made_of_it(slope: str) -> None:
    problem = CASE.at(slope=slope).problem
    able = [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None]
    assert able == ["exact-rolling"]
    impacts = next(m for m in ENGINE.methods if m.name == "impacts")
    assert "lies on a plane" in str(ENGINE.unsupported(problem, impacts))


def test_at_rest_on_a_level_plane_it_is_in_equilibrium() -> None:
    assert ENGINE.best(CASE.at(speed="0").problem).name == "equilibrium"


def test_engines_run_it_or_say_that_they_cannot() -> None:
    problem = CASE.at().problem
    for name in ("mujoco", "pymunk"):
        engine = discovery.engine(name)
        assert any(engine.unsupported(problem, m) is None for m in engine.methods)
    rebound = discovery.engine("rebound")
    for name in ("leapfrog", "ias15", "bs"):
        reason = str(rebound.unsupported(problem, rebound.method(name)))
        assert (
            reason == "the engine does not support friction between particles (they have no spin)"
        )
