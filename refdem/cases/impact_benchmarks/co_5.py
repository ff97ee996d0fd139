"""Chung and Ooi, test 5: oblique impact at constant normal speed of a grain of dust; psi' = psi - 7
where it slides.
"""

from refdem.cases.impact_benchmarks._wall import Wall

MEMBER = Wall(
    "Oblique impact at constant normal speed",
    {
        "material": "steel",
        "radius": "1e-5",
        "normal_speed": "5",
        "psi": "8",
        "restitution": "1",
        "stiffness": "1e6",
        "tangential_stiffness": "8e5",
        "friction": "0.3",
        "branch": "R",
    },
)
