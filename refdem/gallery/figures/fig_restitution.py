"""Restitution out against restitution in: what engines with impulses give back of a closing
speed.
"""

from fractions import Fraction
from typing import Any

import numpy as np

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.core.problem import Request
from refdem.gallery.runs import Array, command, instance, remember

SHOWN = (
    ("reference", "impacts", "reference"),
    ("pymunk", "semi-implicit-euler", "pymunk"),
    ("pymunk", "semi-implicit-euler-as-shipped", "pymunk, as shipped"),
    ("rebound", "leapfrog", "REBOUND"),
)
"""Engine, method and label of each curve; engines that are not installed are left out."""
RESTITUTIONS = tuple(f"{k}/16" for k in range(17))
"""From no part of the closing speed to all of it."""
SPEEDS = tuple(f"1e{k}" for k in range(-4, 4))
"""Closing speeds [m/s]: bodies that creep, and a shot."""
GIVEN = "3/4"
"""The restitution of the curves over the speed and over the step."""
WIDEST = 6.5
"""Pixels of the first curve."""
WIDTH_STEP = 1.75
"""Pixels by which each curve is narrower than the one beneath it."""
STRIDES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
"""Steps in an interval of the samples of a bounce."""
STRIDE = 8
"""Steps in an interval of the samples of two spheres."""


def figure() -> Figure:
    """Two spheres that meet head-on over the restitution and over the speed, and a ball on a floor
    over the step.
    """
    installed = [one for one in SHOWN if discovery.engine(one[0]).missing() is None]
    remember(command(instance("hard-spheres", offset="0,0")))
    remember(command(instance("bouncing-ball", bounces="1")))
    wanted = np.array([float(Fraction(e)) for e in RESTITUTIONS])
    speeds = np.array([float(speed) for speed in SPEEDS])
    given = float(Fraction(GIVEN))
    over_restitution = []
    over_speed = []
    over_step = []
    largest = 0.0
    numbers: dict[str, float] = {}
    for ink, (engine, method, label) in enumerate(installed):
        measured = np.array([of_spheres(engine, method, restitution=e) for e in RESTITUTIONS])
        at_speeds = np.array(
            [of_spheres(engine, method, restitution=GIVEN, closing_speed=v) for v in SPEEDS]
        )
        over_restitution.append(curve(wanted, measured, label, ink))
        over_speed.append(curve(speeds, at_speeds, label, ink))
        largest = max(largest, np.abs(measured - wanted).max(), np.abs(at_speeds - given).max())
        bounces = of_bounces(engine, method)
        if bounces is not None:
            over_step.append(curve(*bounces, label, ink))
            farthest = np.abs(bounces[1] - given).max()
            numbers[f"{label}: largest error of a ball on a floor"] = float(round(farthest, 6))
    # What the scene asks for lies on top.
    over_restitution.append(line(wanted, wanted))
    over_speed.append(line(speeds, np.full_like(speeds, given)))
    over_step.append(line(*across(over_step, given)))
    # Of rounding only the size counts, which is the same on all processors.
    numbers["largest error between two spheres, in units of 1e-12"] = float(
        np.ceil(largest / 1e-12)
    )
    return Figure(
        id="restitution",
        title="Restitution out against restitution in",
        caption=(
            "The speed at which bodies part over that at which they closed, as runs show it,"
            " against the restitution that the scene has (grey). Two spheres on which nothing else"
            " acts, over the restitution and over the closing speed: all give back what is asked,"
            " at every speed. A ball that falls on a floor, over the step: an engine that looks for"
            " contacts at the ends of its steps strikes the ball late, when gravity has made it"
            " faster, and gives back up to (1 + e) g h/v too much."
        ),
        panels=(
            panel("two spheres", Axis(title="restitution of the scene"), over_restitution),
            panel(
                f"two spheres, {GIVEN}",
                Axis(title="closing speed [m/s]", is_log=True),
                over_speed,
                ends=(0.5, 1.0),
            ),
            panel(
                f"a ball on a floor, {GIVEN}",
                Axis(title="step over the time of the fall", is_log=True),
                over_step,
            ),
        ),
        columns=2,
        numbers=numbers,
    )


def panel(
    title: str, x: Axis, series: list[Series], ends: tuple[float, float] | None = None
) -> Panel:
    """The restitution of runs over x."""
    y = Axis(title="restitution of the run", ends=ends)
    return Panel(series=tuple(series), x=x, y=y, title=title, size=(370, 260))


def curve(x: Array, y: Array, label: str, ink: int) -> Series:
    """What the runs of one engine show; curves that lie on each other are seen by their widths."""
    return Series(x=x, y=y, label=label, ink=ink, width=WIDEST - WIDTH_STEP * ink)


def line(x: Array, y: Array) -> Series:
    """What the scene asks for."""
    return Series(x=x, y=y, ink=GREY, dashed=True, width=1.0)


def across(curves: list[Series], value: float) -> tuple[Array, Array]:
    """The ends of all curves along x, and one value at both."""
    x = np.concatenate([curve.x for curve in curves])
    return np.array([x.min(), x.max()]), np.array([value, value])


def run_of(engine: str, method: str, case_instance: Instance, stride: int) -> Any:
    """The run of a method with this number of steps in an interval; exact methods need no step."""
    step = None
    if discovery.engine(engine).method(method).control == "step":
        step = float(case_instance.problem.interval) / stride
    request = Request(problem=case_instance.problem, method=method, step=step)
    return discovery.engine(engine).run(request)[0]


def of_spheres(engine: str, method: str, **parameters: str) -> float:
    """The parting over the closing speed of two spheres that meet head-on."""
    case_instance = instance("hard-spheres", offset="0,0", samples="16", **parameters)
    run = run_of(engine, method, case_instance, STRIDE)
    relative = run.velocity[:, 1, 0] - run.velocity[:, 0, 0]
    return float(relative[-1] / -relative[0])


def of_bounces(engine: str, method: str) -> tuple[Array, Array] | None:
    """The step over the time of the fall, and the speed away from the floor over that towards it,
    of a ball that bounces once; None if the engine has no floor under rigid spheres.

    Both speeds are those at the time at which the ball touches: in flight they change by g t.
    """
    case_instance = instance("bouncing-ball", bounces="1", samples="16", restitution=GIVEN)
    chosen = discovery.engine(engine).method(method)
    if discovery.engine(engine).unsupported(case_instance.problem, chosen) is not None:
        return None
    gravity = float(case_instance.p.gravity)
    fall = float(np.sqrt(2.0 * case_instance.p.height / gravity))
    steps = []
    measured = []
    for stride in STRIDES:
        run = run_of(engine, method, case_instance, stride)
        last = len(run.t) - 1
        towards = -(run.velocity[0, 0, 1] - gravity * fall)
        away = run.velocity[last, 0, 1] + gravity * (run.t[last] - fall)
        steps.append(float(case_instance.problem.interval) / stride / fall)
        measured.append(float(away / towards))
    return np.array(steps), np.array(measured)
