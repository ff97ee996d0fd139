"""Dry friction from 0 to huge, and contacts with vanishing tangential speed."""

from fractions import Fraction

from refdem.stress.measures.parameters import Parameters, parameter_sweep
from refdem.stress.sweep import Battery, Sweep

LESS = ("1", "1e-1", "1e-3", "1e-6", "1e-12", "0")
MORE = ("1", "1e1", "1e3", "1e6", "1e12")
SLOWER = ("1", "1e-1", "1e-3", "1e-6", "1e-9", "1e-12", "0")
STOPS = "each half cycle has a closed form, and without friction none is subtracted"
HOLDS = "a body that static friction can hold does not move at all, however large the friction is"
GRIPS = (
    "spheres stick until the force has almost vanished, then slip for a time"
    " of 1/mu; both ends are events"
)
BEYOND = (
    "a fixed step continues past the end of the force, where friction is mu"
    " times as large and points the wrong way"
)
ROLLS = (
    "a slip ends in closed form, and one that is a rounding of the speeds is none; what friction"
    " holds needs no more of it than rolling does"
)
RUBS = "sliding friction has a direction at every speed except 0, where it is 0"

BATTERY = Battery(
    id="friction",
    title="Friction from 0 to huge, vanishing tangential speed",
    question=("How small and how large may friction be, and how small the speed that it opposes?"),
    sweeps=(
        parameter_sweep(
            name="less and less on an oscillator",
            case="coulomb-oscillator",
            along="f/(k x0)",
            points=LESS,
            promised="1e-12",
            basis=STOPS,
            given=lambda x: {"friction_force": f"{x / 8}"},
        ),
        parameter_sweep(
            name="more and more on an oscillator",
            case="coulomb-oscillator",
            along="f/(k x0)",
            points=MORE,
            promised="1e12",
            basis=HOLDS,
            given=lambda x: {"friction_force": f"{x}"},
        ),
        parameter_sweep(
            name="more and more on a slope",
            case="block-on-slope",
            along="mu",
            points=MORE,
            promised="1e12",
            basis=HOLDS,
            given=lambda x: {"friction": f"{x}"},
        ),
        parameter_sweep(
            name="less and less on a slope",
            case="block-on-slope",
            along="mu",
            points=LESS,
            promised="0",
            basis=STOPS,
            given=lambda x: {"friction": f"{x / 2}"},
        ),
        parameter_sweep(
            name="more and more on what rolls",
            case="rolling",
            along="mu",
            points=MORE,
            promised="1e12",
            basis=ROLLS,
            given=lambda x: {"friction": f"{x}"},
            samples=8,
        ),
        parameter_sweep(
            name="less and less on what rolls",
            case="rolling",
            along="mu",
            points=LESS,
            promised="0",
            basis=ROLLS,
            given=lambda x: {"friction": f"{x / 2}"},
            samples=8,
        ),
        parameter_sweep(
            name="nearer and nearer to the slope on which it just rolls",
            case="rolling",
            along="1 - tan a/(mu (1 + m R^2/J))",
            points=SLOWER,
            promised="0",
            basis=ROLLS,
            given=lambda x: {"slope": f"{Fraction(7, 8) * (1 - x / 2)}", "speed": "0"},
            samples=8,
        ),
        parameter_sweep(
            name="less and less slip of what rolls",
            case="rolling",
            along="1 - R omega/v",
            points=SLOWER,
            promised="0",
            basis=ROLLS,
            given=lambda x: {"spin": f"{-8 * (1 - x)}"},
            samples=8,
        ),
        parameter_sweep(
            name="less and less between spheres",
            case="two-spheres",
            along="mu",
            points=LESS,
            promised="0",
            basis=RUBS,
            given=lambda x: {"damping": "1", "friction": f"{x}", "angle": "1/2"},
            samples=8,
        ),
        Sweep(
            name="more and more between spheres",
            case="two-spheres",
            along="mu",
            points=MORE,
            promised="1e12",
            basis=GRIPS,
            exempt={"rk4": ("1e3", BEYOND)},
            measure=Parameters(
                lambda x: {
                    "damping": "1",
                    "friction": f"{x}",
                    "angle": "1/2",
                    "tangential_stiffness": "64",
                },
                samples=8,
            ),
        ),
        parameter_sweep(
            name="less and less tangential speed",
            case="two-spheres",
            along="angle [rad]",
            points=SLOWER,
            promised="0",
            basis=RUBS,
            given=lambda x: {
                "damping": "1",
                "friction": "1/4",
                "angle": f"{x}",
                "tangential_stiffness": "64",
            },
            samples=8,
        ),
    ),
)
