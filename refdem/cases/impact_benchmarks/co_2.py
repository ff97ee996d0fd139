"""Chung and Ooi, test 2: normal Hertz impact on a rigid wall; the material also as magnesium
alloy.
"""

from refdem.cases.impact_benchmarks._hertz_wall import HertzWall

MEMBER = HertzWall(
    "Sphere on a rigid wall, head-on, Hertz",
    {"material": "aluminium-alloy", "radius": "0.1", "speed": "0.2"},
)
