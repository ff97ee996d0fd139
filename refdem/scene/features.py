"""The features of a scene, derived from its content: what an engine must support to run it.

Every layer that skips work which a scene does not need reads them.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from refdem.scene.bodies import Bodies
from refdem.scene.dimension import Acceleration, Direction, Omega, Position
from refdem.scene.element import Element, Link, types_of
from refdem.scene.shapes import Point, Polyhedron, Sphere

ALIGNED = 1e-14
"""Sine of the angle between omega and J omega up to which they count as parallel: rounding alone
may have made that angle.
"""


def features(bodies: Bodies, elements: Sequence[Element]) -> frozenset[str]:
    """Names of what an engine must support: kinds and laws of elements, `rotation`, `tumbling`,
    shapes, `fixed`, `dimension:1|2|3`.
    """
    names: set[str] = set()
    for element in elements:
        names |= element.features()
    if "contact" in names:
        for shape in bodies.shapes:
            if isinstance(shape, Sphere):
                names.add("shape:sphere")
            elif isinstance(shape, Polyhedron):
                names.add("shape:polyhedron")
    if _turns(bodies, elements):
        names.add("rotation")
        if _tumbles(bodies):
            names.add("tumbling")
    if bodies.fixed.any():
        names.add("fixed")
    names.add(f"dimension:{_dimension(bodies, elements)}")
    return frozenset(names)


def _turns(bodies: Bodies, elements: Sequence[Element]) -> bool:
    """True if some body with inertia spins, or if an element can exert a torque on one.

    A torque comes from an anchor off the centre, from friction, or from contact of a polyhedron.
    """
    has_inertia = bodies.inertia.any(axis=1) & ~bodies.fixed
    can_touch = any(not isinstance(shape, Point) for shape in bodies.shapes)
    if np.any(bodies.omega[has_inertia]):
        return True
    for element in elements:
        if isinstance(element, Link):
            ends = ((element.a, element.anchor_a), (element.b, element.anchor_b))
            for body, anchor in ends:
                if body >= 0 and any(anchor) and has_inertia[body]:
                    return True
        if "contact:friction" in element.features() and can_touch:
            return True
    has_contact = any(element.kind == "contact" for element in elements)
    return has_contact and any(isinstance(shape, Polyhedron) for shape in bodies.shapes)


def _tumbles(bodies: Bodies) -> bool:
    """True if some body does not spin about a principal axis, so that its omega changes by Euler's
    equations.
    """
    from refdem.mechanics.quaternion import conjugate, rotated

    body_omega = rotated(conjugate(bodies.attitude), bodies.omega)
    momentum = bodies.inertia * body_omega
    # The gyroscopic torque omega x J omega vanishes about a principal axis.
    torque = np.linalg.norm(np.cross(body_omega, momentum), axis=1)
    product_of_norms = np.linalg.norm(body_omega, axis=1) * np.linalg.norm(momentum, axis=1)
    return bool(np.any(torque > ALIGNED * product_of_norms))


@cache
def _fields_of(kind: type[Element], *types: Any) -> tuple[str, ...]:
    """The names of the fields of a kind of element that have one of these types."""
    return tuple(name for name, hint in types_of(kind).items() if hint in types)


def _dimension(bodies: Bodies, elements: Sequence[Element]) -> int:
    """1 if all motion is along x, 2 if it is in x-y with turns about z, else 3."""
    vectors = [bodies.position, bodies.velocity]
    spins = [bodies.omega]
    for element in elements:
        for name in _fields_of(type(element), Position, Direction, Acceleration):
            vectors.append(np.asarray(getattr(element, name), float)[None, :])
        for name in _fields_of(type(element), Omega):
            spins.append(np.asarray(getattr(element, name), float)[None, :])
    stacked = np.concatenate(vectors)
    turning = np.concatenate(spins)
    if np.any(stacked[:, 2]) or np.any(turning[:, :2]) or np.any(bodies.attitude[:, 1:3]):
        return 3
    are_round = all(isinstance(shape, Point | Sphere) for shape in bodies.shapes)
    if np.any(stacked[:, 1]) or np.any(turning) or not are_round:
        return 2
    return 1
