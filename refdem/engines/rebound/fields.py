"""What REBOUND's callbacks read: masses, gravity, springs, dashpots, drives, rods and rotors, as
the compiled loop has them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem import kernels
from refdem.engines.rebound.unsupported import turning
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
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
        "drive": np.array(drive_rows),
        "rod_anchor": np.array(rod_anchors),
        "tension": np.zeros(len(rods)),
        "inertia": scene.bodies.inertia[rotors],
    }
    integers = {
        "fixed": scene.bodies.fixed,
        "spring_end": np.array([(s.a, s.b) for s in springs]),
        "dashpot_end": np.array([(d.a, d.b) for d in dashpots]),
        "drive_end": np.array([(f.a, f.b) for f in drives]),
        "rod_end": np.array([(rod.a, rod.b) for rod in rods]),
    }
    counts = {
        "bodies": len(scene.bodies),
        "springs": len(springs),
        "dashpots": len(dashpots),
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
    acts = bool(springs or dashpots or drives or rods or gravity)
    return Fields(
        struct, tuple(kept), tuple(rotors), len(rods), acts, reads_velocity=bool(dashpots or rods)
    )
