"""Figure 1.28: the friction law of the stick-slip oscillator and its terms (1.126)."""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, command, instance, remember
from refdem.scene.elements.slider import Slider

SPEEDS = np.linspace(-4.0, 4.0, 801)


def figure() -> Figure:
    """mu(v), and mu(v) sgn(v) with all its terms and with some left out; at rest any value between
    the limits.
    """
    whole = law()
    coefficients = whole.coefficient(np.abs(SPEEDS))
    law_panel = Panel(
        series=(Series(x=SPEEDS, y=coefficients, ink=0, width=2),),
        x=Axis(title="v [m/s]"),
        y=Axis(title="mu(v)", ends=(0.0, 0.45)),
        size=(330, 260),
        title="the law",
    )
    numbers = {
        "at rest": float(whole.coefficient(0.0)),
        "least": float(coefficients.min()),
        "speed of the least [m/s]": abs(float(SPEEDS[coefficients.argmin()])),
    }
    caption = (
        "The coefficients of the scene that the stick-slip runs are made of. Friction first falls"
        " with the speed, from mu0 = 0.4 towards mu1 = 0.1, then grows with its square; falling"
        " friction is what feeds the oscillation. At rest it takes any value between its limits."
    )
    return Figure(
        id="1.28",
        title="Friction that depends on the speed",
        caption=caption,
        panels=(law_panel, forces(whole)),
        columns=2,
        numbers=numbers,
        digits=3,
    )


def forces(whole: Slider) -> Panel:
    """The force over the speed: with the whole law, and with some of its terms left out."""
    no_growth = law(lambda1=0)
    constant = law(lambda0=0, lambda1=0, mu0="1/10")
    series = (
        Series(x=SPEEDS, y=signed(whole), ink=0, label="mu0, mu1, lambda0, lambda1"),
        Series(x=SPEEDS, y=signed(no_growth), ink=1, label="without lambda1"),
        Series(x=SPEEDS, y=signed(constant), ink=GREY, label="mu1 alone", dashed=True),
    )
    return Panel(
        series=series,
        x=Axis(title="v [m/s]"),
        y=Axis(title="mu(v) Sgn(v)"),
        size=(330, 260),
        title="the force",
    )


def law(**parameters: object) -> Slider:
    """The slider of the case at these parameters."""
    case_instance = instance("stick-slip", **parameters)
    if not parameters:
        remember(command(case_instance))
    return case_instance.scene.all(Slider)[0]


def signed(slider: Slider) -> Array:
    """mu(v) Sgn(v), from limit to limit at rest."""
    # A constant law gives one number for all speeds.
    coefficients = np.broadcast_to(slider.coefficient(np.abs(SPEEDS)), SPEEDS.shape)
    force: Array = coefficients * np.sign(SPEEDS)
    return force
