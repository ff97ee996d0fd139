"""Impacts of rigid spheres, with every parameter of the law and of the bodies at its extremes."""

from functools import partial

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import SIX_DECADES, TWELVE_DECADES, Battery

BASIS = "an impulse is a product and a quotient of numbers that are each rounded once"
sweep = partial(parameter_sweep, case="hard-spheres", basis=BASIS, samples=8)

BATTERY = Battery(
    id="impacts",
    title="Impacts",
    question="Which restitutions, frictions, speeds, masses and spins may an impact have?",
    sweeps=(
        sweep(
            "impact that loses more and more",
            "restitution",
            ("1", "9/10", "1/2", "1/10", "1e-3", "1e-6", "0"),
            lambda x: {"restitution": f"{x}"},
            "0",
        ),
        sweep(
            "impact with more and more friction",
            "mu",
            ("0", "1e-3", "1/16", "1/4", "1", "1e2", "1e6"),
            lambda x: {"friction": f"{x}", "spins": "0,0,1,0,0,2"},
            "1e6",
        ),
        sweep(
            "slower and slower impact",
            "1/speed [s/m]",
            SIX_DECADES,
            lambda x: {"closing_speed": f"{1 / x}"},
            "1e6",
        ),
        sweep(
            "faster and faster impact",
            "speed [m/s]",
            SIX_DECADES,
            lambda x: {"closing_speed": f"{x}"},
            "1e6",
        ),
        sweep(
            "impact on a heavier and heavier sphere",
            "m2/m1",
            TWELVE_DECADES,
            lambda x: {"masses": f"1,{x}"},
            "1e6",
        ),
        sweep(
            "impact of faster and faster spins",
            "spin [rad/s]",
            ("1", "1e1", "1e2", "1e3", "1e4", "1e5", "1e6"),
            lambda x: {"friction": "1/4", "spins": f"0,0,{x},0,0,{x / 2}"},
            "1e6",
        ),
        sweep(
            "nearly grazing impact",
            "1 - offset",
            ("1", "1/2", "1e-1", "1e-2", "1e-4"),
            lambda x: {"offset": f"{1 - x},0"},
            "1e-2",
        ),
    ),
)
