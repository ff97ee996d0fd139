"""Forces that MuJoCo has no element for: its callback for passive forces (mjcb_passive), called in
every stage of an integrator at that stage's time, places and velocities.
"""

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from refdem import kernels
from refdem.core.refusal import adapter_lacks
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.force_rows import NUMBERS, Row, kind_of, row_of

FAMILY = "mujoco_forces"
Places = tuple[list[int], list[int]]
"""The indices of a body's coordinates in MuJoCo's qpos, and of its velocities in qvel; along an
axis that has none the body is at rest at 0."""
LINKED = (Force, Spring, Dashpot, RotatingDashpot)
"""Elements that act on one body, or on two."""


@dataclass(frozen=True)
class Push:
    """A force on body `a`, and its opposite on body `b` unless that is the world (-1).

    `kind` and `numbers` are those of the compiled callback (`force_rows`).
    """

    a: int
    b: int
    kind: int
    numbers: Row


@contextmanager
def acting(
    mujoco: Any, scene: Scene, places: Sequence[Places], data: Any, clock: int
) -> Iterator[None]:
    """Within this context the forces of the scene act on the bodies of `data` (MjData).

    `places` has the indices of each body's coordinates; `clock` is the address of the time. MuJoCo
    has one callback for the whole process, not one a model, so that it is put back at the end.
    """
    pushes = list(_pushes(scene))
    if not pushes:
        yield
        return
    library = kernels.load(FAMILY)
    # The arrays live as long as their names: the struct only points to them.
    (struct, *_arrays) = _struct(pushes, places, data, clock)
    callback_before = mujoco.get_mjcb_passive()
    library.lib.refdem_mujoco_forces_set(struct)
    mujoco.set_mjcb_passive(_callback())
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(callback_before)
        library.lib.refdem_mujoco_forces_set(library.ffi.NULL)


@cache
def _callback() -> Any:
    """The compiled callback as MuJoCo's Python package takes a raw function."""
    library = kernels.load(FAMILY)
    address = int(library.ffi.cast("uintptr_t", library.lib.refdem_mujoco_forces_callback()))
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address)


def _struct(pushes: Sequence[Push], places: Sequence[Places], data: Any, clock: int) -> list[Any]:
    """The struct of the compiled callback, and after it the arrays that it points to."""
    ffi = kernels.load(FAMILY).ffi
    kind = np.array([push.kind for push in pushes], np.int64)
    number = np.zeros((len(pushes), NUMBERS))
    column = np.full((len(pushes), 12), -1, np.int64)
    for row, push in enumerate(pushes):
        number[row, : len(push.numbers)] = push.numbers
        column[row, :6] = _columns(places, push.a)
        column[row, 6:] = _columns(places, push.b)
    arrays = {
        "kind": ffi.from_buffer("int64_t[]", kind),
        "column": ffi.from_buffer("int64_t[]", column),
        "number": ffi.from_buffer("double[]", number),
    }
    addresses = {
        "q": data.qpos.ctypes.data,
        "v": data.qvel.ctypes.data,
        "passive_force": data.qfrc_passive.ctypes.data,
        "clock": clock,
    }
    pointers = {name: ffi.cast("double *", address) for name, address in addresses.items()}
    struct = ffi.new("refdem_mujoco_forces *", {"pushes": len(pushes), **pointers, **arrays})
    return [struct, *arrays.values()]


def _columns(places: Sequence[Places], body: int) -> list[int]:
    """The indices of a body's position (3) in MuJoCo's qpos and of its velocity (3) in qvel.

    An index is -1 for an axis along which the body cannot move, and for the world.
    """
    if body < 0:
        return [-1] * 6
    columns: list[int] = []
    for indices in places[body]:
        # Further indices are those of its rotation.
        along_axes = indices[:3]
        missing = 3 - len(along_axes)
        columns += [*along_axes, *[-1] * missing]
    return columns


def is_passive(element: Any, scene: Scene) -> bool:
    """True if the callback computes the force of the element, as no MuJoCo element has it."""
    if isinstance(element, Force | RotatingDashpot | CentralField | PiecewiseField):
        return True
    if isinstance(element, Spring):
        # MuJoCo's spring is a polynomial, linear or odd and cubic.
        return element.exponent not in (1, 3) or bool(element.quadratic)
    if isinstance(element, Dashpot):
        # A joint has a constant damping >= 0 against the world, along axes that do not turn.
        varies = bool(element.van_der_pol) or element.damping < 0
        turns = "rotation" in scene.features and bool(scene.bodies.inertia[element.a].any())
        return varies or element.b >= 0 or turns
    return False


def of_passive(scene: Scene) -> str | None:
    """None if every force of the callback acts at the centre of a body that moves along the axes of
    space, else the reason why the scene is refused.
    """
    elements = [element for element in scene.elements if is_passive(element, scene)]
    linked = [element for element in elements if isinstance(element, LINKED)]
    for link in linked:
        if any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)):
            return adapter_lacks(f"a {link.kind} by mjcb_passive off the centre of a body")
        if any(scene.bodies.fixed[end] for end in (link.a, link.b) if end >= 0):
            return adapter_lacks(f"a {link.kind} by mjcb_passive on a fixed body")
    if elements and any(element.kind in ("rod", "ball_joint") for element in scene.elements):
        return adapter_lacks(
            "a force by mjcb_passive beside rotating joints, whose coordinates are not positions"
        )
    return None


def _pushes(scene: Scene) -> Iterator[Push]:
    """The forces of the callback, element by element."""
    moving = [number for number, fixed in enumerate(scene.bodies.fixed) if not fixed]
    for element in scene.elements:
        if not is_passive(element, scene):
            continue
        if isinstance(element, LINKED):
            yield Push(element.a, element.b, kind_of(element), row_of(element))
        elif isinstance(element, CentralField | PiecewiseField):
            for number in moving:
                numbers = row_of(element, float(scene.bodies.mass[number]))
                yield Push(number, -1, kind_of(element), numbers)
