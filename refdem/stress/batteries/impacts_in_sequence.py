"""Impacts in sequence: a cradle and a bouncing ball, harder point by point."""

from fractions import Fraction
from functools import partial

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import Battery

BASIS = (
    "flights and impulses are products and quotients that are each rounded once, and errors grow"
    " from impact to impact by the certified S"
)
SAMPLES = 32
"""Number of samples of a run: most flights of the longest sequences contain two of them."""
sweep = partial(parameter_sweep, basis=BASIS, samples=SAMPLES)


def light_between_heavy(ratio: str) -> str:
    """The masses of the balls as text: three that collide, and the unused ones."""
    return ",".join(["1", ratio, *(["1"] * 5)])


BATTERY = Battery(
    id="impacts-in-sequence",
    title="Impacts in sequence",
    question="How many impacts, and how unequal ones, may follow each other?",
    sweeps=(
        sweep(
            "cradle that loses more and more",
            case="newtons-cradle[balls=3]",
            along="restitution",
            points=("1", "3/4", "1/2", "1/4"),
            given=lambda x: {"restitution": f"{x}"},
            promised="1/4",
        ),
        sweep(
            "lighter and lighter ball between heavy ones",
            case="newtons-cradle[balls=3]",
            along="m1/m2",
            points=("1", "1e1", "1e2", "1e3"),
            given=lambda x: {"masses": light_between_heavy(f"{1 / x}")},
            promised="1e3",
        ),
        sweep(
            "cradle with a smaller and smaller gap",
            case="newtons-cradle[balls=3]",
            along="1/gap [1/m]",
            points=("4", "1e1", "1e2", "1e3", "1e4"),
            given=lambda x: {"gaps": f"1/4,{1 / x},1/4,1/4,1/4,1/4"},
            promised="1e4",
        ),
        sweep(
            "more and more balls in a line",
            case="newtons-cradle",
            along="balls",
            points=("2", "3", "4", "5", "6", "7"),
            given=lambda x: {"balls": f"{x}"},
            promised="7",
        ),
        sweep(
            "ball that bounces less and less",
            case="bouncing-ball[bounces=3]",
            along="restitution",
            points=("1", "9/10", "1/2", "1/4", "1/10", "1/100"),
            given=lambda x: {"restitution": f"{x}"},
            promised="1/100",
        ),
        sweep(
            "ball that bounces more and more often",
            case="bouncing-ball",
            along="bounces",
            points=("1", "2", "4", "8", "16", "32"),
            given=lambda x: {"bounces": f"{x}"},
            promised="32",
        ),
        sweep(
            "ball from higher and higher up",
            case="bouncing-ball[bounces=3]",
            along="height [m]",
            points=("1", "1e1", "1e2", "1e4", "1e6"),
            given=lambda x: {"height": f"{x}"},
            promised="1e6",
        ),
        sweep(
            "smaller and smaller ball from lower and lower down",
            case="bouncing-ball[bounces=3]",
            along="1/height [1/m]",
            points=("1", "1e1", "1e2", "1e4", "1e6"),
            given=lambda x: {"height": f"{1 / x}", "radius": f"{Fraction(1, 4) / x}"},
            promised="1e6",
        ),
        sweep(
            "bounces with more and more friction",
            case="bouncing-ball[bounces=3]",
            along="mu",
            points=("0", "1e-3", "1/16", "1/4", "1", "1e2", "1e6"),
            given=lambda x: {"friction": f"{x}", "velocity": "3,1", "spin": "2"},
            promised="1e6",
        ),
    ),
)
