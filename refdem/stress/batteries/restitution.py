"""Collisions without loss of energy, and with a complete loss."""

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import Battery

LESS = ("1", "0.9999", "0.9", "0.5", "0.2", "0.14")
NEARER = ("1e-1", "1e-3", "1e-6", "1e-12", "0")
CRITICAL = ("1/2", "1e-1", "1e-2", "1e-3", "1e-4", "1e-6")
HARDER = ("1", "1e1", "30", "1e2", "1e4", "1e6")
BASIS = (
    "a linear contact ends at a known phase, which is real for every loss below critical damping"
)

BATTERY = Battery(
    id="restitution",
    title="Restitution from 1 to 0",
    question="How little and how much energy may a collision lose?",
    sweeps=(
        parameter_sweep(
            name="losing more and more, force that does not pull",
            case="impact-benchmarks",
            along="restitution",
            points=LESS,
            promised="0.2",
            basis=BASIS,
            given=lambda x: {"member": "co-4", "restitution": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="losing less and less",
            case="two-spheres",
            along="damping [kg/s]",
            points=NEARER,
            promised="0",
            basis=BASIS,
            given=lambda x: {"damping": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="losing nearly all, to the end of the overlap",
            case="two-spheres",
            along="1 - damping / critical",
            points=CRITICAL,
            promised="1e-4",
            basis=BASIS,
            given=lambda x: {"damping": f"{16 * (1 - x)}"},
            samples=8,
        ),
        parameter_sweep(
            name="through critical damping and beyond, force that does not pull",
            case="two-spheres",
            along="damping [kg/s]",
            points=HARDER,
            given=lambda x: {"damping": f"{x}", "cutoff": "zero_force"},
            samples=8,
        ),
    ),
)
