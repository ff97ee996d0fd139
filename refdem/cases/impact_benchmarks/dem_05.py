"""MFiX DEM05, linear law: oblique impact without damping; rolling, sticking and gross sliding as
the angle grows.
"""

from refdem.cases.impact_benchmarks import co_4
from refdem.cases.impact_benchmarks._wall import Wall

MEMBER = Wall(
    "Oblique impact, linear law, undamped",
    {**co_4.MEMBER.numbers, "restitution": "1", "angle": "0.25"},
)
