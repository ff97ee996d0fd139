"""Instances, truths and trajectories made by hand, so that values and bounds of findings can be
computed on paper: a test states what each of them must be, and no case or solver is asked.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from refdem.core.case import Case, Instance
from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.finding import Finding
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import SampledTruth, Truth
from refdem.core.variant import Variant
from refdem.errors import NotCertifiedError
from refdem.scene import Bodies, Body, Element, Scene

U = 2.0**-53
"""The unit round-off of double precision."""
SCALES = Scales(length=4.0, tau=0.5, duration=8.0, mass=2.0)
"""L = 4 m, tau = 1/2 s, T = 8 s, 2 kg: the speed scale is 8 m/s, the energy scale 128 J."""
AXES = {"x": 0, "y": 1, "z": 2}
COLUMNS = {"r": "position", "v": "velocity", "omega": "omega"}
STATE = ("position", "velocity", "attitude", "omega")


class HandMade(Case):
    """A case that is only its scene, its samples and its scales.

    It observes quantities named as x, vy, r1.x, v2.z or omega1.y; others are left out.
    """

    id = "hand-made"
    title = ""
    statement = ""
    latex = ""
    source = ""
    parameters = ()

    def __init__(
        self,
        scene: Scene,
        times: Sequence[float],
        scales: Scales,
        quantities: Sequence[Quantity],
        *,
        is_chaotic: bool | None = None,
        exclude: Mapping[str, str] | None = None,
    ) -> None:
        self._scene = scene
        self._times = np.array(times, float)
        self._scales = scales
        self._quantities = tuple(quantities)
        self._is_chaotic = is_chaotic
        self._exclude = dict(exclude or {})

    def is_chaotic(self, p: Parameters) -> bool | None:
        """What the test said."""
        return self._is_chaotic

    @property
    def exclude(self) -> Mapping[str, str]:  # type: ignore[override]
        """What the test said."""
        return self._exclude

    def scene(self, p: Parameters) -> Scene:
        """The scene that was given."""
        return self._scene

    def times(self, p: Parameters) -> Any:
        """The samples that were given."""
        return self._times

    def scales(self, p: Parameters) -> Scales:
        """The scales that were given."""
        return self._scales

    def lasting(self, p: Parameters) -> Scales:
        """The scales that were given, with their own duration."""
        return self._scales

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that were given."""
        return self._quantities

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Any]:
        """Coordinates by their names."""
        seen = {}
        for quantity in self._quantities:
            values = _coordinate(quantity.name, trajectory)
            if values is not None:
                seen[quantity.name] = values
        return seen

    def truth(self, p: Parameters) -> Truth:
        """There is none: a test gives its own samples."""
        raise NotCertifiedError("no truth was made by hand")


def _coordinate(name: str, run: Trajectory) -> Any:
    """The coordinate (T,) of a run that a name such as x, vy or omega2.z says; None if it is none.

    A polar angle is named theta: that of the first body about the origin, from x to y.
    """
    if name == "theta":
        return np.arctan2(run.position[:, 0, 1], run.position[:, 0, 0])
    head, _, axis = name.rpartition(".")
    if head[:-1] in COLUMNS:
        return getattr(run, COLUMNS[head[:-1]])[:, int(head[-1]) - 1, AXES[axis]]
    if name in AXES:
        return run.position[:, 0, AXES[name]]
    if name[:1] == "v" and name[1:] in AXES:
        return run.velocity[:, 0, AXES[name[1:]]]
    return None


def instance(
    bodies: Sequence[Body],
    elements: Sequence[Element] = (),
    *,
    times: Sequence[float] = (0.0, 2.0, 4.0, 6.0, 8.0),
    scales: Scales = SCALES,
    quantities: Mapping[str, float] | Sequence[Quantity] = (),
    **more: Any,
) -> Instance:
    """An instance of a scene; `quantities` are scales by name, or whole quantities."""
    if isinstance(quantities, Mapping):
        quantities = [Quantity(name, "", scale) for name, scale in quantities.items()]
    scene = Scene(Bodies.of(list(bodies)), tuple(elements))
    case = HandMade(scene, times, scales, quantities, **more)
    return Instance(case, Parameters((), {}))


def method(control: str = "step", **claims: Any) -> Method:
    """A method that claims what it is told; of second order unless that is said."""
    if control == "step":
        claims.setdefault("order", 2)
    return Method(name="hand-made", summary="", control=control, **claims)  # type: ignore[arg-type]


def truth(
    times: Sequence[float],
    values: Mapping[str, Sequence[float]],
    *,
    radius: float = 0.0,
    growth: Sequence[float] | None = None,
    scalars: Mapping[str, tuple[float, float]] | None = None,
    until: int | None = None,
) -> SampledTruth:
    """Certified samples, as many as `until` says; S is 1 unless it is given."""
    count = until or len(times)
    return SampledTruth(
        t=[float(t) for t in times],
        values={name: [float(x) for x in column][:count] for name, column in values.items()},
        radii={name: [radius] * count for name in values},
        sensitivity=list(growth or [1.0] * count),
        scalars=dict(scalars or {}),
        method="",
        witness="",
        until=count,
    )


def standing(of: Instance, **columns: Any) -> Trajectory:
    """A run that stays at its start, but for the columns (T, N, k) that are given."""
    bodies = of.scene.bodies
    count = len(of.times)
    made = {name: np.repeat(getattr(bodies, name)[None], count, axis=0) for name in STATE}
    more = {name: value for name, value in columns.items() if name not in STATE}
    given = {name: np.array(value, float) for name, value in columns.items() if name in STATE}
    return Trajectory(t=of.times, **(made | given), **more)


def all_runs(
    check: Check, subject: Subject, made: Callable[[Variant], CompletedRun]
) -> dict[Variant, CompletedRun]:
    """The runs that a check asks for, at first and in view of those, each of them `made`."""
    runs: dict[Variant, CompletedRun] = {}
    wanted = check.needs(subject)
    while wanted:
        for variant in wanted:
            runs[variant] = made(variant)
        asked = check.further(subject, runs)
        wanted = tuple(variant for variant in asked if variant not in runs)
    return runs


def findings(
    check: Check, subject: Subject, run: Trajectory | Callable[[Variant], Trajectory]
) -> dict[str, Finding]:
    """What a check finds by quantity, where every run that it needs is `run`, or `run(variant)`."""

    def made(variant: Variant) -> CompletedRun:
        if isinstance(run, Trajectory):
            return CompletedRun(run, Cost(seconds=0.0))
        return CompletedRun(run(variant), Cost(seconds=0.0))

    runs = all_runs(check, subject, made)
    return {finding.quantity: finding for finding in check.judge(subject, runs)}


def near(expected: Any, rel: float = 1e-6) -> Any:
    """Equal to a relative error alone: the absolute one of 1e-12 that pytest.approx allows by
    itself is more than all round-off that a bound may have.
    """
    return pytest.approx(expected, rel=rel, abs=0.0)
