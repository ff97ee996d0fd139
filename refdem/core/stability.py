"""Stability of a step size: many steps from the start of a motion, which must stay bounded."""

from dataclasses import replace

import numpy as np

from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory

STEPS = 1000
"""Number of steps. With a step 2 tau (1 + a) beyond the limit the motion in Verlet's method grows
by exp(mu) a step, cosh(mu) = 2 (1 + a)^2 - 1, which is mu = 2 sqrt(2 a) for small a: for a = 1/1000
by exp(89) in 1000 steps.
"""
BEYOND = 100.0
"""A run is unstable if a place, velocity or spin passes this many times its scale."""


def probe(instance: Instance, multiple: float) -> Motion:
    """The instance's motion over STEPS steps of `multiple` times 2 tau, every step a sample.

    2 tau = 2/omega_max is the stability limit of velocity Verlet.
    """
    step = 2 * instance.scales.tau * multiple
    return replace(instance.motion, times=np.arange(STEPS + 1, dtype=np.float64) * step)


def excess(instance: Instance, run: Trajectory) -> float:
    """The largest |position|, |velocity| or |omega| of the run, each in units of its scale.

    A scale is that of the case (L, L/tau, 1/tau) plus the largest value at the start. If contacts
    are the only elements, bodies fly apart after an impact, and the length scale is increased by
    the distance V T.
    """
    scales = instance.scales
    scene = instance.scene
    # V = L/tau + |v(0)|,   X = L + |r(0)| (+ V T),   W = 1/tau + |omega(0)|.
    speed_scale = scales.speed + float(np.max(np.abs(scene.bodies.velocity)))
    flies_away = all(element.kind == "contact" for element in scene.elements)
    if flies_away:
        flight = speed_scale * float(run.t[-1] - run.t[0])
    else:
        flight = 0.0
    length_scale = scales.length + float(np.max(np.abs(scene.bodies.position))) + flight
    omega_scale = 1 / scales.tau + float(np.max(np.abs(scene.bodies.omega)))
    scaled = (
        (run.position, length_scale),
        (run.velocity, speed_scale),
        (run.omega, omega_scale),
    )
    return max(float(np.max(np.abs(values)) / scale) for values, scale in scaled)
