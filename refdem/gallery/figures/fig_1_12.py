"""Figure 1.12: a tumbling body with Euler's equations, and without their nonlinear terms
(1.35)-(1.38), in flight and on a slope.
"""

from typing import Any

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.core.problem import Request
from refdem.faults.catalogue import chosen
from refdem.gallery.runs import Array, Seen, remember, seen
from refdem.mechanics.quaternion import matrix, rotated

CORNER = np.array([0.0, 0.0, 0.02])
"""The point that is followed in flight [m], on the third principal axis."""
METHOD = "verlet"
"""Of the transparent engine: its Runge-Kutta passes over the torques of contacts."""
STEPS = 8
SLOPE_STEPS = 32
TUMBLING = {"member": "slope", "duration": "0.6", "samples": 600}
SHOWN = (0, 120, 215, 330, 455, 600)
"""Samples at which the box on the slope is drawn."""
SIZE = (380, 320)


def figure() -> Figure:
    """In flight, then on the slope: the way, and the angular velocity about the first and second
    axis.
    """
    flight = seen("neglected-gyroscopic", samples=600)
    fall = seen("neglected-gyroscopic", **TUMBLING)
    wrong = {
        run: without_gyroscopic_term(run, steps)
        for run, steps in ((flight, STEPS), (fall, SLOPE_STEPS))
    }
    numbers = {
        "largest difference in omega [rad/s]": apart(flight, wrong[flight]),
        "spin at the start [rad/s]": float(np.linalg.norm(omega(flight)[0])),
        "on the slope: largest difference in omega [rad/s]": apart(fall, wrong[fall]),
        "on the slope: distance of the two centres at the end [m]": float(
            np.linalg.norm(centre(fall)[-1] - centre(wrong[fall])[-1])
        ),
        "on the slope: contacts of corners": float(
            sum(event.kind == "contact" for event in fall.trajectory.events)
        ),
    }
    caption = (
        "omega = 10 pi (1, 1, 1)/s, v = (0, 0, 0.025) m/s, 0.6 s. Above in free flight; below the"
        " same box, dropped on a slope of 1/2 rad that it touches with its corners, seen from the"
        " side at six times. Grey: the fault no-gyroscopic-term, whose angular velocity changes in"
        " contacts only; orange: the reference. The wrong runs come from the planted faults, never"
        " from a solver."
    )
    panels = (
        ways(flight, wrong[flight]),
        spins(flight, wrong[flight]),
        slope(fall, wrong[fall]),
        spins(fall, wrong[fall]),
    )
    return Figure(
        id="1.12",
        title="Neglected gyroscopic term",
        caption=caption,
        panels=panels,
        columns=2,
        numbers=numbers,
    )


def ways(right: Seen, wrong: Seen) -> Panel:
    """The path of a point of the body."""
    paths = []
    for run, ink, label in (
        (wrong, GREY, "without the nonlinear terms"),
        (right, 1, "Euler's equations"),
    ):
        place = centre(run) + rotated(
            run.trajectory.attitude[:, 0], np.broadcast_to(CORNER, (len(run.t), 3))
        )
        paths.append(Series(x=place[:, 0], y=place[:, 2], ink=ink, label=label))
    return Panel(
        series=tuple(paths),
        x=Axis(title="x [m]"),
        y=Axis(title="z [m]"),
        size=SIZE,
        title="in flight: a point on axis 3",
    )


def spins(right: Seen, wrong: Seen) -> Panel:
    """Angular velocities about two principal axes."""
    pairs = ((wrong, GREY), (right, 1))
    rates = [
        Series(x=run.t, y=run[f"omega_body.{axis}"], ink=ink, dashed=axis == "y")
        for run, ink in pairs
        for axis in "xy"
    ]
    title = "about axis 1, and 2 (dashed)"
    return Panel(
        series=tuple(rates),
        x=Axis(title="t [s]"),
        y=Axis(title="omega [rad/s]"),
        size=SIZE,
        title=title,
    )


def slope(right: Seen, wrong: Seen) -> Panel:
    """The slope, the paths of the centre, and the edges of the box at some times."""
    drawn = []
    for run, ink in ((wrong, GREY), (right, 1)):
        place = centre(run)
        drawn.append(Series(x=place[:, 0], y=place[:, 2], ink=ink, dashed=True))
        edges = np.concatenate([outlines(run, sample) for sample in SHOWN])
        drawn.append(Series(x=edges[:, 0], y=edges[:, 2], ink=ink))
    far = max(float(series.x[np.isfinite(series.x)].max()) for series in drawn)
    ground = np.array([-0.05, far])
    tangent = np.tan(float(right.instance.p.slope))
    drawn.append(Series(x=ground, y=-tangent * ground, ink=0, width=2.5))
    return Panel(
        series=tuple(drawn),
        x=Axis(title="x [m]"),
        y=Axis(title="z [m]"),
        size=SIZE,
        title="on a slope: box and centre (dashed)",
    )


def outlines(run: Seen, sample: int) -> Array:
    """The edges (36, 3) [m] of the box at one sample, each with a break after it."""
    shape: Any = run.instance.scene.bodies.shape[0]
    corners = (
        np.array(shape.vertices) @ matrix(run.trajectory.attitude[sample, 0]).T
        + centre(run)[sample]
    )
    pairs = {
        tuple(sorted(pair))
        for face in shape.faces
        for pair in zip(face, (*face[1:], face[0]), strict=True)
    }
    gap = np.full(3, np.nan)
    found: Array = np.array(
        [point for a, b in sorted(pairs) for point in (corners[a], corners[b], gap)]
    )
    return found


def without_gyroscopic_term(right: Seen, steps: int) -> Seen:
    """The same question, answered by the transparent engine that carries the fault, with `steps` a
    sample.
    """
    (fault,) = chosen(["no-gyroscopic-term"])
    motion = right.instance.motion
    trajectory, _ = fault.carrier().run(
        Request(problem=motion, method=METHOD, step=motion.interval / steps)
    )
    remember("refdem faults --fault no-gyroscopic-term")
    return Seen(right.instance, trajectory, right.instance.observe(trajectory))


def centre(run: Seen) -> Array:
    """Of mass (T, 3) [m]."""
    place: Array = run.trajectory.position[:, 0]
    return place


def omega(run: Seen) -> Array:
    """In body axes (T, 3) [rad/s]."""
    return np.stack([run[f"omega_body.{axis}"] for axis in "xyz"], axis=1)


def apart(one: Seen, other: Seen) -> float:
    """The largest distance of the angular velocities [rad/s]."""
    return float(np.linalg.norm(omega(one) - omega(other), axis=1).max())
