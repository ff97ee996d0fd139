"""Figure 1.37: an asymmetric force field, and the energy that appears going forward and disappears
coming back (1.139), (1.140).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, Seen, seen


def figure() -> Figure:
    """The force as a particle felt it, and its kinetic energy there and back."""
    forth = seen("asymmetric-field", duration="5/2", samples=2000)
    gained = float(forth["v"][-1])
    back = seen(
        "asymmetric-field",
        x0=f"{forth['x'][-1]:.15g}",
        v0=f"{-gained:.15g}",
        duration="5/2",
        samples=2000,
    )
    force = Series(x=forth["x"][1:-1], y=felt(forth), ink=0, width=2)
    p = forth.instance.p
    ends = (-1.5, 1.5)
    zero = Series(x=np.array(ends), y=np.zeros(2), ink=GREY, width=1)
    field = Panel(
        series=(zero, force),
        x=Axis(title="x [m]", ends=ends),
        y=Axis(title="force [N]"),
        size=(370, 260),
    )
    energies = (
        Series(x=forth["x"], y=energy(forth), ink=0, label="going forward", width=2.5),
        Series(x=back["x"], y=energy(back), ink=1, label="coming back", dashed=True),
    )
    kinetic = Panel(
        series=energies,
        x=Axis(title="x [m]", ends=ends),
        y=Axis(title="kinetic energy [J]"),
        size=(370, 260),
    )
    forward = energy(forth)
    backward = energy(back)
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
        panels=(field, kinetic),
        columns=2,
        numbers=numbers,
    )


def felt(run: Seen) -> Array:
    """m dv/dt (T - 2,) [N] by central differences."""
    v = run["v"]
    gained = v[2:] - v[:-2]
    time = run.t[2:] - run.t[:-2]
    force: Array = run.instance.p.mass * gained / time
    return force


def energy(run: Seen) -> Array:
    """The kinetic energy m v^2/2 (T,) [J] of a run."""
    kinetic: Array = run.instance.p.mass * run["v"] ** 2 / 2
    return kinetic
