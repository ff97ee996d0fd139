"""Chung and Ooi, test 4: oblique impact at constant speed, damped, linear law; experiments of
Kharaz et al. scatter by 5 to 10 %.
"""

from refdem.cases.impact_benchmarks._wall import Wall

MEMBER = Wall(
    "Oblique impact on a wall at constant speed",
    {
        "material": "aluminium-oxide",
        "radius": "0.0025",
        "speed": "3.9",
        "angle": "1/2",
        "restitution": "0.98",
        "stiffness": "1.72e7",
        "tangential_stiffness": "1.48e7",
        "friction": "0.092",
        "branch": "R",
        "cutoff": "zero_force",
    },
)
