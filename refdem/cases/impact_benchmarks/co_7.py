"""Chung and Ooi, test 7: equal spheres that spin like gears, each against the other: nothing slips,
nothing tangential happens, exactly.
"""

from refdem.cases.impact_benchmarks._spinning_pair import SpinningPair

MEMBER = SpinningPair(
    "Equal spheres that spin like gears",
    {
        "radius": "0.1",
        "density": "2699",
        "spin": "12",
        "partner_radius": "0.1",
        "partner_density": "2699",
        "partner_spin": "-12",
        "speed": "0.2",
        "restitution": "0.5",
        "stiffness": "1e6",
        "tangential_stiffness": "8e5",
        "friction": "0.4",
        "branch": "R",
        "cutoff": "zero_overlap",
    },
)
