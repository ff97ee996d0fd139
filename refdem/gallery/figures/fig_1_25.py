"""Figure 1.25: the van der Pol oscillator without and with a drive: place, phase portrait, spectrum
(1.124).
"""

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, ObservedRun, observed
from refdem.mechanics.spectrum import frequency_with_error, spectrum

FORCES = ("0", "1/25", "2/5")
DURATION = 1050
"""Duration [s] of the motions: spectra resolve 1/1005 Hz."""
SAMPLES = 10500
"""Sample intervals: 10 a second."""
SETTLED = 450
"""Number of the sample, at 45 s, from which on the motion has settled."""
END_OF_CURVE = 1500
"""Number of the sample, at 150 s, at which the drawn curve ends."""


def figure() -> Figure:
    """A row for each force: x(t) with its beginning in grey, the cycle, and the amplitudes of its
    lines.
    """
    panels: list[Panel] = []
    numbers = {}
    for ink, force in enumerate(FORCES):
        run = observed("van-der-pol", p=force, x0="1/2", v0=0, duration=DURATION, samples=SAMPLES)
        t = run.t[SETTLED:]
        x = run["x"][SETTLED:]
        frequency, height = spectrum(t, x)
        panels += [
            motion(run, force, ink),
            cycle(run, ink),
            lines(frequency, height, ink),
        ]
        # The highest bin is next to the line, whose frequency follows from its phase.
        highest = float(frequency[np.argmax(height)])
        cycle_frequency, error = frequency_with_error(t, x, highest)
        numbers[f"highest line, p = {force} [rad/s]"] = cycle_frequency
        numbers[f"highest line, p = {force}: its error [rad/s]"] = error
        if force == "0":
            numbers["amplitude of the free cycle [m]"] = float(np.abs(x).max())
    caption = (
        "mu = 0.2, drive 1.15 rad/s. From the top: no force, a weak one, a strong one. The weak"
        " force adds lines at the drive, at 2 w - 1.15 = 0.85 and at 3 w - 2.30 = 0.7; the strong"
        " one more of them. Grey is left out of the spectra (Hann window, t = 45 s to 1050 s), so"
        " that lines stand as high as the resolution allows. The frequency of the highest is that"
        " at which its phase stays; its error, the change of it without a quarter of the record."
    )
    title = "Van der Pol oscillator"
    return Figure(
        id="1.25",
        title=title,
        caption=caption,
        panels=tuple(panels),
        columns=3,
        numbers=numbers,
        digits=6,
    )


def motion(run: ObservedRun, force: str, ink: int) -> Panel:
    """The place over the time, its beginning in grey."""
    begin = slice(0, SETTLED + 1)
    rest = slice(SETTLED, END_OF_CURVE)
    x = run["x"]
    settling = Series(x=run.t[begin], y=x[begin], ink=-1)
    settled = Series(x=run.t[rest], y=x[rest], ink=ink)
    return Panel(
        series=(settling, settled),
        x=Axis(title="t [s]", ends=(0, END_OF_CURVE / 10)),
        y=Axis(title="x [m]", ends=(-2.6, 2.6)),
        title=f"p = {force}",
        size=(270, 170),
    )


def cycle(run: ObservedRun, ink: int) -> Panel:
    """The settled motion in the plane of place and velocity."""
    settled = slice(SETTLED, SETTLED + 2500)
    return Panel(
        series=(Series(x=run["x"][settled], y=run["v"][settled], ink=ink, width=0.8),),
        x=Axis(title="x [m]", ends=(-2.6, 2.6)),
        y=Axis(title="v [m/s]", ends=(-3, 3)),
        size=(170, 170),
    )


def lines(frequency: Array, height: Array, ink: int) -> Panel:
    """The amplitudes of the spectrum's lines (N,) near 1 rad/s, as parts of the largest."""
    near = (frequency > 0.5) & (frequency < 1.5)
    part = height[near] / height.max()
    return Panel(
        # The floor keeps zeros on a logarithmic axis.
        series=(Series(x=frequency[near], y=np.maximum(part, 1e-6), ink=ink),),
        x=Axis(title="w [rad/s]", ends=(0.5, 1.5)),
        y=Axis(title="amplitude / largest", ends=(1e-5, 1.5), is_log=True),
        size=(230, 170),
    )
