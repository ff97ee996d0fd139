"""Light against heavy: the motion of a light body depends on small differences of numbers of a
heavy one.
"""

from functools import partial

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import TWELVE_DECADES, Battery

BASIS = (
    "both masses enter by their sum and their product, which are rounded"
    " once; the promised range is that of grains in a drum, 1e6"
)

sweep = partial(parameter_sweep, points=TWELVE_DECADES, promised="1e6", basis=BASIS)

BATTERY = Battery(
    id="mass-ratio",
    title="Mass ratio",
    question="How different may masses be?",
    sweeps=(
        sweep(
            "second sphere heavier",
            case="two-spheres",
            along="m2/m1",
            given=lambda x: {"masses": f"1,{x}", "damping": "1"},
            samples=8,
        ),
        sweep(
            "first sphere heavier",
            case="two-spheres",
            along="m1/m2",
            given=lambda x: {"masses": f"{x},1", "damping": "1"},
            samples=8,
        ),
        sweep(
            "one point of a cluster heavier",
            case="rigid-cluster",
            along="m4/m1",
            given=lambda x: {"masses": f"1,2,1,{x}"},
        ),
        sweep(
            "one point of a cluster lighter",
            case="rigid-cluster",
            along="m1/m4",
            given=lambda x: {"masses": f"1,2,1,{1 / x}"},
        ),
        sweep(
            "light weight on a heavy pendulum's string",
            case="pendulum-wheel-mass",
            along="m/M",
            given=lambda x: {"counter_mass": f"{1 / x}", "duration": "1/2"},
            samples=8,
        ),
    ),
)
