"""Figure 1.15: place of the linear oscillator, undamped, in a fluid, and with dry friction
(1.92)-(1.100).
"""

from refdem.core.figure import Figure
from refdem.gallery.decay import decaying


def figure() -> Figure:
    """Places, with the straight envelope of the turning points under dry friction."""
    return decaying(
        "1.15",
        "x",
        "How an oscillator comes to rest: place",
        "m = k = 1, from x = 1 at rest. In a fluid (delta = 0.1) the amplitude falls exponentially"
        " and never reaches zero; under dry friction (f = 0.15) the turning points lie on a"
        " straight line, and at t = 3 pi it stops for ever, not at the origin.",
    )
