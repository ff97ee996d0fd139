"""Is a step stable: many steps of it from the start of a motion, and whether the run stays
bounded.
"""

from dataclasses import replace

import numpy as np

from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory

STEPS = 1000
"""A step that is too long by a part in a thousand has grown e^40-fold by then in Verlet's method.
"""
BEYOND = 100.0
"""A run is unstable if a place, velocity or spin passes this many times its scale."""


def probe(instance: Instance, multiple: float) -> Motion:
    """STEPS steps of `multiple` times 2/omega = 2 tau, each a sample."""
    step = 2 * instance.scales.tau * multiple
    return replace(instance.motion, times=np.arange(STEPS + 1, dtype=np.float64) * step)


def excess(instance: Instance, run: Trajectory) -> float:
    """The largest place, velocity or spin of the run, each in units of its scale; what flies freely
    may go as far as it does.
    """
    scales = instance.scales
    scene = instance.scene
    speed = scales.speed + float(np.max(np.abs(scene.bodies.velocity)))
    if scene.elements:
        flight = 0.0
    else:
        flight = speed * float(run.t[-1] - run.t[0])
    reach = scales.length + float(np.max(np.abs(scene.bodies.position))) + flight
    spin = 1 / scales.tau + float(np.max(np.abs(scene.bodies.omega)))
    sizes = ((run.position, reach), (run.velocity, speed), (run.omega, spin))
    return max(float(np.max(np.abs(values)) / size) for values, size in sizes)
