"""Figure 1.37: an asymmetric force field, and the energy that appears going forward and disappears
coming back (1.139), (1.140).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, ObservedRun, observed

ENDS = (-1.5, 1.5)
"""Ends of the axis of places [m]: the field lies between -1 and 1/2."""


def figure() -> Figure:
    """The force as a particle felt it, and its kinetic energy there and back."""
    clock = {"duration": "5/2", "samples": 2000}
    forth = observed("asymmetric-field", **clock)
    last_place = f"{forth['x'][-1]:.15g}"
    reversed_velocity = f"{-forth['v'][-1]:.15g}"
    back = observed("asymmetric-field", x0=last_place, v0=reversed_velocity, **clock)
    forward = energy(forth)
    backward = energy(back)
    p = forth.instance.p
    # The triangle under the force.
    area = p.k1 * abs(p.x1) * (p.x2 - p.x1) / 2
    numbers = {
        "gained going forward [J]": float(forward[-1] - forward[0]),
        "lost coming back [J]": float(backward[0] - backward[-1]),
        "k1 |x1| (x2 - x1)/2 [J]": float(area),
    }
    caption = (
        "The force rises linearly from x1 = -1 to 0 and falls linearly to x2 = 1/2; it is the mass"
        " times the change of the velocity of a run. A particle that crosses the field forward"
        " gains the area under it, and gives it back to the last bit on its way back."
    )
    return Figure(
        id="1.37",
        title="Asymmetric force field",
        caption=caption,
        panels=(force_field(forth), kinetic_energies(forth, back)),
        columns=2,
        numbers=numbers,
    )


def force_field(run: ObservedRun) -> Panel:
    """The force on the particle of a run over its place."""
    zero = Series(x=np.array(ENDS), y=np.zeros(2), ink=GREY, width=1)
    force = Series(x=run["x"][1:-1], y=felt(run), ink=0, width=2)
    return Panel(
        series=(zero, force),
        x=Axis(title="x [m]", ends=ENDS),
        y=Axis(title="force [N]"),
        size=(370, 260),
    )


def kinetic_energies(forth: ObservedRun, back: ObservedRun) -> Panel:
    """The kinetic energy over the place, of the run forth and of the run back."""
    energies = (
        Series(x=forth["x"], y=energy(forth), ink=0, label="going forward", width=2.5),
        Series(x=back["x"], y=energy(back), ink=1, label="coming back", dashed=True),
    )
    return Panel(
        series=energies,
        x=Axis(title="x [m]", ends=ENDS),
        y=Axis(title="kinetic energy [J]"),
        size=(370, 260),
    )


def felt(run: ObservedRun) -> Array:
    """m dv/dt (T - 2,) [N] by central differences."""
    v = run["v"]
    velocity_change = v[2:] - v[:-2]
    time = run.t[2:] - run.t[:-2]
    force: Array = run.instance.p.mass * velocity_change / time
    return force


def energy(run: ObservedRun) -> Array:
    """The kinetic energy m v^2/2 (T,) [J] of a run."""
    kinetic: Array = run.instance.p.mass * run["v"] ** 2 / 2
    return kinetic
