"""Springs with powers, dashpots and periodic forces as elements: force against potential,
dimensions, clock, and what is refused.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion
from refdem.core.symmetry import Symmetry
from refdem.errors import SceneError
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring

BODY = Body(mass=2.0, position=(1.0, 2.0, 2.0))
LAW = Spring(a=0, stiffness=-1.5, exponent=1.5, length=2.0, quadratic=0.75, cubic=0.25)


@pytest.mark.parametrize("distance", [0.5, 1.75, 2.0, 3.5])
def test_a_spring_pulls_as_its_potential_falls(distance):
    def potential(at):
        scene = Scene.of([BODY], [LAW])
        return float(
            scene.potential(np.array([[[at, 0.0, 0.0]]]), np.array([[[1.0, 0.0, 0.0, 0.0]]]))[0]
        )

    h = 1e-5
    s = distance - 2.0
    slope = (potential(distance + h) - potential(distance - h)) / (2 * h)
    expected = -1.5 * np.sign(s) * abs(s) ** 1.5 + 0.75 * s**2 + 0.25 * s**3
    assert slope == pytest.approx(expected, abs=1e-9 if s else 1e-7)
    assert float(LAW.pull(np.array(s))) == pytest.approx(expected, abs=1e-14)


def test_the_size_of_a_potential_does_not_cancel():
    well = Spring(a=0, stiffness=-1.0, cubic=1.0)
    attitude = np.array([[[1.0, 0.0, 0.0, 0.0]]])
    place = np.array([[[2.0**0.5, 0.0, 0.0]]])
    assert abs(well.potential(None, place, attitude)[0]) < 1e-15
    assert well.potential_terms(place, attitude)[0] == pytest.approx(2.0, rel=1e-14)


def test_features_tell_what_is_beyond_a_linear_spring_and_a_linear_dashpot():
    assert Spring(a=0, stiffness=1.0).features() == {"spring"}
    assert LAW.features() == {"spring", "spring:exponent", "spring:quadratic", "spring:cubic"}
    assert Dashpot(a=0, damping=1.0).features() == {"dashpot"}
    assert Dashpot(a=0, van_der_pol=1.0).features() == {"dashpot", "dashpot:van_der_pol"}


def test_what_brings_energy_in_is_said_to():
    assert not Dashpot(a=0, damping=1.0, van_der_pol=2.0).drives
    assert Dashpot(a=0, damping=-1.0, van_der_pol=2.0).drives
    assert Force(a=0, amplitude=1.0).drives
    assert Scene.of([BODY], [Force(a=0, amplitude=1.0)]).is_driven()
    assert not Scene.of([BODY], [Dashpot(a=0, damping=1.0)]).is_driven()
    assert Scene.of([BODY], [Dashpot(a=0)]).is_conservative()
    assert not Scene.of([BODY], [Dashpot(a=0, damping=1.0)]).is_conservative()


def test_a_later_start_finds_the_force_at_the_same_phase():
    force = Force(a=0, amplitude=3.0, frequency=2.0, phase=0.25)
    t = np.linspace(0.0, 3.0, 7)
    assert force.delayed(40.0).strength(t + 40.0) == pytest.approx(force.strength(t), abs=1e-13)
    assert force.delayed(0.0) is force
    motion = Motion(Scene.of([BODY], [force]), t)
    shown = Symmetry(delay=40.0).applied(motion)
    assert shown.scene.all(Force)[0] == force.delayed(40.0)


def test_other_units_change_each_number_by_its_dimension():
    elements = [
        LAW,
        Dashpot(a=0, damping=3.0, van_der_pol=5.0),
        Force(a=0, amplitude=7.0, frequency=2.0, phase=0.5),
    ]
    shown = Symmetry(units=(0.25, 8.0, 2.0)).applied(
        Motion(Scene.of([BODY], elements), np.array([0.0, 1.0]))
    )
    spring, dashpot, force = shown.scene.elements
    assert spring.stiffness == pytest.approx(-1.5 * 0.25 * 8.0**-0.5 / 4)
    assert (spring.quadratic, spring.cubic) == (0.75 * 0.25 / 8 / 4, 0.25 * 0.25 / 64 / 4)
    assert (dashpot.damping, dashpot.van_der_pol) == (3.0 * 0.25 / 2, 5.0 * 0.25 / 64 / 2)
    assert (force.amplitude, force.frequency, force.phase) == (7.0 * 0.25 * 8 / 4, 1.0, 0.5)


@pytest.mark.parametrize(
    ("fields", "word"),
    [({"axis": (1.0, 1.0, 0.0)}, "axis has length"), ({"frequency": -1.0}, "frequency is -1")],
)
def test_forces_that_are_not_well_formed_are_refused(fields, word):
    with pytest.raises(SceneError, match=word):
        Scene.of([BODY], [Force(a=0, amplitude=1.0, **fields)])


def test_elements_survive_json():
    scene = Scene.of(
        [BODY],
        [
            LAW,
            Dashpot(a=0, damping=3.0, van_der_pol=5.0),
            Force(a=0, amplitude=7.0, frequency=2.0, phase=0.5),
        ],
    )
    assert Scene.from_json(scene.to_json()).elements == scene.elements
