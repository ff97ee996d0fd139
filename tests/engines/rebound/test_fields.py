"""What REBOUND is told of the forces of a scene: whether there are any, and whether they depend on
velocities.
"""

import pytest

from refdem.engines.rebound.fields import _touches, fields_of
from refdem.scene import Body, Scene, Sphere
from refdem.scene.element import Element
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

SOFT = {"law": "linear", "stiffness": 2.0}
NONE, OF_PLACE, OF_VELOCITY = (False, False), (True, False), (True, True)


@pytest.mark.parametrize(
    ("elements", "told"),
    [
        ([], NONE),
        ([CentralField(gm=1.0)], NONE),
        ([Contact(law="rigid", restitution=0.5)], NONE),
        ([UniformGravity(g=(1.0, 0.0, 0.0))], OF_PLACE),
        ([Spring(a=0, stiffness=1.0)], OF_PLACE),
        ([Force(a=1, amplitude=1.0)], OF_PLACE),
        ([PiecewiseField(k1=1.0, k2=-1.0, x1=-1.0, x2=1.0)], OF_PLACE),
        ([Contact(**SOFT)], OF_PLACE),
        ([Contact(**SOFT, cutoff="zero_force")], OF_PLACE),
        ([Contact(law="hertz", stiffness=2.0)], OF_PLACE),
        ([Contact(**SOFT, damping=0.5)], OF_VELOCITY),
        ([Contact(**SOFT, damping=0.5, cutoff="zero_force")], OF_VELOCITY),
        ([Dashpot(a=0, damping=0.5)], OF_VELOCITY),
        ([Dashpot(a=0, b=1, van_der_pol=0.5)], OF_VELOCITY),
        ([Rod(a=0, b=1, length=3.0)], OF_VELOCITY),
    ],
    ids=str,
)
def test_a_scene_tells_whether_it_has_forces_and_what_they_read(
    elements: list[Element], told: tuple[bool, bool]
) -> None:
    shape = Sphere(radius=1.0)
    bodies = [Body(mass=1.0, position=(3.0 * n, 0.0, 0.0), shape=shape) for n in range(2)]
    fields = fields_of(Scene.of(bodies, elements))
    assert (fields.has_forces, fields.reads_velocity) == told


@pytest.mark.parametrize("cutoff", ["zero_overlap", "zero_force"])
@pytest.mark.parametrize(
    ("law", "exponent", "damping"),
    [("linear", 1.0, 0.25), ("linear", 1.0, 0.0), ("hertz", 1.5, 0.0)],
)
def test_every_pair_of_spheres_has_the_numbers_of_its_law(
    cutoff: str, law: str, exponent: float, damping: float
) -> None:
    """Sum of the radii, stiffness, exponent, damping, and 1 where the force may pull."""
    bodies = [
        Body(mass=1.0, position=(9.0 * n, 0.0, 0.0), shape=Sphere(radius=1.5 + n)) for n in range(3)
    ]
    bodies.insert(1, Body(mass=1.0, position=(0.0, 5.0, 0.0)))
    contact = Contact(law=law, stiffness=2.0, damping=damping, cutoff=cutoff)
    touches = _touches(Scene.of(bodies, [contact]))
    rest = (2.0, exponent, damping, float(cutoff == "zero_overlap"))
    assert [(touch.bodies, touch.numbers) for touch in touches] == [
        ((0, 2), (4.0, *rest)),
        ((0, 3), (5.0, *rest)),
        ((2, 3), (6.0, *rest)),
    ]
    assert all(touch.is_damped is (damping > 0) for touch in touches)
