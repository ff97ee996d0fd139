"""What REBOUND's callbacks read: masses, gravity, springs, dashpots, soft contacts, piecewise
fields, drives, rods and rotors, as the compiled loop has them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from refdem import kernels
from refdem.engines.rebound.unsupported import turning
from refdem.scene import Scene, Sphere
from refdem.scene.element import Link
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.force_rows import Field, Push, Row, row_of

FAMILY = "rebound_forces"


@dataclass(frozen=True)
class Fields:
    """The forces of a scene for the callbacks.

    `struct` is a `refdem_rebound_scene *`, and `arrays` keeps alive what it points to; `rotors` are
    the numbers of the bodies that turn, `rods` is how many there are.
    """

    struct: Any
    arrays: tuple[Any, ...]
    rotors: tuple[int, ...]
    rods: int
    has_forces: bool
    reads_velocity: bool


@dataclass(frozen=True)
class Touch:
    """Two spheres that may press each other, and the law as a row of the callbacks: sum of the
    radii [m], stiffness, exponent, damping [N s/m], 1 if the force may pull.
    """

    bodies: tuple[int, int]
    numbers: tuple[float, float, float, float, float]

    @property
    def is_damped(self) -> bool:
        """True if the force depends on the velocities."""
        return self.numbers[3] != 0


def fields_of(scene: Scene) -> Fields:
    """The fields of a scene; the places of its particles are filled in by the simulation."""
    rods = scene.all(Rod)
    touches = _touches(scene)
    rotors = turning(scene)
    dashpots = _dashpots(scene)
    counts = {
        "bodies": len(scene.bodies),
        "springs": len(scene.all(Spring)),
        "dashpots": len(dashpots),
        "contacts": len(touches),
        "fields": len(scene.all(PiecewiseField)),
        "drives": len(scene.all(Force)),
        "rods": len(rods),
        "turning": len(rotors),
    }
    struct = kernels.load(FAMILY).ffi.new("refdem_rebound_scene *", counts)
    arrays = _set_arrays(struct, _numbers(scene, touches, rotors), "double", np.float64)
    arrays += _set_arrays(struct, _ends(scene, touches), "int64_t", np.int64)
    acting = ("springs", "dashpots", "contacts", "fields", "drives", "rods")
    has_elements = any(counts[name] > 0 for name in acting)
    has_gravity = bool(scene.all(UniformGravity))
    is_damped = any(touch.is_damped for touch in touches)
    return Fields(
        struct,
        tuple(arrays),
        tuple(rotors),
        rods=len(rods),
        has_forces=has_gravity or has_elements,
        reads_velocity=bool(dashpots or rods or is_damped),
    )


def _numbers(scene: Scene, touches: list[Touch], rotors: Sequence[int]) -> dict[str, Any]:
    """The arrays of doubles of the callbacks' struct, by its fields: a row an element."""
    # The total acceleration of all uniform fields; zero without one.
    gravity = [field.g for field in scene.all(UniformGravity)]
    if not gravity:
        gravity = [(0.0, 0.0, 0.0)]
    rods = scene.all(Rod)
    return {
        "mass": scene.bodies.mass,
        "gravity": np.sum(gravity, axis=0),
        "spring": _rows(scene, Spring),
        "dashpot": [row_of(dashpot) for dashpot in _dashpots(scene)],
        "contact": [touch.numbers for touch in touches],
        "field": _rows(scene, PiecewiseField),
        "drive": _rows(scene, Force),
        "rod_anchor": [rod.anchor_b for rod in rods],
        "tension": np.zeros(len(rods)),
        "inertia": scene.bodies.inertia[rotors],
    }


def _ends(scene: Scene, touches: list[Touch]) -> dict[str, Any]:
    """The arrays of integers of the callbacks' struct: what is fixed, and the bodies at both ends
    of every element, -1 for the world.
    """
    links: dict[str, Sequence[Link]] = {
        "spring_end": scene.all(Spring),
        "dashpot_end": _dashpots(scene),
        "drive_end": scene.all(Force),
        "rod_end": scene.all(Rod),
    }
    ends: dict[str, Any] = {"fixed": scene.bodies.fixed}
    for name, elements in links.items():
        ends[name] = [(link.a, link.b) for link in elements]
    ends["contact_end"] = [touch.bodies for touch in touches]
    return ends


def _set_arrays(struct: Any, columns: dict[str, Any], kind: str, dtype: Any) -> list[Any]:
    """Points the fields of `struct` at arrays of the C type `kind`; returns views that keep them
    alive.
    """
    ffi = kernels.load(FAMILY).ffi
    views = []
    for name, values in columns.items():
        array = np.ascontiguousarray(values, dtype)
        view = ffi.from_buffer(f"{kind}[]", array, require_writable=False)
        setattr(struct, name, ffi.cast(f"{kind} *", view))
        views.append(view)
    return views


def _rows(scene: Scene, kind: type[Field | Push]) -> list[Row]:
    """The numbers of every element of that kind."""
    return [row_of(element) for element in scene.all(kind)]


def _dashpots(scene: Scene) -> list[Dashpot | RotatingDashpot]:
    """The dashpots of fluids at rest, then those of fluids that turn."""
    return [*scene.all(Dashpot), *scene.all(RotatingDashpot)]


def _touches(scene: Scene) -> list[Touch]:
    """Every pair of spheres under a contact law that has a stiffness."""
    touches = []
    for law in scene.all(Contact):
        if law.law == "rigid":
            continue
        may_pull = float(law.cutoff == "zero_overlap")
        balls = [
            (number, shape.radius)
            for number, shape in enumerate(scene.bodies.shape)
            if isinstance(shape, Sphere)
        ]
        for (a, radius_a), (b, radius_b) in combinations(balls, 2):
            numbers = (radius_a + radius_b, law.stiffness, law.exponent, law.damping, may_pull)
            touches.append(Touch(bodies=(a, b), numbers=numbers))
    return touches
