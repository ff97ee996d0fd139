"""What is claimed for MuJoCo's integrators: Computation chapter of its documentation, "Numerical integration"."""

from refdem.core.engine import Method

FIRST_ORDER = {"contact": 1, "friction": 1}
"""Contact and dry friction switch inside a step, and no integrator of MuJoCo looks for the moment."""

METHODS = (
    Method(
        name="rk4",
        summary="classical Runge-Kutta, fourth order also in the orientation of free joints (since 4.0.0)",
        control="step",
        order=4,
        order_with=FIRST_ORDER,
        conserves=frozenset({"momentum", "constraint"}),
        cost_rank=2,
    ),
    Method(
        name="euler",
        summary="semi-implicit Euler, MuJoCo's default",
        control="step",
        order=1,
        conserves=frozenset({"momentum", "constraint"}),
        cost_rank=1,
    ),
    Method(
        name="implicitfast",
        summary="Euler, implicit in velocity (gyroscopic terms of free bodies included), which MuJoCo recommends",
        control="step",
        order=1,
        conserves=frozenset({"momentum", "constraint"}),
        cost_rank=1,
    ),
)

INTEGRATORS = {"rk4": "mjINT_RK4", "euler": "mjINT_EULER", "implicitfast": "mjINT_IMPLICITFAST"}
