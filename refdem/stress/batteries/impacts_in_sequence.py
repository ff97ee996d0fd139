"""Impacts in sequence: a cradle and a bouncing ball, harder rung by rung."""

from fractions import Fraction

from refdem.stress.ladder import Battery, Ladder
from refdem.stress.measures.parameters import Parameters

BASIS = (
    "flights and impulses are products and quotients that are each rounded once, and errors grow"
    " from impact to impact by the certified S"
)
SAMPLES = 32
"""Samples of a run, of which two lie in most flights of the longest sequences."""


def light_between_heavy(ratio: str) -> str:
    """The masses of three balls, and of those that do not count."""
    return ",".join(["1", ratio, *(["1"] * 5)])


BATTERY = Battery(
    id="impacts-in-sequence",
    title="Impacts in sequence",
    question="How many impacts, and how unequal ones, may follow each other?",
    ladders=(
        Ladder(
            name="cradle that loses more and more",
            case="newtons-cradle[balls=3]",
            along="restitution",
            rungs=("1", "3/4", "1/2", "1/4"),
            measure=Parameters(lambda x: {"restitution": f"{x}"}, SAMPLES),
            promised="1/4",
            basis=BASIS,
        ),
        Ladder(
            name="lighter and lighter ball between heavy ones",
            case="newtons-cradle[balls=3]",
            along="m1/m2",
            rungs=("1", "1e1", "1e2", "1e3"),
            measure=Parameters(lambda x: {"masses": light_between_heavy(f"{1 / x}")}, SAMPLES),
            promised="1e3",
            basis=BASIS,
        ),
        Ladder(
            name="cradle with a smaller and smaller gap",
            case="newtons-cradle[balls=3]",
            along="1/gap [1/m]",
            rungs=("4", "1e1", "1e2", "1e3", "1e4"),
            measure=Parameters(lambda x: {"gaps": f"1/4,{1 / x},1/4,1/4,1/4,1/4"}, SAMPLES),
            promised="1e4",
            basis=BASIS,
        ),
        Ladder(
            name="more and more balls in a line",
            case="newtons-cradle",
            along="balls",
            rungs=("2", "3", "4", "5", "6", "7"),
            measure=Parameters(lambda x: {"balls": f"{x}"}, SAMPLES),
            promised="7",
            basis=BASIS,
        ),
        Ladder(
            name="ball that bounces less and less",
            case="bouncing-ball[bounces=3]",
            along="restitution",
            rungs=("1", "9/10", "1/2", "1/4", "1/10", "1/100"),
            measure=Parameters(lambda x: {"restitution": f"{x}"}, SAMPLES),
            promised="1/100",
            basis=BASIS,
        ),
        Ladder(
            name="ball that bounces more and more often",
            case="bouncing-ball",
            along="bounces",
            rungs=("1", "2", "4", "8", "16", "32"),
            measure=Parameters(lambda x: {"bounces": f"{x}"}, SAMPLES),
            promised="32",
            basis=BASIS,
        ),
        Ladder(
            name="ball from higher and higher up",
            case="bouncing-ball[bounces=3]",
            along="height [m]",
            rungs=("1", "1e1", "1e2", "1e4", "1e6"),
            measure=Parameters(lambda x: {"height": f"{x}"}, SAMPLES),
            promised="1e6",
            basis=BASIS,
        ),
        Ladder(
            name="smaller and smaller ball from lower and lower down",
            case="bouncing-ball[bounces=3]",
            along="1/height [1/m]",
            rungs=("1", "1e1", "1e2", "1e4", "1e6"),
            measure=Parameters(
                lambda x: {"height": f"{1 / x}", "radius": f"{Fraction(1, 4) / x}"}, SAMPLES
            ),
            promised="1e6",
            basis=BASIS,
        ),
        Ladder(
            name="bounces with more and more friction",
            case="bouncing-ball[bounces=3]",
            along="mu",
            rungs=("0", "1e-3", "1/16", "1/4", "1", "1e2", "1e6"),
            measure=Parameters(
                lambda x: {"friction": f"{x}", "velocity": "3,1", "spin": "2"}, SAMPLES
            ),
            promised="1e6",
            basis=BASIS,
        ),
    ),
)
