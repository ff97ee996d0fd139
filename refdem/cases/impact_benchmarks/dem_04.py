"""MFiX DEM04: a sphere slides until it rolls, u/u0 = 5/7 at mu g t/u0 = 2/7, whatever mu, R and
m.
"""

from refdem.cases.impact_benchmarks._slide import Slide

MEMBER = Slide(
    "Slide to roll",
    {
        "radius": "0.05",
        "density": "2600",
        "speed": "1",
        "gravity": "9.80665",
        "friction": "0.2",
        "stiffness": "1e4",
    },
)
