"""MFiX DEM02: a bouncing sphere; the apexes R + (h - R) e^(2n) of a hard one are the limit, first
order in 1/sqrt(k).
"""

from refdem.cases.impact_benchmarks import dem_01
from refdem.cases.impact_benchmarks._floor import Bounce

MEMBER = Bounce(
    "Bouncing sphere, hard floor",
    {**dem_01.MEMBER.numbers, "stiffness": "1e6", "restitution": "0.8"},
)
