"""Figure 1.16: velocity of the linear oscillator, undamped, in a fluid, and with dry friction
(1.92)-(1.100).
"""

from refdem.core.figure import Figure
from refdem.gallery.decay import decaying


def figure() -> Figure:
    """Velocities, with the straight line of their maxima under dry friction."""
    return decaying(
        "1.16",
        "v",
        "How an oscillator comes to rest: velocity",
        "The motions of figure 1.15. Under dry friction the largest speeds of the half cycles lie"
        " on a straight line of the slope of the envelope, and the velocity is zero after a finite"
        " time.",
    )
