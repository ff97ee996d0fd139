"""Bodies with extreme moments of inertia: nearly equal ones, flat plates, needles."""

from functools import partial

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import Battery

POINTS = tuple(f"1/{2**k}" for k in (3, 7, 10, 13, 20, 27, 33, 40, 46, 50))
"""Powers of two, so that the moments are exact: rounded moments would be those of another body,
which a needle would show.
"""
BASIS = (
    "differences of moments are exact in binary64 (Sterbenz 1974), so only"
    " the rounding of the moments counts, and S measures it"
)
sweep = partial(
    parameter_sweep, points=POINTS, promised=POINTS[-3], case="free-rigid-body", basis=BASIS
)

BATTERY = Battery(
    id="inertia",
    title="Inertia: nearly degenerate, flat, needle",
    question=(
        "Which bodies can be integrated? Nearly equal moments give small"
        " denominators, flat bodies and needles small numerators."
    ),
    sweeps=(
        sweep(
            "two moments nearly equal",
            along="J2/J1 - 1",
            given=lambda x: {"inertia": f"1,{1 + x},3/2"},
        ),
        sweep(
            "the two large moments nearly equal",
            along="J3/J2 - 1",
            given=lambda x: {"inertia": f"1,2,{2 * (1 + x)}"},
        ),
        sweep(
            "all moments nearly equal",
            along="J2/J1 - 1",
            given=lambda x: {"inertia": f"1,{1 + x},{1 + 2 * x}"},
        ),
        sweep("flat", along="(J1 + J2 - J3)/J1", given=lambda x: {"inertia": f"1,2,{3 - x}"}),
        sweep("needle", along="J1/J3", given=lambda x: {"inertia": f"{x},1,{1 + x / 2}"}),
    ),
)
