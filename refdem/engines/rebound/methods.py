"""The integrators of REBOUND that refdem runs, with what is claimed for them."""

from dataclasses import replace

from refdem.core.engine import Method

KEPT = frozenset({"momentum", "angular-momentum"})
COLLISIONS = {"contact:rigid": 1}
"""Hard spheres collide at the end of the step in which they meet, at their positions at that time.
With either search, spheres that have passed through each other by then do not collide. The step
must be shorter than the sum of the radii divided by the closing speed.
"""

LEAPFROG = Method(
    name="leapfrog",
    summary=(
        "drift, kick, drift; forces that depend on the place alone; spheres that overlap at the"
        " end of a step collide (direct)"
    ),
    control="step",
    order=2,
    order_with=COLLISIONS,
    conserves=KEPT,
    symplectic=True,
    reversible=True,
    backward=True,
    summed_clock=True,
    cost_rank=1,
)
LEAPFROG_LINE = replace(
    LEAPFROG,
    name="leapfrog-line",
    summary=(
        "leapfrog; line also finds spheres that overlapped on the straight way of a step, and"
        " hardsphere lets those of them collide that overlap and approach at its end"
    ),
)
"""The same step with REBOUND's other search for collisions."""

LEAPFROG_UNCUT = replace(
    LEAPFROG,
    name="leapfrog-uncut",
    summary=(
        "leapfrog with collisions (direct) whose steps of constant size do not end at samples: a"
        " sample is made by a copy that goes on to it in one shorter step, as"
        " Simulationarchive.getSimulation(mode='exact') does"
    ),
)
"""The same method with steps that do not depend on the times of output, as in long runs, so that
output does not affect where collisions are detected.
"""
IAS15 = Method(
    name="ias15",
    summary=(
        "Gauss-Radau of order 15 whose step keeps the error under round-off (Rein and Spiegel"
        " 2015, Pham et al. 2024)"
    ),
    control="exact",
    backward=True,
    summed_clock=True,
    cost_rank=2,
)
AS_SHIPPED = replace(
    IAS15,
    name="ias15-as-shipped",
    summary=(
        "sim.integrate(t) with REBOUND's defaults: ias15 with epsilon 1e-9, a first step of 0.001,"
        " steps cut at samples, collisions (direct) searched for at the ends of steps and resolved"
        " in an order drawn from the clock"
    ),
    deterministic=False,
    as_shipped=True,
)

METHODS = (
    LEAPFROG,
    LEAPFROG_LINE,
    LEAPFROG_UNCUT,
    Method(
        name="leapfrog-8",
        summary="17 leapfrog steps composed to order 8 (Blanes and Casas 2016)",
        control="step",
        order=8,
        conserves=KEPT,
        symplectic=True,
        reversible=True,
        backward=True,
        summed_clock=True,
        cost_rank=3,
    ),
    Method(
        name="whfast",
        summary=(
            "Wisdom-Holman: motion about one centre is propagated exactly (Rein and Tamayo 2015);"
            " one step a sample"
        ),
        control="exact",
        conserves=KEPT,
        reversible=True,
        backward=True,
        cost_rank=0,
    ),
    IAS15,
    AS_SHIPPED,
    Method(
        name="bs",
        summary=(
            "Gragg-Bulirsch-Stoer with eps_rel = eps_abs = tolerance; the only one that carries"
            " Euler's equations"
        ),
        control="tolerance",
        constant=1e-3,
        constant_reason=(
            "a step is accepted at the tolerance and then extrapolated once more, so that smooth"
            " motions are off by less"
        ),
        derived={
            "attitude": "the adapter divides attitudes by their length, so that it is always 1"
        },
        backward=True,
        cost_rank=4,
    ),
)
