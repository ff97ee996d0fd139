"""Chung and Ooi's test 4, which MFiX has as DEM05: oblique impact, certified, beside what Kharaz,
Gorham and Salman 2001 measured.
"""

from fractions import Fraction

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.core.problem import Motion
from refdem.gallery.measured import readings
from refdem.gallery.runs import Array, answer, command, instance, remember

CASE = "impact-benchmarks"
RADIUS = 0.0025
"""Radius of the spheres of impact benchmark 4 [m]."""
ANGLES = np.arange(1.0, 89.0, 2.0)
CERTIFIED = (5.0, 15.0, 25.0, 45.0, 85.0)
"""Degrees at which the curve is held against truth."""
AXES = {
    "rebound angle": "rebound angle of the centre [degrees]",
    "rebound angle of the contact": "rebound angle of the point of contact [degrees]",
    "spin": "spin after the impact [rad/s]",
    "tangential restitution": "tangential velocity, after over before",
}
LABELS = (
    "linear law, e = 0.98 (certified)",
    "Hertz and Mindlin, e = 1",
    "measured, as MFiX reads it",
    "measured, as Kratos reads it",
)


def figure() -> Figure:
    """Four panels over the impact angle: two laws, and two readings of the same measured points."""
    laws = [curves(member) for member in ("co-4", "dem-05-mindlin")]
    measured = readings("kharaz_2001")
    panels = []
    for quantity, title in AXES.items():
        series = []
        for k, law in enumerate(laws):
            curve = Series(
                x=ANGLES, y=law[quantity], ink=k, label=LABELS[k], dashed=k == 1, width=2
            )
            series.append(curve)
        for one in measured:
            if one.quantity == quantity:
                x, y = one.places
                ink = 2 + one.by.startswith("Kratos")
                series.append(Series(x=x, y=y, ink=ink, mark="points", label=LABELS[ink]))
        panels.append(
            Panel(
                series=tuple(series),
                x=Axis(title="impact angle [degrees]", ends=(0, 90)),
                y=Axis(title=title),
                size=(370, 260),
            )
        )
    near = []
    for one in measured:
        if one.quantity.startswith("tang"):
            curve_there = np.interp(one.angle, ANGLES, laws[0][one.quantity])
            near.append(np.abs(curve_there - one.value))
    mean = float(np.mean(np.concatenate(near)))
    points = sum(len(one.angle) for one in measured)
    numbers = {
        "largest distance of the curve from certified values, of their size": farthest(laws[0]),
        "measured points": float(points),
        "mean distance of measured tangential restitution from the curve (not judged)": mean,
    }
    caption = (
        "A sphere of aluminium oxide, 5 mm across, strikes a wall at 3.9 m/s: it sticks or slides,"
        " the more the larger the angle from the normal. Lines: the reference, held against"
        " certified values for the declared law. Points: measured by Kharaz, Gorham and Salman"
        " (2001), twice read off printed figures; they scatter by 5 to 10 % and judge nothing,"
        " neither law nor code."
    )
    return Figure(
        id="co-4",
        title="Oblique impact beside an experiment",
        caption=caption,
        panels=tuple(panels),
        columns=2,
        numbers=numbers,
    )


def curves(member: str) -> dict[str, Array]:
    """Every quantity of AXES (N,) at ANGLES, from the state long after the impact."""
    remember(command(instance(CASE, member=member)))
    ends = []
    for angle in np.radians(ANGLES):
        asked = instance(CASE, member=member, angle=float(angle))
        first_and_last = asked.times[[0, -1]]
        end = asked.observe(answer(Motion(asked.scene, first_and_last)))
        ends.append((-end["v.x"][-1], end["v.y"][-1], -end["omega.z"][-1], end["v.y"][0]))
    return seen_in(*np.array(ends).T)


def seen_in(normal: Array, across: Array, spin: Array, before: Array) -> dict[str, Array]:
    """Quantities from velocities [m/s] away from the wall and along it, the spin [rad/s], and the
    velocity along the wall before.
    """
    # The point of contact moves along the wall with v - R omega.
    across_at_contact = across - RADIUS * spin
    return {
        "rebound angle": np.degrees(np.arctan2(across, normal)),
        "rebound angle of the contact": np.degrees(np.arctan2(across_at_contact, normal)),
        "spin": spin,
        "tangential restitution": across / before,
    }


def farthest(law: dict[str, Array]) -> float:
    """Largest distance of the linear law's spin and restitution from certified ones, relative."""
    deviations = []
    for angle in CERTIFIED:
        asked = instance(CASE, member="co-4", angle=float(np.radians(angle)))
        last = Fraction(float(asked.times[-1]))
        certified = asked.truth().at(last)
        end = {name: np.array([float(ball.mid)]) for name, ball in certified.items()}
        before = asked.scene.bodies.velocity[0, 1:2]
        proved = seen_in(-end["v.x"], end["v.y"], -end["omega.z"], before)
        for name in ("spin", "tangential restitution"):
            there = law[name][angle == ANGLES]
            deviations.append(abs(there / proved[name] - 1))
    return float(np.max(deviations))
