"""Starts closer and closer to the separatrix: the unstable axis of a body, the upright
pendulum.
"""

from refdem.stress.measures.parameters import Parameters
from refdem.stress.sweep import Battery, Sweep

POINTS = (*(f"1e-{k}" for k in range(1, 13)), "1e-14", "1e-16", "1e-20")
BASIS = (
    "the distance from the separatrix is a separate number in closed forms,"
    " and S gives the effect of its rounding"
)


def sweep(name: str, case: str, along: str, measure: Parameters) -> Sweep:
    """A sweep of starts, promised to 1e-12."""
    return Sweep(
        name=name,
        case=case,
        along=along,
        points=POINTS,
        measure=measure,
        promised="1e-12",
        basis=BASIS,
    )


BATTERY = Battery(
    id="separatrix",
    title="Near the separatrix and the unstable axis",
    question="How close to the separatrix may a motion start?",
    sweeps=(
        sweep(
            "off axis 2, towards axis 1",
            "intermediate-axis",
            "offset / omega",
            Parameters(lambda x: {"offset": f"{x}"}),
        ),
        sweep(
            "off axis 2, towards axis 3",
            "intermediate-axis",
            "offset / omega",
            Parameters(lambda x: {"offset": f"{x}", "direction": "3"}),
        ),
        sweep(
            "pendulum that just does not turn over",
            "pendulum",
            "1 - k",
            Parameters(lambda x: {"gravity": "1", "theta0": "0", "thetadot0": f"{2 - 2 * x}"}),
        ),
        sweep(
            "pendulum that just turns over",
            "pendulum",
            "k - 1",
            Parameters(lambda x: {"gravity": "1", "theta0": "0", "thetadot0": f"{2 + 2 * x}"}),
        ),
        sweep(
            "pendulum let go near the top",
            "pendulum-equilibria",
            "angle [rad]",
            Parameters(lambda x: {"delta": f"{x}"}),
        ),
    ),
)
