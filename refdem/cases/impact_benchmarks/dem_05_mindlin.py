"""MFiX DEM05, Hertz's law with a tangential spring of Mindlin's stiffness: sticking, slipping back
and gross sliding.
"""

from refdem.cases.impact_benchmarks import dem_05_hertz
from refdem.cases.impact_benchmarks._mindlin_wall import MindlinWall

MEMBER = MindlinWall(
    "Oblique impact, Hertz and Mindlin", {**dem_05_hertz.MEMBER.numbers, "angle": "1/4"}
)
