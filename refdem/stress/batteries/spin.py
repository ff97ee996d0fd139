"""Fast rotation: phases that grow large, sizes that differ from those of the slow motion."""

from refdem.stress.ladder import Battery, Ladder
from refdem.stress.measures.parameters import Parameters

RUNGS = ("1", "1e1", "1e2", "1e3", "1e4", "1e5", "1e6")
BASIS = "a dentist's drill rotates at 1e5 rad/s; the phase is known to u times the total angle"


def ladder(name: str, case: str, measure: Parameters, *, costly: bool = False) -> Ladder:
    """A ladder of spins, promised to 1e5."""
    return Ladder(
        name=name,
        case=case,
        along="spin [rad/s]",
        rungs=RUNGS,
        measure=measure,
        promised="1e5",
        basis=BASIS,
        costly=costly,
    )


BATTERY = Battery(
    id="spin",
    title="Spin",
    question="How fast may a body rotate?",
    ladders=(
        ladder(
            "tumbling for a second",
            "free-rigid-body",
            Parameters(lambda x: {"omega_body": f"{x / 2},{x},{x / 3}", "duration": "1"}),
        ),
        ladder(
            "top for a fifth of a second",
            "heavy-top",
            Parameters(lambda x: {"spin": f"{x}", "duration": "1/5"}, needs_truth=False),
        ),
        ladder(
            "flying body for a second",
            "newtons-first-law",
            Parameters(lambda x: {"spin": f"{x}", "duration": "1"}),
        ),
        ladder(
            "spheres that rub",
            "two-spheres",
            Parameters(lambda x: {"friction": "1/4", "spins": f"0,0,{x},0,0,{x / 2}"}, samples=8),
            costly=True,
        ),
    ),
)
