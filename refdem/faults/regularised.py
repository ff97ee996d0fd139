"""Dry friction regularised by tanh(u/SLOW), as a fault: it vanishes at the slip velocity u = 0,
where Sgn(0) = [-1, 1] allows a body to stick.
"""

from collections.abc import Callable
from dataclasses import replace
from math import tanh
from typing import Any

from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.slider import Slider

SLOW = 2.0**-6
"""Slip velocity [m/s] below which the regularised friction decreases."""
Slip = Callable[[Parts, Slider, Any], Any]
Coefficient = Callable[[Slider, Any], Any]


def regularised(
    sound: Parts, slip: Slip, coefficient: Coefficient, *, counts_work: bool
) -> dict[str, Any]:
    """Replacements of parts of the engine, by which sliders exert F = -mu N tanh(u/SLOW).

    `slip` (parts, slider, velocity of the body) is the slip velocity u [m/s], `coefficient`
    (slider, u) is mu. With `counts_work` the power -F u is part of the dissipated work. No slider
    ever sticks: `side_of` is 0, and every mode holds.
    """

    def loads(world: Any, state: Any, parts: Any, before: Any = None, h: Any = 0.0) -> Any:
        # All loads without sliders, then the regularised friction of each.
        without_sides = state.copy()
        without_sides.side = []
        total = sound.loads(replace(world, sliders=[]), without_sides, parts, before, h)
        for slider in world.sliders:
            # F = -mu(u) N tanh(u/SLOW).
            u = slip(parts, slider, state.v[slider.a])
            force = -coefficient(slider, u) * slider.normal_force * tanh(u / SLOW)
            total.force[slider.a] = vec.moved(total.force[slider.a], force, slider.axis)
            if counts_work:
                total.power -= force * u
        return total

    return {
        "loads": loads,
        "side_of": lambda *arguments: 0,
        "holds": lambda *arguments: True,
    }
