"""Contact path without an integrator (after ON-DEM's tests): overlap, spring, clipping and a normal
that turns, all prescribed.
"""

from refdem.cases.impact_benchmarks._path import Path

NUMBERS = {
    "radius": "1",
    "partner_radius": "1",
    "overlap": "0.05",
    "speed": "1",
    "partner_spin": "-0.9",
    "stiffness": "1e7",
    "tangential_stiffness": "5e6",
    "friction": "0.5",
    "branch": "R",
}
MEMBER = Path("Prescribed path of a contact", NUMBERS)
