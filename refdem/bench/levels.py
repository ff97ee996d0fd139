"""Which steps or tolerances a method is run at, coarse to fine."""

from refdem.core import refinement
from refdem.core.case import Instance
from refdem.core.engine import Method

TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-14)


def levels(instance: Instance, method: Method, *, most_steps: float) -> tuple[float, ...]:
    """Steps [s] from the first that can be judged, each a whole fraction of the one before;
    tolerances; or 0 for exact methods.

    Halves for order 3 and more, quarters below: about a decade of error each. None if even tau is
    too short a step.
    """
    if method.control == "exact":
        return (0.0,)
    if method.control == "tolerance":
        return tuple(
            level for level in TOLERANCES if level > refinement.COUNTING_FLOOR * method.round_off
        )
    first = refinement.levels(instance, method, 1, most_steps)
    if not first:
        return ()
    if method.order_for(instance.problem.features) > 2:
        factor = 2
    else:
        factor = 4
    steps = [first[0]]
    while instance.times[-1] / steps[-1] * factor <= most_steps:
        steps.append(steps[-1] / factor)
    return tuple(steps)
