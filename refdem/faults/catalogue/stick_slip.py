"""Friction that depends on the speed, on a moving belt: the reference of the speed, the decrease of
friction with it, sticking, and the drive.
"""

from functools import partial
from math import pi
from typing import Any

from refdem.faults.change import of_arguments, of_elements, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.faults.regularised import regularised
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider

stick_slip = partial(Fault, kind="stick-slip", on=("sticking",))


def _slip(parts: Parts, slider: Slider, velocity: Any) -> Any:
    """Velocity [m/s] of the body relative to the belt."""
    return parts.slides_at(slider, velocity)


def _fading(sound: Parts) -> dict[str, Any]:
    """Friction decreases to 0 with the speed, as if sgn(0) were 0: what should stick creeps."""
    return regularised(
        sound, _slip, lambda slider, u: slider.coefficient(abs(u)), counts_work=False
    )


FAULTS = (
    stick_slip(
        name="stribeck-against-the-ground",
        sentence=(
            "The speed in the law of friction is relative to the ground instead of the belt."
        ),
        sees=("error", "v"),
        inside=of_arguments(
            slider_force=lambda s, side, speed: (s, side, abs(side * speed + s.belt_velocity))
        ),
    ),
    stick_slip(
        name="stribeck-sign-against-the-ground",
        sentence=("Friction opposes the velocity relative to the ground instead of the belt."),
        sees=("error", "v"),
        before=of_elements(Slider, belt_velocity=scaled(0.0)),
    ),
    stick_slip(
        name="stribeck-fading",
        sentence=(
            "sgn(0) = 0: friction vanishes with the velocity relative to the belt, and"
            " nothing sticks."
        ),
        sees=("error", "v"),
        levels=4,
        inside=_fading,
    ),
    stick_slip(
        name="stribeck-static-only",
        sentence=(
            "Friction does not decrease with the speed: it has the static coefficient throughout."
        ),
        sees=("error", "v"),
        before=of_elements(Slider, lambda0=scaled(0.0)),
    ),
    stick_slip(
        name="stribeck-last-term-linear",
        sentence="The last term of the law is linear in the speed instead of quadratic.",
        sees=("error", "v"),
        levels=5,
        before=of_elements(Slider, law=lambda law: "stribeck_linear"),
    ),
    stick_slip(
        name="stribeck-released-late",
        sentence="The mass sticks until the pull exceeds the limit by 10 %.",
        sees=("error", "v"),
        inside=of_arguments(holds=lambda slider, along: (slider, along / 1.1)),
    ),
    stick_slip(
        name="belt-drive-sine",
        sentence="The drive is a sine instead of a cosine.",
        sees=("error", "v"),
        before=of_elements(Force, phase=lambda phase: phase - pi / 2),
    ),
)
