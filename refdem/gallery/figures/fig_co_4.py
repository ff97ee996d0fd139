"""Chung and Ooi's test 4, which MFiX has as DEM05: oblique impact, certified, beside what Kharaz,
Gorham and Salman 2001 measured.
"""

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.core.problem import Motion
from refdem.gallery.measured import Reading, readings
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
    panels = [panel(quantity, laws, measured) for quantity in AXES]
    distance = farthest(laws[0])
    points = sum(len(reading.angle) for reading in measured)
    mean = mean_distance(laws[0], measured)
    numbers = {
        "largest distance of the curve from certified values, of their size": distance,
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


def panel(quantity: str, laws: Sequence[dict[str, Array]], measured: Sequence[Reading]) -> Panel:
    """One quantity over the impact angle: a curve a law, and the measured points."""
    series = []
    for k, law in enumerate(laws):
        is_dashed = k == 1
        series.append(
            Series(x=ANGLES, y=law[quantity], ink=k, label=LABELS[k], dashed=is_dashed, width=2)
        )
    for reading in measured:
        if reading.quantity == quantity:
            x, y = reading.places
            # MFiX's reading has the third label, that of Kratos the fourth.
            ink = 2 + reading.by.startswith("Kratos")
            series.append(Series(x=x, y=y, ink=ink, mark="points", label=LABELS[ink]))
    return Panel(
        series=tuple(series),
        x=Axis(title="impact angle [degrees]", ends=(0, 90)),
        y=Axis(title=AXES[quantity]),
        size=(370, 260),
    )


def mean_distance(law: dict[str, Array], measured: Sequence[Reading]) -> float:
    """The mean distance of the measured tangential restitutions from the curve of a law."""
    distances = []
    for reading in measured:
        if reading.quantity == "tangential restitution":
            on_curve = np.interp(reading.angle, ANGLES, law[reading.quantity])
            distances.append(np.abs(on_curve - reading.value))
    return float(np.mean(np.concatenate(distances)))


def curves(member: str) -> dict[str, Array]:
    """Every quantity of AXES (N,) at ANGLES, from the state long after the impact."""
    remember(command(instance(CASE, member=member)))
    ends = []
    for angle in np.radians(ANGLES):
        case_instance = instance(CASE, member=member, angle=float(angle))
        first_and_last = case_instance.times[[0, -1]]
        end = case_instance.observe(answer(Motion(case_instance.scene, first_and_last)))
        ends.append((-end["v.x"][-1], end["v.y"][-1], -end["omega.z"][-1], end["v.y"][0]))
    return impact_quantities(*np.array(ends).T)


def impact_quantities(normal: Array, across: Array, spin: Array, before: Array) -> dict[str, Array]:
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
        case_instance = instance(CASE, member="co-4", angle=float(np.radians(angle)))
        last = Fraction(float(case_instance.times[-1]))
        certified = case_instance.truth().at(last)
        end = {name: np.array([float(ball.mid)]) for name, ball in certified.items()}
        before = case_instance.scene.bodies.velocity[0, 1:2]
        expected = impact_quantities(-end["v.x"], end["v.y"], -end["omega.z"], before)
        for name in ("spin", "tangential restitution"):
            on_curve = law[name][angle == ANGLES]
            deviations.append(abs(on_curve / expected[name] - 1))
    return float(np.max(deviations))
