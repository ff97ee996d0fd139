"""What REBOUND's callbacks read: masses, gravity, springs, dashpots, soft contacts, piecewise
fields, drives, rods and rotors, as the compiled loop has them.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from refdem import kernels
from refdem.engines.rebound.unsupported import turning
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

FAMILY = "rebound_forces"


@dataclass(frozen=True)
class Fields:
    """`struct` is a `refdem_rebound_scene *`; `arrays` keeps alive what it points to."""

    struct: Any
    arrays: tuple[Any, ...]
    rotors: tuple[int, ...]
    rods: int
    has_forces: bool
    reads_velocity: bool


def fields_of(scene: Scene) -> Fields:
    """The fields of a scene; the places of its particles are filled in by the simulation."""
    ffi = kernels.load(FAMILY).ffi
    springs = scene.all(Spring)
    rods = scene.all(Rod)
    field_rows = _piecewise_rows(scene)
    touches = _touches(scene)
    gravity = scene.all(UniformGravity)
    dashpots = scene.all(Dashpot)
    drives = scene.all(Force)
    rotors = turning(scene)
    # The total acceleration of all uniform fields; zero without one.
    fields = [field.g for field in gravity] or [(0.0, 0.0, 0.0)]
    spring_rows = [
        (s.stiffness, s.length, s.exponent, *s.anchor_b, s.quadratic, s.cubic) for s in springs
    ]
    dashpot_rows = [(d.damping, d.van_der_pol, *d.anchor_b) for d in dashpots]
    drive_rows = [(f.amplitude, f.frequency, f.phase, *f.axis) for f in drives]
    rod_anchors = [rod.anchor_b for rod in rods]
    doubles = {
        "mass": scene.bodies.mass,
        "gravity": np.sum(fields, axis=0),
        "spring": np.array(spring_rows),
        "dashpot": np.array(dashpot_rows),
        "contact": np.array([touch.numbers for touch in touches]),
        "field": np.array(field_rows),
        "drive": np.array(drive_rows),
        "rod_anchor": np.array(rod_anchors),
        "tension": np.zeros(len(rods)),
        "inertia": scene.bodies.inertia[rotors],
    }
    integers = {
        "fixed": scene.bodies.fixed,
        "spring_end": np.array([(s.a, s.b) for s in springs]),
        "dashpot_end": np.array([(d.a, d.b) for d in dashpots]),
        "contact_end": np.array([touch.bodies for touch in touches]),
        "drive_end": np.array([(f.a, f.b) for f in drives]),
        "rod_end": np.array([(rod.a, rod.b) for rod in rods]),
    }
    counts = {
        "bodies": len(scene.bodies),
        "springs": len(springs),
        "dashpots": len(dashpots),
        "contacts": len(touches),
        "fields": len(field_rows),
        "drives": len(drives),
    }
    counts |= {"rods": len(rods), "turning": len(rotors)}
    struct = ffi.new("refdem_rebound_scene *", counts)
    kept = []
    for columns, kind, dtype in (
        (doubles, "double[]", np.float64),
        (integers, "int64_t[]", np.int64),
    ):
        for name, values in columns.items():
            view = ffi.from_buffer(
                kind, np.ascontiguousarray(values, dtype), require_writable=False
            )
            setattr(struct, name, ffi.cast(kind.replace("[]", " *"), view))
            kept.append(view)
    acts = bool(springs or dashpots or touches or field_rows or drives or rods or gravity)
    damped = any(touch.is_damped for touch in touches)
    return Fields(
        struct,
        tuple(kept),
        tuple(rotors),
        len(rods),
        acts,
        reads_velocity=bool(dashpots or rods or damped),
    )


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


def _piecewise_rows(scene: Scene) -> list[tuple[float, ...]]:
    """k1, k2 [N/m], x1, x2 [m], point (3) [m] and axis (3) of every piecewise field."""
    return [
        (field.k1, field.k2, field.x1, field.x2, *field.point, *field.axis)
        for field in scene.all(PiecewiseField)
    ]


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
