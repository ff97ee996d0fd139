"""Soft spheres without loss of energy, with every parameter of a linear contact at its extremes.

Without a dashpot the force of the contact is never attractive, so that MuJoCo, pymunk and REBOUND,
which have no attractive contact force, run the same sweeps as the reference.
"""

from fractions import Fraction
from functools import partial

from refdem.stress.measures.contact_step import ContactStep
from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.sweep import ELASTIC_SPHERES, SIX_DECADES, TWELVE_DECADES, Battery, Sweep

BASIS = "the overlap is half a sine whose frequency and height are each rounded once"
RIGHT_ANGLE = Fraction("1.57079632679489661923")
"""pi/2 [rad], to the digits that a point leaves of it."""
EDGES = (
    "the step that holds the end of the contact pushes for a part of a step too long or too short,"
    " which is at most (omega h)^2 of the energy: 2.5 per cent with 20 steps"
)
sweep = partial(parameter_sweep, case=ELASTIC_SPHERES, basis=BASIS, samples=8)

BATTERY = Battery(
    id="soft-contacts",
    title="Soft contacts without loss",
    question="Which stiffness, speeds, masses, radii and angles may a soft contact have?",
    sweeps=(
        sweep(
            "elastic spheres, the second one heavier",
            "m2/m1",
            TWELVE_DECADES,
            lambda x: {"masses": f"1,{x}"},
            "1e6",
        ),
        sweep(
            "elastic spheres, harder and harder",
            "stiffness [N/m]",
            TWELVE_DECADES[2:],
            lambda x: {"stiffness": f"{x}"},
            "1e12",
        ),
        sweep(
            "elastic spheres, slower and slower",
            "1/speed [s/m]",
            TWELVE_DECADES[:-1],
            lambda x: {"closing_speed": f"{1 / x}"},
            "1e6",
        ),
        # The largest overlap v sqrt(m/k) is kept constant; otherwise fast spheres would pass
        # through each other.
        sweep(
            "elastic spheres, faster and as much harder",
            "speed [m/s]",
            SIX_DECADES,
            lambda x: {"closing_speed": f"{x}", "stiffness": f"{128 * x * x}"},
            "1e6",
        ),
        sweep(
            "elastic spheres, smaller and smaller",
            "1/radius [1/m]",
            ("2", "1e1", "1e2", "1e4", "1e6"),
            # The contact lasts as long as the spheres take to move by a tenth of the radius.
            lambda x: {"radii": f"{1 / x},{1 / x}", "stiffness": f"{128 * x * x}"},
            "1e6",
        ),
        sweep(
            "elastic spheres, nearer and nearer to grazing",
            "pi/2 - angle [rad]",
            ("1", "1/2", "1e-1", "1e-2", "1e-3", "1e-4"),
            lambda x: {"angle": f"{RIGHT_ANGLE - x}"},
            "1e-2",
        ),
        Sweep(
            name="step against contact time",
            case=ELASTIC_SPHERES,
            along="step / duration of the contact",
            points=("1/100", "1/50", "1/20", "1/10", "1/5", "1/4", "1/3", "1/2", "1", "2"),
            measure=ContactStep(),
            promised="1/20",
            basis=EDGES,
        ),
    ),
)
