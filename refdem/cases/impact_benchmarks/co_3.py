"""Chung and Ooi, test 3: normal impact on a rigid wall at any restitution above 0, made by a
dashpot.
"""

from refdem.cases.impact_benchmarks._wall import Wall

MEMBER = Wall(
    "Damped sphere on a rigid wall, head-on",
    {
        "material": "aluminium-oxide",
        "radius": "0.0025",
        "speed": "3.9",
        "restitution": "0.5",
        "stiffness": "1.72e7",
        "tangential_stiffness": "0",
        "cutoff": "zero_overlap",
    },
)
