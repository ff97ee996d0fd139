"""Hard spheres: names, scene, and which methods answer."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.scene.elements.contact import Contact

CASE = discovery.case("hard-spheres")


def test_its_parameters_and_quantities_have_these_names() -> None:
    names = "masses radii inertia_factors closing_speed distance offset spins restitution"
    more = "tangential_restitution friction"
    assert [p.name for p in CASE.parameters] == [*names.split(), *more.split()]
    kinds = ("r", "v", "omega")
    expected = [f"{kind}{body}.{axis}" for body in (1, 2) for kind in kinds for axis in "xyz"]
    assert list(CASE.at().quantities) == expected


def test_the_scene_is_two_spheres_apart_whose_centre_of_mass_rests() -> None:
    instance = CASE.at(masses="1,3", radii="1/2,3/4", offset="1/2,1/3", distance="5/2")
    bodies = instance.scene.bodies
    apart = bodies.position[1] - bodies.position[0]
    assert apart == pytest.approx(1.25 * np.array([2.5, 0.5, 1 / 3]))
    assert bodies.mass @ bodies.position == pytest.approx(np.zeros(3))
    assert bodies.mass @ bodies.velocity == pytest.approx(np.zeros(3))
    assert bodies.velocity[0] - bodies.velocity[1] == pytest.approx(np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize(("factor", "moment"), [("2/5", 0.1), ("2/3", 1 / 6), ("1", 0.25)])
def test_solid_and_hollow_spheres_differ_by_their_inertia(factor: str, moment: float) -> None:
    bodies = CASE.at(inertia_factors=f"{factor},{factor}").scene.bodies
    assert bodies.inertia == pytest.approx(np.full((2, 3), moment))


def test_a_law_without_tangential_restitution_is_the_text_that_it_always_was() -> None:
    """The keys of runs that are stored, and programs that read a request, know nothing of it."""
    assert b"tangential_restitution" not in CASE.at().scene.to_json()
    assert Contact(law="rigid", tangential_restitution=0.0) == Contact(law="rigid")
    reversed_slip = CASE.at(tangential_restitution="1/4").scene
    assert b'"tangential_restitution":0.25' in reversed_slip.to_json()
    assert "contact:tangential-restitution" in reversed_slip.features
    assert type(reversed_slip).from_json(reversed_slip.to_json()).elements == reversed_slip.elements


def test_the_reference_answers_it() -> None:
    problem = CASE.at(friction="1/4", spins="1,2,3,-1,1/2,4").problem
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None] == ["impacts"]
