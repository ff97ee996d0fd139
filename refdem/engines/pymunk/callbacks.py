"""Compiled callbacks that Chipmunk calls in every step (`kernels/chipmunk.c`): forces on a body
that depend on time, position or velocity, nonlinear springs, soft contacts, and friction that
depends on the speed.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import ffi as engine_ffi
from pymunk._chipmunk_cffi import lib as engine_lib

from refdem import kernels
from refdem.engines.pymunk.unsupported import fading
from refdem.scene import Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.force_rows import (
    NUMBERS,
    PIECEWISE,
    SPRING,
    Field,
    Push,
    Row,
    kind_of,
    row_of,
)

FAMILY = "chipmunk"
CONTACT = PIECEWISE + 1
"""The kind of a soft contact, beyond those of forces on one body."""
FRICTION = PIECEWISE + 2
"""The kind of a friction that depends on the speed."""
CENTRE = (0.0, 0.0)
FUNCTIONS = {
    "timestamp": "cpSpaceGetTimestamp",
    "position": "cpBodyGetPosition",
    "velocity": "cpBodyGetVelocity",
    "set_force": "cpBodySetForce",
    "update_velocity": "cpBodyUpdateVelocity",
    "body_a": "cpConstraintGetBodyA",
    "body_b": "cpConstraintGetBodyB",
    "set_damping": "cpDampedSpringSetDamping",
    "set_limit": "cpConstraintSetMaxForce",
}
"""Chipmunk's functions that the laws call, by the names of the compiled struct."""


@dataclass(frozen=True)
class Law:
    """A law of a body or of a joint: its kind, and its numbers as the compiled code reads them."""

    owner: pymunk.Body | pymunk.Constraint
    kind: int
    numbers: Row


def bent(joint: pymunk.Constraint, link: Spring) -> Law:
    """The law of a spring that is not linear.

    Pull = k |s|^n sgn(s) + a s^2 + b s^3 in the stretch s = distance - length.
    """
    return Law(joint, SPRING, row_of(link))


def fading_friction(joint: pymunk.Constraint, link: Slider) -> Law:
    """The law of a dry friction whose limit depends on the speed.

    The limit is updated before each step, for the current speed of the bodies.
    """
    power = 1.0
    if link.law == "stribeck":
        power = 2.0
    numbers = (link.normal_force, link.mu0, link.mu1, link.lambda0, link.lambda1, power)
    return Law(joint, FRICTION, (*numbers, *link.axis[:2]))


def soft_contacts(scene: Scene, bodies: Sequence[pymunk.Body]) -> Iterator[Law]:
    """A one-sided spring for every pair of spheres, where the contact law has a stiffness.

    F = k d^n with the overlap d = R_a + R_b - distance; the joint's own damper adds c dd/dt. The
    damper acts at any distance, so that it is switched before each step: it is on while the discs
    overlap, and for `zero_force` only while the total force is repulsive.
    """
    for law in scene.all(Contact):
        if law.law == "rigid":
            continue
        balls = [
            (body, shape.radius)
            for body, shape in zip(bodies, scene.bodies.shape, strict=True)
            if isinstance(shape, Sphere)
        ]
        for (a, radius_a), (b, radius_b) in combinations(balls, 2):
            if a.body_type == b.body_type == pymunk.Body.STATIC:
                continue
            touching = radius_a + radius_b
            joint = pymunk.DampedSpring(a, b, CENTRE, CENTRE, touching, law.stiffness, 0.0)
            may_pull = float(law.cutoff == "zero_overlap")
            numbers = (touching, law.stiffness, law.exponent, law.damping, may_pull)
            yield Law(joint, CONTACT, numbers)


def pushes(scene: Scene, bodies: Sequence[pymunk.Body]) -> Iterator[Law]:
    """The external forces on every moving body: drives, fields, and dashpots that `Space.damping`
    cannot express.

    Chipmunk evaluates them where it updates a velocity, after it has moved the body. The force is
    therefore that at the new position and the end of the step, with the velocity at its beginning:
    v_(n+1) = v_n + h F(t_(n+1), x_(n+1), v_n)/m.
    """
    for number, body in enumerate(bodies):
        if scene.bodies.fixed[number]:
            continue
        mass = float(scene.bodies.mass[number])
        for element in _pushing(scene, number):
            yield Law(body, kind_of(element), row_of(element, mass))


