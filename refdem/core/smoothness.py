"""The largest order that fixed steps can have in a scene: singular forces limit it.

A force that goes as |s|^n through s = 0 is not smooth there. A method of fixed steps does not look
for the zero, which then lies somewhere within a step. That step has an error of h^(n+2) in velocity
times time, whatever the order of the method, and one such step in each passage leaves an error of
order n + 1 (Hairer, Norsett and Wanner 1993, section II.6). A force that jumps has n = 0, one with
a kink n = 1. Measured: RK4 has 2.26 for n = 5/4, 2.57 for n = 3/2 and 3.08 for n = 2.
"""

import math
from typing import NamedTuple

from refdem.scene import Scene
from refdem.scene.element import Element
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.wedge import Wedge

JUMP = 0.0
"""Exponent of a force that jumps at a place: |s|^0."""
KINK = 1.0
"""Exponent of a force whose first derivative jumps: |s|."""
SQUARE = 2.0
"""Exponent of a force whose second derivative jumps: |s| s."""


class Singularity(NamedTuple):
    """A force that goes as |s|^exponent somewhere.

    `feature` is the scene's name for it, which `order_with` may declare.
    """

    exponent: float
    feature: str

    @property
    def order(self) -> float:
        """The largest order of fixed steps across it."""
        return self.exponent + 1.0

    @property
    def key(self) -> str:
        """The line of `refdem.toml` by which a method declares this order."""
        return f'order_with = {{ "{self.feature}" = {math.floor(self.order)} }}'


def singularities(scene: Scene) -> list[tuple[Element, Singularity]]:
    """Every element whose force is singular where a motion may pass, with its singularity."""
    singular_elements = []
    for element in scene.elements:
        singular: Singularity | None
        if isinstance(element, Contact):
            singular = _of_contact(element)
        else:
            singular = _of_other(element)
        if singular is not None:
            singular_elements.append((element, singular))
    return singular_elements


def _of_contact(law: Contact) -> Singularity:
    """The strongest singularity of a contact law.

    A dashpot's force jumps at the touch, sliding friction without a tangential spring where the
    slip velocity changes sign. A tangential spring has a kink where it starts to slip. Otherwise
    the normal force begins as overlap^n, n the exponent of the law.
    """
    if law.law == "rigid":
        return Singularity(JUMP, "contact:rigid")
    if law.damping > 0:
        return Singularity(JUMP, "contact:damping")
    if law.friction > 0 and law.tangential_stiffness == 0:
        return Singularity(JUMP, "contact:friction")
    if law.friction > 0:
        return Singularity(KINK, "contact:friction")
    return Singularity(law.exponent, "contact")


def _of_other(element: Element) -> Singularity | None:
    """The singularity of an element that is not a contact, or None.

    A spring's |s|^n sgn s has no Taylor series at s = 0 unless n is odd, nor has the drag |w| w
    where a motion turns back.
    """
    if isinstance(element, Slider):
        return Singularity(JUMP, "friction")
    if isinstance(element, Catch | Wedge):
        return Singularity(JUMP, element.kind)
    if isinstance(element, Drag):
        return Singularity(SQUARE, element.kind)
    if isinstance(element, PiecewiseField):
        return Singularity(KINK, element.kind)
    if isinstance(element, Spring) and element.stiffness != 0 and element.exponent % 2 != 1:
        return Singularity(element.exponent, "spring:exponent")
    return None
