"""MFiX DEM03: two stacked spheres of unlike density, squeezed between walls: a linear system of two
degrees of freedom.
"""

from refdem.cases.impact_benchmarks._stack import Stack

MEMBER = Stack(
    "Two spheres squeezed between walls",
    {
        "radius": "0.0005",
        "density": "20000",
        "partner_density": "10000",
        "height": "0.0018",
        "gravity": "9.80665",
        "stiffness": "1000",
        "restitution": "1",
    },
)