def _pushing(scene: Scene, number: int) -> Iterator[Field | Push]:
    """The elements that exert external forces on that body."""
    for element in scene.elements:
        if isinstance(element, CentralField | PiecewiseField):
            yield element
        elif isinstance(element, Dashpot) and fading(scene) is not None:
            continue
        elif isinstance(element, Force | Dashpot | RotatingDashpot) and element.a == number:
            yield element


@contextmanager
def acting(space: pymunk.Space, laws: Sequence[Law], start: float, step: float) -> Iterator[None]:
    """Within this context Chipmunk calls these laws, from time `start` [s] with a step [s]."""
    if not laws:
        yield
        return
    library = kernels.load(FAMILY)
    # The arrays live as long as their names: the struct only points to them.
    (struct, *_arrays) = _struct(space, sorted(laws, key=_address_of), start, step)
    for law in laws:
        _ask(law)
    library.lib.refdem_chipmunk_set(struct)
    try:
        yield
    finally:
        library.lib.refdem_chipmunk_set(library.ffi.NULL)


def _ask(law: Law) -> None:
    """Tells Chipmunk which compiled functions to call for the owner of a law."""
    if isinstance(law.owner, pymunk.Body):
        pushed = _compiled("cpBodyVelocityFunc", "refdem_chipmunk_push")
        engine_lib.cpBodySetVelocityUpdateFunc(law.owner._body, pushed)
        return
    if law.kind != FRICTION:
        spring = _compiled("cpDampedSpringForceFunc", "refdem_chipmunk_spring")
        engine_lib.cpDampedSpringSetSpringForceFunc(law.owner._constraint, spring)
    if law.kind != SPRING:
        prepared = _compiled("cpConstraintPreSolveFunc", "refdem_chipmunk_prepare")
        engine_lib.cpConstraintSetPreSolveFunc(law.owner._constraint, prepared)


def _compiled(kind: str, name: str) -> Any:
    """A compiled function of ours as a function of Chipmunk's type."""
    library = kernels.load(FAMILY)
    function = library.ffi.addressof(library.lib, name)
    return engine_ffi.cast(kind, int(library.ffi.cast("uintptr_t", function)))


def _struct(space: pymunk.Space, laws: Sequence[Law], start: float, step: float) -> list[Any]:
    """The struct of the compiled functions, and after it the arrays that it points to."""
    ffi = kernels.load(FAMILY).ffi
    kind = np.array([law.kind for law in laws], np.int64)
    number = np.zeros((len(laws), NUMBERS))
    for row, law in enumerate(laws):
        number[row, : len(law.numbers)] = law.numbers
    arrays = {
        "owner": ffi.new("void *[]", [ffi.cast("void *", _address_of(law)) for law in laws]),
        "kind": ffi.from_buffer("int64_t[]", kind),
        "number": ffi.from_buffer("double[]", number),
    }
    struct = ffi.new("refdem_chipmunk_laws *", {"laws": len(laws), **arrays})
    struct.space = ffi.cast("void *", number_of(space._space))
    struct.start = start
    struct.step = step
    set_functions(struct, FUNCTIONS)
    return [struct, *arrays.values()]


def _address_of(law: Law) -> int:
    """The address of the owner of a law in Chipmunk."""
    if isinstance(law.owner, pymunk.Body):
        return number_of(law.owner._body)
    return number_of(law.owner._constraint)


def number_of(pointer: Any) -> int:
    """The address that a pointer of Chipmunk holds."""
    return int(engine_ffi.cast("uintptr_t", pointer))


def set_functions(struct: Any, functions: dict[str, str]) -> None:
    """Sets fields of a compiled struct to the addresses of functions of Chipmunk."""
    ffi = kernels.load(FAMILY).ffi
    for field, function in functions.items():
        address = number_of(engine_ffi.addressof(engine_lib, function))
        setattr(struct, field, ffi.cast(ffi.typeof(getattr(struct, field)), address))
