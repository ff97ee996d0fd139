"""As many steps as the time allows, without secular drift."""

from refdem.stress.measures.many_steps import ManySteps
from refdem.stress.sweep import Battery, Sweep

POINTS = (*(str(256 * 4**k) for k in range(1, 9)), str(2**27))
BASIS = (
    "a symplectic step conserves a quadratic form, and random round-off grows"
    " as the square root of the number of steps"
)
DAMPED = "truncation error of a method that is not symplectic changes the amplitude"

BATTERY = Battery(
    id="many-steps",
    title="Many steps",
    question="For how many steps does a run conserve what the map of its method conserves?",
    sweeps=(
        Sweep(
            name="harmonic oscillator",
            case="harmonic-oscillator",
            along="steps",
            points=POINTS,
            measure=ManySteps(),
            promised=str(2**20),
            basis=BASIS,
            exempt={
                "rk4": ("4096", DAMPED),
                "gear-4": ("4096", DAMPED),
                "gear-5": ("16384", DAMPED),
                "gear-6": ("65536", DAMPED),
            },
            costly=True,
        ),
    ),
)
