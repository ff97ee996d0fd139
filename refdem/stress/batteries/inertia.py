"""Bodies at the edge of their kind: moments of inertia that are nearly equal, flat plates,
needles.
"""

from refdem.stress.ladder import Battery, Ladder
from refdem.stress.measures.parameters import Parameters

RUNGS = tuple(f"1/{2**k}" for k in (3, 7, 10, 13, 20, 27, 33, 40, 46, 50))
"""Powers of two: moments that are rounded would be those of another body, and a needle shows it."""
BASIS = (
    "differences of moments are exact in binary64 (Sterbenz 1974), so only"
    " the rounding of the moments counts, and S measures it"
)


def ladder(name: str, along: str, measure: Parameters, promised: str = RUNGS[-3]) -> Ladder:
    """A ladder of free rigid bodies."""
    return Ladder(
        name=name,
        case="free-rigid-body",
        along=along,
        rungs=RUNGS,
        measure=measure,
        promised=promised,
        basis=BASIS,
    )


BATTERY = Battery(
    id="inertia",
    title="Inertia: nearly degenerate, flat, needle",
    question=(
        "Which bodies can be integrated? Nearly equal moments give small"
        " denominators, flat bodies and needles small numerators."
    ),
    ladders=(
        ladder(
            "two moments nearly equal",
            "J2/J1 - 1",
            Parameters(lambda x: {"inertia": f"1,{1 + x},3/2"}),
        ),
        ladder(
            "the two large moments nearly equal",
            "J3/J2 - 1",
            Parameters(lambda x: {"inertia": f"1,2,{2 * (1 + x)}"}),
        ),
        ladder(
            "all moments nearly equal",
            "J2/J1 - 1",
            Parameters(lambda x: {"inertia": f"1,{1 + x},{1 + 2 * x}"}),
        ),
        ladder("flat", "(J1 + J2 - J3)/J1", Parameters(lambda x: {"inertia": f"1,2,{3 - x}"})),
        ladder("needle", "J1/J3", Parameters(lambda x: {"inertia": f"{x},1,{1 + x / 2}"})),
    ),
)
