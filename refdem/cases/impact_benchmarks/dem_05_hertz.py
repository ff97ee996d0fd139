"""MFiX DEM05, Hertz's law with Coulomb friction (no tangential spring): oblique impact, gross
sliding or until it rolls.
"""

from refdem.cases.impact_benchmarks._hertz_wall import HertzWall

MEMBER = HertzWall(
    "Oblique impact, Hertz",
    {
        "material": "aluminium-oxide",
        "radius": "0.0025",
        "speed": "3.9",
        "angle": "1/2",
        "friction": "0.092",
    },
)
