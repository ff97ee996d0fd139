"""Three spheres of unequal size, after Vyas et al. 2025: a slip of half-step velocities across
full-step normals goes wrong.
"""

from refdem.cases.impact_benchmarks._squeeze import Squeeze

MEMBER = Squeeze(
    "Small sphere between two large ones",
    {
        "radius": "0.01",
        "partner_radius": "0.03",
        "density": "2500",
        "spin": "30",
        "partner_spin": "0",
        "speed": "0.2",
        "angle": "1/4",
        "restitution": "0.9",
        "stiffness": "1e5",
        "tangential_stiffness": "2e4",
        "friction": "0.5",
        "branch": "R-d/2",
        "cutoff": "zero_force",
    },
)
