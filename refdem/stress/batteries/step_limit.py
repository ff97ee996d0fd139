"""Steps up to and past the limit of stability, 2/omega for Verlet's method."""

from refdem.stress.measures.step_limit import StepLimit
from refdem.stress.sweep import Battery, Sweep

POINTS = (
    "1/8",
    "1/4",
    "1/2",
    "3/4",
    "9/10",
    "99/100",
    "101/100",
    "11/10",
    "5/4",
    "7/5",
    "143/100",
    "3/2",
    "2",
    "4",
    "8",
    "16",
)
ALONG = "step in units of 2/omega"
THEORY = (
    "the stability limit of velocity Verlet is 2/omega, that of classical"
    " Runge-Kutta 2.83/omega (Hairer, Norsett and Wanner 1996, IV.2)"
)
CORRECTED_ONCE = (
    "a predictor-corrector of many values with one correction a step is explicit, and its"
    " limit of stability falls with its order"
)

BATTERY = Battery(
    id="step-limit",
    title="Steps up to and above the stability limit",
    question=(
        "How large may the step be before the run grows without bound? 1000 steps"
        " must stay within 100 times the size of the motion."
    ),
    sweeps=(
        Sweep(
            name="step: harmonic-oscillator",
            case="harmonic-oscillator",
            along=ALONG,
            points=POINTS,
            measure=StepLimit(),
            is_general=True,
            promised="99/100",
            basis=THEORY,
            exempt={
                "gear-4": ("1/2", CORRECTED_ONCE),
                "gear-5": ("1/4", CORRECTED_ONCE),
                "gear-6": ("1/4", CORRECTED_ONCE),
            },
        ),
        Sweep(
            name="step: pendulum",
            case="pendulum",
            along=ALONG,
            points=POINTS,
            measure=StepLimit(),
            is_general=True,
        ),
        Sweep(
            name="step: two-body-orbit",
            case="two-body-orbit",
            along=ALONG,
            points=POINTS,
            measure=StepLimit(),
            is_general=True,
        ),
        Sweep(
            name="step: free-rigid-body",
            case="free-rigid-body",
            along=ALONG,
            points=POINTS,
            measure=StepLimit(),
            is_general=True,
        ),
    ),
)
