"""Chung and Ooi, test 6: a spinning sphere falls on a wall; tangential restitution -1 + 3.5 mu (1 +
e) v_n/v_st where it slides.
"""

from refdem.cases.impact_benchmarks._wall import Wall

MEMBER = Wall(
    "Spinning sphere on a wall",
    {
        "material": "aluminium-alloy",
        "radius": "0.1",
        "normal_speed": "0.2",
        "spin": "12",
        "restitution": "0.5",
        "stiffness": "1e6",
        "tangential_stiffness": "8e5",
        "friction": "0.4",
        "branch": "R",
        "cutoff": "zero_force",
    },
)
