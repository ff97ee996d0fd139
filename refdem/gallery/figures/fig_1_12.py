"""Figure 1.12: a tumbling body with Euler's equations, and without their nonlinear terms (1.35)-(1.38)."""

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.core.problem import Request
from refdem.faults.catalogue import chosen
from refdem.gallery.runs import Array, Seen, remember, seen
from refdem.mechanics.quaternion import rotated

CORNER = np.array([0.0, 0.0, 0.02])
"""The point that is followed [m], on the third principal axis."""
STEPS = 8


def figure() -> Figure:
    """The path of a point of the body, and the angular velocity about its first and second axis."""
    right = seen("neglected-gyroscopic", samples=600)
    wrong = without_gyroscopic_term(right)
    paths, rates = [], []
    for run, ink, label in ((wrong, -1, "without the nonlinear terms"), (right, 1, "Euler's equations")):
        place = run.trajectory.position[:, 0] + rotated(run.trajectory.attitude[:, 0], np.broadcast_to(CORNER, (len(run.t), 3)))
        paths.append(Series(x=place[:, 0], y=place[:, 2], ink=ink, label=label))
        rates += [Series(x=run.t, y=run[f"omega_body.{axis}"], ink=ink, dashed=axis == "y") for axis in "xy"]
    way = Panel(series=tuple(paths), x=Axis(title="x [m]"), y=Axis(title="z [m]"), size=(380, 320), title="a point on axis 3")
    spin = Panel(
        series=tuple(rates), x=Axis(title="t [s]"), y=Axis(title="omega [rad/s]"), size=(380, 320), title="about axis 1, and 2 (dashed)"
    )  # fmt: skip
    apart = np.linalg.norm(difference(right, wrong), axis=1)
    numbers = {
        "largest difference in omega [rad/s]": float(apart.max()),
        "spin at the start [rad/s]": float(np.linalg.norm(omega(right)[0])),
    }
    caption = (
        "omega = 10 pi (1, 1, 1)/s, v = (0, 0, 0.025) m/s, 0.6 s, free flight. Grey: the fault no-gyroscopic-term, whose angular velocity "
        "never changes; orange: the reference. The wrong run comes from the planted faults, never from a solver."
    )
    return Figure(id="1.12", title="Neglected gyroscopic term", caption=caption, panels=(way, spin), columns=2, numbers=numbers)


def without_gyroscopic_term(right: Seen) -> Seen:
    """The same question, answered by the transparent engine that carries the fault."""
    (fault,) = chosen(["no-gyroscopic-term"])
    motion = right.instance.motion
    trajectory, _ = fault.carrier().run(Request(problem=motion, method=fault.method, step=motion.interval / STEPS))
    remember("refdem faults --fault no-gyroscopic-term")
    return Seen(right.instance, trajectory, right.instance.observe(trajectory))


def omega(run: Seen) -> Array:
    """In body axes (T, 3) [rad/s]."""
    return np.stack([run[f"omega_body.{axis}"] for axis in "xyz"], axis=1)


def difference(one: Seen, other: Seen) -> Array:
    """Of the angular velocities (T, 3) [rad/s]."""
    found: Array = omega(one) - omega(other)
    return found
