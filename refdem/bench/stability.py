"""The largest stable step of a method, by bisection: the run stays bounded for many steps."""

import numpy as np

from refdem.bench.entrant import Entrant
from refdem.core.problem import Motion
from refdem.errors import RefdemError

STEPS = 1000
"""A step that is too long by a part in a thousand has grown e^40-fold by then in Verlet's method."""
BEYOND = 100.0
"""A run is unstable if a place, velocity or spin passes this many times its scale."""
FIRST, LAST = 1 / 8, 16.0
"""Multiples of 2/omega between which the limit is looked for."""
BISECTIONS = 12


def stability_limit(entrant: Entrant) -> tuple[float | None, str]:
    """The limit as a multiple of 2/omega = 2 tau and a note; infinite if no step up to LAST is unstable; None where it is not asked.

    Where the shortest multiple is unstable already the limit is 0.
    """
    if entrant.method.control != "step" or not isinstance(entrant.instance.problem, Motion):
        return None, ""
    if not _is_stable(entrant, FIRST):
        return 0.0, f"unstable at {FIRST:g} x 2/omega already"
    low = FIRST
    while low < LAST and _is_stable(entrant, 2 * low):
        low *= 2
    if low >= LAST:
        return float("inf"), f"stable up to {LAST:g} x 2/omega"
    high = 2 * low
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if _is_stable(entrant, middle) else (low, middle)
    return low, ""


def _is_stable(entrant: Entrant, multiple: float) -> bool:
    """Whether STEPS steps of multiple * 2 tau stay within BEYOND times the scales; an engine that gives up is not stable."""
    scales, scene = entrant.instance.scales, entrant.instance.scene
    step = 2 * scales.tau * multiple
    problem = Motion(scene, np.arange(STEPS + 1, dtype=np.float64) * step)
    try:
        with np.errstate(all="ignore"):
            run, _ = entrant.engine.run(entrant.request(problem.interval, problem))
    except (RefdemError, ArithmeticError):
        return False
    reach = scales.length + float(np.max(np.abs(scene.bodies.position)))
    speed = scales.speed + float(np.max(np.abs(scene.bodies.velocity)))
    spin = 1 / scales.tau + float(np.max(np.abs(scene.bodies.omega)))
    flight = 0.0 if scene.elements else speed * problem.times[-1]
    sizes = ((run.position, reach + flight), (run.velocity, speed), (run.omega, spin))
    return all(bool(np.max(np.abs(values)) <= BEYOND * size) for values, size in sizes)
