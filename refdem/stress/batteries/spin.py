"""Fast rotation: large phases, and magnitudes that differ from those of the slow motion."""

from functools import partial

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import Battery

POINTS = ("1", "1e1", "1e2", "1e3", "1e4", "1e5", "1e6")
BASIS = "a dentist's drill rotates at 1e5 rad/s; the phase is known to u times the total angle"
LONG_STEPS = "an explicit method is unstable at steps as long as there is time for"
sweep = partial(parameter_sweep, along="spin [rad/s]", points=POINTS, promised="1e5", basis=BASIS)

BATTERY = Battery(
    id="spin",
    title="Spin",
    question="How fast may a body rotate?",
    sweeps=(
        sweep(
            "tumbling for a second",
            case="free-rigid-body",
            given=lambda x: {"omega_body": f"{x / 2},{x},{x / 3}", "duration": "1"},
            exempt={
                "gear-4-free-body": ("1e3", LONG_STEPS),
                "gear-5-free-body": ("1e4", LONG_STEPS),
                "gear-6-free-body": ("1e3", LONG_STEPS),
            },
        ),
        sweep(
            "top for a fifth of a second",
            case="heavy-top",
            given=lambda x: {"spin": f"{x}", "duration": "1/5"},
            needs_truth=False,
        ),
        sweep(
            "flying body for a second",
            case="newtons-first-law",
            given=lambda x: {"spin": f"{x}", "duration": "1"},
            exempt={
                "gear-4-free-body": ("1e4", LONG_STEPS),
                "gear-5-free-body": ("1e4", LONG_STEPS),
                "gear-6-free-body": ("1e3", LONG_STEPS),
            },
        ),
        sweep(
            "spheres that rub",
            case="two-spheres",
            given=lambda x: {"damping": "1", "friction": "1/4", "spins": f"0,0,{x},0,0,{x / 2}"},
            samples=8,
            costly=True,
        ),
    ),
)
