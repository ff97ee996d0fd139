"""Figure 1.12: a tumbling body with Euler's equations, and without their nonlinear terms
(1.35)-(1.38), in flight and on a slope.
"""

from typing import Any

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.core.problem import Request
from refdem.faults.catalogue import chosen
from refdem.gallery.runs import Array, ObservedRun, observed, remember
from refdem.mechanics.quaternion import matrix, rotated

CORNER = np.array([0.0, 0.0, 0.02])
"""The point that is followed in flight [m], on the third principal axis."""
METHOD = "verlet"
"""Of the transparent engine: its Runge-Kutta passes over the torques of contacts."""
STEPS = 8
"""Steps a sample of the faulty flight: its error is below the width of a line."""
SLOPE_STEPS = 32
"""Steps a sample of the faulty fall down the slope, whose contacts are stiff."""
TUMBLING = {"member": "slope", "duration": "0.6", "samples": 600}
SAMPLES_SHOWN = (0, 120, 215, 330, 455, 600)
"""Samples at which the box on the slope is drawn."""
SIZE = (380, 320)


def figure() -> Figure:
    """The way of the body in flight and then on the slope, and the angular velocity about the first
    and second axis.
    """
    flight = observed("neglected-gyroscopic", samples=600)
    fall = observed("neglected-gyroscopic", **TUMBLING)
    wrong_flight = without_gyroscopic_term(flight, STEPS)
    wrong_fall = without_gyroscopic_term(fall, SLOPE_STEPS)
    spin = float(np.linalg.norm(omega(flight)[0]))
    distance = float(np.linalg.norm(centre(fall)[-1] - centre(wrong_fall)[-1]))
    contacts = sum(event.kind == "contact" for event in fall.trajectory.events)
    numbers = {
        "largest difference in omega [rad/s]": apart(flight, wrong_flight),
        "spin at the start [rad/s]": spin,
        "on the slope: largest difference in omega [rad/s]": apart(fall, wrong_fall),
        "on the slope: distance of the two centres at the end [m]": distance,
        "on the slope: contacts of corners": float(contacts),
    }
    caption = (
        "omega = 10 pi (1, 1, 1)/s, v = (0, 0, 0.025) m/s, 0.6 s. Above in free flight; below the"
        " same box, dropped on a slope of 1/2 rad that it touches with its corners, seen from the"
        " side at six times. Grey: the fault no-gyroscopic-term, whose angular velocity changes in"
        " contacts only; orange: the reference. The wrong runs come from the planted faults, never"
        " from a solver."
    )
    panels = (
        paths(flight, wrong_flight),
        spins(flight, wrong_flight),
        slope(fall, wrong_fall),
        spins(fall, wrong_fall),
    )
    return Figure(
        id="1.12",
        title="Neglected gyroscopic term",
        caption=caption,
        panels=panels,
        columns=2,
        numbers=numbers,
        digits=3,
    )


def paths(right: ObservedRun, wrong: ObservedRun) -> Panel:
    """The path of a point of the body."""
    series = []
    for run, ink, label in (
        (wrong, GREY, "without the nonlinear terms"),
        (right, 1, "Euler's equations"),
    ):
        corner = np.broadcast_to(CORNER, (len(run.t), 3))
        place = centre(run) + rotated(run.trajectory.attitude[:, 0], corner)
        series.append(Series(x=place[:, 0], y=place[:, 2], ink=ink, label=label))
    return Panel(
        series=tuple(series),
        x=Axis(title="x [m]"),
        y=Axis(title="z [m]"),
        size=SIZE,
        title="in flight: a point on axis 3",
    )


def spins(right: ObservedRun, wrong: ObservedRun) -> Panel:
    """Angular velocities about two principal axes."""
    rates = []
    for run, ink in ((wrong, GREY), (right, 1)):
        rates.append(Series(x=run.t, y=run["omega_body.x"], ink=ink))
        rates.append(Series(x=run.t, y=run["omega_body.y"], ink=ink, dashed=True))
    title = "about axis 1, and 2 (dashed)"
    return Panel(
        series=tuple(rates),
        x=Axis(title="t [s]"),
        y=Axis(title="omega [rad/s]"),
        size=SIZE,
        title=title,
    )


def slope(right: ObservedRun, wrong: ObservedRun) -> Panel:
    """The slope, the paths of the centre, and the edges of the box at some times."""
    drawn = []
    for run, ink in ((wrong, GREY), (right, 1)):
        place = centre(run)
        drawn.append(Series(x=place[:, 0], y=place[:, 2], ink=ink, dashed=True))
        edges = np.concatenate([outlines(run, sample) for sample in SAMPLES_SHOWN])
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


def outlines(run: ObservedRun, sample: int) -> Array:
    """The edges (36, 3) [m] of the box at one sample, each with a break after it."""
    shape: Any = run.instance.scene.bodies.shape[0]
    turn = matrix(run.trajectory.attitude[sample, 0])
    corners = np.array(shape.vertices) @ turn.T + centre(run)[sample]
    # Two faces share each edge; it counts once.
    edges = set()
    for face in shape.faces:
        following = (*face[1:], face[0])
        edges |= {tuple(sorted(edge)) for edge in zip(face, following, strict=True)}
    gap = np.full(3, np.nan)
    points = []
    for a, b in sorted(edges):
        points += [corners[a], corners[b], gap]
    return np.array(points)


def without_gyroscopic_term(right: ObservedRun, steps: int) -> ObservedRun:
    """The same question, answered by the transparent engine that carries the fault, with `steps` a
    sample.
    """
    (fault,) = chosen(["no-gyroscopic-term"])
    motion = right.instance.motion
    request = Request(problem=motion, method=METHOD, step=motion.interval / steps)
    trajectory, _ = fault.carrier().run(request)
    remember("refdem faults --fault no-gyroscopic-term")
    return ObservedRun(right.instance, trajectory, right.instance.observe(trajectory))


def centre(run: ObservedRun) -> Array:
    """The places (T, 3) [m] of the centre of mass."""
    place: Array = run.trajectory.position[:, 0]
    return place


def omega(run: ObservedRun) -> Array:
    """The angular velocity (T, 3) [rad/s] in body axes."""
    return np.stack([run[f"omega_body.{axis}"] for axis in "xyz"], axis=1)


def apart(one: ObservedRun, other: ObservedRun) -> float:
    """The largest distance of the angular velocities [rad/s]."""
    differences = np.linalg.norm(omega(one) - omega(other), axis=1)
    return float(differences.max())
