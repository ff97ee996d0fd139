"""The number of digits that a code carries: runs from two starts that differ by a small relative
amount must differ to the end.
"""

from refdem.core.symmetry import Symmetry
from refdem.stress.measures.frame import Frame
from refdem.stress.sweep import DAMPED_SPHERES, ELASTIC_SPHERES, Battery, Sweep, scene_words

POINTS = tuple(f"1e-{k}" for k in range(2, 16))
BASIS = (
    "a difference of x is resolved to a tenth while round-off, 2 c u sqrt(n)"
    " S, is below a tenth of it"
)

BATTERY = Battery(
    id="single-precision",
    title="Hidden single precision",
    question=(
        "How small a difference between two starts is resolved? A code that"
        " passes through single precision ends at 1e-6."
    ),
    sweeps=tuple(
        Sweep(
            name=f"told apart: {scene_words(case)}",
            case=case,
            along="difference of the starts",
            points=POINTS,
            is_general=True,
            promised=promised,
            basis=BASIS,
            measure=Frame(
                "rescaled",
                lambda instance, x: Symmetry(units=(1.0, 1.0 + x, 1.0)),
                is_distinguishable=True,
            ),
        )
        for case, promised in (
            ("harmonic-oscillator", "1e-10"),
            (DAMPED_SPHERES, "1e-10"),
            (ELASTIC_SPHERES, "1e-10"),
            ("pendulum", "1e-8"),
            ("two-body-orbit", "1e-8"),
        )
    ),
)
