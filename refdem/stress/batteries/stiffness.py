"""Stiffness over twelve decades, to find built-in scales of force, length or time."""

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import TWELVE_DECADES, Battery

HARDER = TWELVE_DECADES[2:]
SOFTER = ("1", "1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12")
STIFF = ("1", "1e1", "1e2", "1e3", "1e4", "1e5", "1e6", "1e8")
BASIS = "the stiffness only sets the unit of time, and steps are taken in that unit"

BATTERY = Battery(
    id="stiffness",
    title="Stiffness over twelve decades",
    question="How stiff and how soft may a spring or a contact be?",
    sweeps=(
        parameter_sweep(
            name="harder spheres",
            case="two-spheres",
            along="stiffness [N/m]",
            points=HARDER,
            promised="1e12",
            basis=BASIS,
            given=lambda x: {"stiffness": f"{x}", "damping": "1"},
            samples=8,
        ),
        parameter_sweep(
            name="harder Hertzian spheres",
            case="hertz-spheres",
            along="stiffness [N/m^1.5]",
            points=HARDER,
            promised="1e12",
            basis=BASIS,
            given=lambda x: {"stiffness": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="harder springs",
            case="harmonic-oscillator",
            along="stiffness [N/m]",
            points=HARDER,
            promised="1e12",
            basis=BASIS,
            given=lambda x: {"stiffness": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="softer springs",
            case="harmonic-oscillator",
            along="stiffness [N/m]",
            points=SOFTER,
            promised="1e-12",
            basis=BASIS,
            given=lambda x: {"stiffness": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="fast and slow together",
            case="viscous-oscillator",
            along="damping rate / frequency",
            points=STIFF,
            promised="1e8",
            basis="both rates have closed forms, the slow one as omega^2 over the fast one",
            given=lambda x: {"delta": f"{x}", "duration": "4"},
            samples=8,
            costly=True,
        ),
    ),
)
