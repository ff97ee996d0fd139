"""MFiX DEM01: a sphere falls on a soft floor, damped; every phase in closed form."""

from refdem.cases.impact_benchmarks._floor import Bounce

MEMBER = Bounce(
    "Falling sphere, soft floor",
    {
        "radius": "0.1",
        "density": "2600",
        "height": "0.5",
        "gravity": "9.80665",
        "stiffness": "1e4",
        "restitution": "0.9",
    },
)
