"""What is claimed for MuJoCo's integrators: Computation chapter of its documentation, "Numerical
integration".
"""

from dataclasses import replace

from refdem.core.engine import UNEQUAL_MOMENTS, Method

FIRST_ORDER = {"contact": 1, "friction": 1}
"""Contact and dry friction switch inside a step, and no integrator of MuJoCo locates the event."""

GEOMS = frozenset({"solid:cuboid", "solid:ellipsoid", "solid:cylinder"})
ALGEBRA = frozenset(
    f"identity:{name}"
    for name in (
        *(
            "quaternion-about",
            "turn-about",
            "matrix-product",
            "matrix-vector",
            "product",
            "conjugate",
            "rotated",
            "matrix-of-quaternion",
        ),
        *("sum", "difference", "vector-sum", "vector-difference"),
        *("matrix-difference", "transpose", "nearest-turn"),
        *("quaternion-of-matrix", "quaternion-of-euler", "rate", "unit", "absolute", "dot"),
    )
)
"""Operations for which MuJoCo has a function."""

KEPT = frozenset({"momentum", "angular-momentum", "constraint"})
"""Velocities change by h F/m at the old places r, and r by h v: r x m v changes by h r x F alone.
The torques of forces that act on two bodies at one point, or along one line, add up to 0.
"""
BROKEN = {
    "angular-momentum": frozenset({UNEQUAL_MOMENTS, "rod", "ball_joint", "contact:rigid"}),
}
"""Where attitude or joints enter the angular momentum, it holds to first order."""

COORDINATES = {
    "rod": (
        "the coordinate is the hinge angle, and the adapter computes the point at"
        " the rod's length from it"
    ),
    "ball_joint": (
        "the coordinate is the attitude about the joint, and the adapter computes"
        " the centre at the arm's end"
    ),
}
EULER = Method(
    name="euler",
    summary="semi-implicit Euler, MuJoCo's default",
    control="step",
    order=1,
    conserves=KEPT,
    broken_with=BROKEN,
    derived=COORDINATES,
    summed_clock=True,
    cost_rank=1,
)
EULER_AS_SHIPPED = replace(
    EULER,
    name="euler-as-shipped",
    summary=(
        "the same with MuJoCo's defaults: solref and solimp of contacts and dry friction, a pyramid"
        " for Coulomb's cone, and a solver with tolerance 1e-8 that starts from the solution of the"
        " last step"
    ),
    complete_state=False,
    as_shipped=True,
)
EULER_DERIVATIVES = replace(
    EULER,
    name="euler-derivatives",
    summary=(
        "the same, with derivatives by the start: `mjd_transitionFD`, MuJoCo's differences of its"
        " own step, chained over the steps"
    ),
    differentiates=True,
    start_only=True,
    by_name=True,
)
METHODS = (
    Method(
        name="rk4",
        summary=(
            "classical Runge-Kutta, fourth order also in the orientation of free joints (since"
            " 4.0.0)"
        ),
        control="step",
        order=4,
        order_with=FIRST_ORDER,
        conserves=frozenset({"momentum", "constraint"}),
        derived=COORDINATES,
        summed_clock=True,
        cost_rank=2,
    ),
    EULER,
    EULER_AS_SHIPPED,
    EULER_DERIVATIVES,
    Method(
        name="implicitfast",
        summary=(
            "Euler, implicit in velocity (gyroscopic terms of free bodies included), which MuJoCo"
            " recommends"
        ),
        control="step",
        order=1,
        conserves=KEPT,
        broken_with=BROKEN,
        derived=COORDINATES,
        summed_clock=True,
        cost_rank=1,
    ),
    Method(
        name="compiler",
        summary="the compiler's inertia of geoms of the solid's kind",
        control="exact",
        answers="solid",
        knows=GEOMS,
    ),
    Method(
        name="mesh-compiler",
        summary=(
            "the compiler's exact inertia of meshes, whose vertices MuJoCo keeps in single"
            " precision"
        ),
        control="exact",
        precision="single",
        answers="solid",
        knows=frozenset({"solid:polyhedron"}),
    ),
    Method(
        name="algebra",
        summary="the functions mju_* for matrices and quaternions",
        control="exact",
        answers="identity",
        knows=ALGEBRA,
    ),
)

INTEGRATORS = {
    "rk4": "mjINT_RK4",
    "euler": "mjINT_EULER",
    "euler-as-shipped": "mjINT_EULER",
    "euler-derivatives": "mjINT_EULER",
    "implicitfast": "mjINT_IMPLICITFAST",
}


def is_tuned(method: str) -> bool:
    """False for the method that leaves MuJoCo's defaults alone."""
    return method != EULER_AS_SHIPPED.name


def differentiates(method: str) -> bool:
    """True for the method that answers with derivatives."""
    return method == EULER_DERIVATIVES.name
