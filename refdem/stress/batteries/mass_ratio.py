"""Light against heavy: what a light body does depends on small differences of a heavy one's
numbers.
"""

from refdem.stress.ladder import Battery, Ladder
from refdem.stress.measures.parameters import Parameters

RUNGS = ("1", "1e1", "1e2", "1e4", "1e6", "1e9", "1e12")
BASIS = (
    "both masses enter by their sum and their product, which are rounded"
    " once; the promised range is that of grains in a drum, 1e6"
)


def ladder(name: str, case: str, along: str, measure: Parameters) -> Ladder:
    """A ladder of mass ratios, promised to 1e6."""
    return Ladder(
        name=name, case=case, along=along, rungs=RUNGS, measure=measure, promised="1e6", basis=BASIS
    )


BATTERY = Battery(
    id="mass-ratio",
    title="Mass ratio",
    question="How different may masses be?",
    ladders=(
        ladder(
            "second sphere heavier",
            "two-spheres",
            "m2/m1",
            Parameters(lambda x: {"masses": f"1,{x}"}, samples=8),
        ),
        ladder(
            "first sphere heavier",
            "two-spheres",
            "m1/m2",
            Parameters(lambda x: {"masses": f"{x},1"}, samples=8),
        ),
        ladder(
            "one point of a cluster heavier",
            "rigid-cluster",
            "m4/m1",
            Parameters(lambda x: {"masses": f"1,2,1,{x}"}),
        ),
        ladder(
            "one point of a cluster lighter",
            "rigid-cluster",
            "m1/m4",
            Parameters(lambda x: {"masses": f"1,2,1,{1 / x}"}),
        ),
        ladder(
            "light weight on a heavy pendulum's string",
            "pendulum-wheel-mass",
            "m/M",
            Parameters(lambda x: {"counter_mass": f"{1 / x}", "duration": "1/2"}, samples=8),
        ),
    ),
)
