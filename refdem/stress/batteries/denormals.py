"""Lengths so small that numbers become denormal, where binary64 has ever fewer digits."""

from refdem.core.symmetry import Symmetry
from refdem.stress.measures.frame import Frame
from refdem.stress.sweep import DAMPED_SPHERES, ELASTIC_SPHERES, Battery, Sweep, scene_words

POINTS = ("1e50", "1e100", "1e150", "1e200", "1e250", "1e290", "1e300", "1e305", "1e307", "1e308")
BASIS = "squares of lengths stay above the smallest normal number, 2e-308"

BATTERY = Battery(
    id="denormals",
    title="Denormal numbers",
    question=(
        "How small may a scene be? Squares of lengths underflow first, then the"
        " lengths themselves lose digits."
    ),
    sweeps=tuple(
        Sweep(
            name=f"tiny: {scene_words(case)}",
            case=case,
            along="1 / unit of length",
            points=POINTS,
            is_general=True,
            promised=promised,
            basis=BASIS,
            measure=Frame("rescaled", lambda instance, x: Symmetry(units=(1.0, 1.0 / x, 1.0))),
        )
        for case, promised in (
            ("harmonic-oscillator", "1e150"),
            (DAMPED_SPHERES, "1e150"),
            (ELASTIC_SPHERES, "1e150"),
            ("newtons-first-law", "1e150"),
            ("pendulum", "1e100"),
        )
    ),
)
