"""The replays of a campaign: truth and one run of each method, at the resolution of a screen.

Truth consists of compared quantities, from which not every picture can be drawn. A coordinate of a
body that is a compared quantity is drawn as certified. The remaining coordinates come from the run
of the reference with the smallest error, and the replay states that error.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.check import Subject
from refdem.core.finding import Record
from refdem.core.problem import Motion
from refdem.core.replay import DrawnBody, DrawnLink, DrawnPlane, Grid, Replay, Track
from refdem.core.trajectory import Event, Trajectory
from refdem.core.truth import SampledTruth
from refdem.mechanics.quaternion import conjugate, product, turned_by
from refdem.planning.plan import Task
from refdem.planning.runs import Runs
from refdem.scene import Scene
from refdem.scene.bodies import Bodies
from refdem.scene.element import Link
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.shapes import Polyhedron, Sphere, box

Array = NDArray[np.float64]

MOST_FRAMES = 200
"""Largest number of frames of a replay; samples are taken at equal distances."""
MOST_BODIES = 32
"""Largest number of bodies that a picture of this size can show separately."""
MOST_CONTACTS = 400
"""Largest number of contacts of a track that are shown, the first ones."""
VISIBLE = 1e-3
"""Smallest error of the reference, in scales of the quantities, that is visible: one pixel of a
picture of 1000 pixels."""
FARTHEST = 4.0
"""Distance from truth, in sizes of the picture, up to which the place of a body is exact."""
AZIMUTH = np.radians(30.0)
ELEVATION = np.radians(20.0)
"""Viewing direction of a motion in space."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """A task with its record, and the trajectories of its runs without a change, by level."""

    task: Task
    record: Record
    plain: Mapping[float, Trajectory]


@dataclass(frozen=True, kw_only=True, eq=False)
class Anchor:
    """A run of the reference, and its largest error in scales of the compared quantities."""

    method: str
    trajectory: Trajectory
    error: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """What every track of a replay is compared with.

    `position` (T, N, 3) [m] and `attitude` (T, N, 4) are those of truth, completed from the run
    `anchor`, and `frames` (F,) are the samples that are shown. `turning` (N,) is True for bodies
    that rotate, `is_compared` if the case compares attitudes. `reach` [m] is the largest distance
    from truth at which a body is drawn.
    """

    position: Array
    attitude: Array
    anchor: Trajectory
    frames: NDArray[np.int64]
    turning: NDArray[np.bool_]
    is_compared: bool
    reach: float


def replays(tasks: list[Task], runs: Runs, records: list[Record]) -> list[Replay]:
    """A replay of each instance for which the run of the reference is accurate enough to draw."""
    numbers: dict[str, list[int]] = {}
    for number, task in enumerate(tasks):
        if task.subject.truth is not None and is_drawable(task.subject.instance):
            numbers.setdefault(task.subject.instance.label, []).append(number)
    found = []
    for of_label in numbers.values():
        # One instance at a time, so that few trajectories are in memory at once.
        shown = replay_of([_candidate(tasks[n], records[n], runs, n) for n in of_label])
        if shown is not None:
            found.append(shown)
    return found


def _candidate(task: Task, record: Record, runs: Runs, number: int) -> Candidate:
    """A task with its plain runs; `number` is that of the task in the plan."""
    plain = {
        variant.level: trajectory
        for variant, run in runs.of_task(number, change="none").items()
        if (trajectory := runs.trajectory(run)) is not None
    }
    return Candidate(task=task, record=record, plain=plain)


def replay_of(candidates: Sequence[Candidate]) -> Replay | None:
    """The replay of one instance; None if no run of the reference is accurate enough to draw."""
    candidates = [candidate for candidate in candidates if candidate.plain]
    anchors = [anchor for anchor in map(anchor_of, candidates) if anchor is not None]
    if not anchors:
        return None
    anchor = min(anchors, key=lambda one: one.error)
    if anchor.error > VISIBLE:
        return None
    return replay(candidates[0].task.subject, anchor, candidates)


def is_drawable(instance: Instance) -> bool:
    """True for a motion of a few bodies that stay where they can be seen."""
    if not isinstance(instance.problem, Motion):
        return False
    return len(instance.scene.bodies) <= MOST_BODIES and not instance.scene.all(PeriodicBox)


def anchor_of(candidate: Candidate) -> Anchor | None:
    """The finest run of a method of the reference; None if its error is not measured."""
    measured = [
        finding.levels[-1]
        for finding in candidate.record.findings
        if finding.check == "error" and finding.levels
    ]
    if not candidate.task.engine.is_reference or not measured:
        return None
    level = min(one.level for one in measured)
    errors = [one.error for one in measured if one.level == level]
    if level not in candidate.plain or len(errors) < len(measured):
        return None
    return Anchor(
        method=candidate.task.method.name,
        trajectory=candidate.plain[level],
        error=max(errors),
    )


def replay(subject: Subject, anchor: Anchor, candidates: Iterable[Candidate]) -> Replay | None:
    """The replay of an instance up to where truth is certified; None if that is its start only."""
    truth = subject.truth
    if truth is None or truth.until < 2:
        return None
    instance = subject.instance
    scene = instance.scene
    bodies = scene.bodies
    until = truth.until
    t = anchor.trajectory.t
    frames = np.unique(np.linspace(0, until - 1, min(until, MOST_FRAMES)).round().astype(int))
    position, certified = truth_places(instance, truth, anchor.trajectory)
    is_compared = attitude_is_compared(instance, anchor.trajectory)
    turning = np.any(bodies.inertia > 0, axis=1)
    attitude = _attitudes(anchor.trajectory, turning, is_compared)
    size = float(np.max(np.ptp(position[:until], axis=(0, 1)), initial=0.0))
    stage = Stage(
        position=position,
        attitude=attitude,
        anchor=anchor.trajectory,
        frames=frames,
        turning=turning,
        is_compared=is_compared,
        reach=FARTHEST * max(size, instance.scales.length),
    )
    tracks: dict[tuple[str, str], Track] = {}
    for candidate in candidates:
        track = _track(candidate, stage)
        tracks.setdefault((track.engine, track.method), track)
    # Displacements from the start are stored, most of which are 0.
    moved = (position[frames] - position[0]).reshape(len(frames), -1)
    turned = (attitude[frames] - attitude[0]).reshape(len(frames), -1)
    times = tuple(float(f"{time:.6g}") for time in t[frames])
    drawn = [_body(bodies, n, position[0, n], attitude[0, n]) for n in range(len(bodies))]
    planes = [DrawnPlane(point=p.point, normal=p.normal) for p in scene.all(Plane)]
    axes = view(scene, position[:until], attitude[:until])
    contacts = _contacts(anchor.trajectory.events, t, frames)
    return Replay(
        label=instance.label,
        t=times,
        bodies=tuple(drawn),
        links=tuple(_links(scene)),
        planes=tuple(planes),
        touches=bool(scene.all(Contact)),
        view=axes,
        place=Grid.of(moved),
        turn=Grid.of(turned),
        certified=certified,
        anchor=anchor.method,
        anchor_error=anchor.error,
        contacts=contacts,
        tracks=tuple(tracks.values()),
    )


def truth_places(
    instance: Instance, truth: SampledTruth, anchor: Trajectory
) -> tuple[Array, tuple[str, ...]]:
    """Places (T, N, 3) [m], and the names of the quantities that are coordinates among them.

    A quantity is a coordinate if the case observes it as the bits of one.
    """
    position = anchor.position.copy()
    observed = instance.observe(anchor)
    certified = []
    for name, values in observed.items():
        if name not in truth.values or np.shape(values) != anchor.t.shape:
            continue
        same = np.all(anchor.position == np.asarray(values)[:, None, None], axis=0)
        if np.any(same) and instance.quantities[name].unit == "m":
            certified.append(name)
            position[: truth.until, same] = truth.value(name)[: truth.until, None]
    return position, tuple(certified)


def attitude_is_compared(instance: Instance, anchor: Trajectory) -> bool:
    """True if some quantity of the case changes when every body is turned."""
    turn = np.array([0.8, 0.36, 0.48, 0.0])
    turned = replace(anchor, attitude=product(np.broadcast_to(turn, (1, 1, 4)), anchor.attitude))
    before = instance.observe(anchor)
    after = instance.observe(turned)
    return any(not np.array_equal(before[name], after[name]) for name in before)


def _attitudes(trajectory: Trajectory, turning: NDArray[np.bool_], is_compared: bool) -> Array:
    """Attitudes (T, N, 4) of the marks on bodies; points do not rotate.

    Where the case compares no attitudes, a code need not report them. Its marks then rotate by the
    time integral of its angular velocities.
    """
    attitude = np.array(trajectory.attitude)
    if not is_compared:
        angle = _summed(trajectory.t, trajectory.omega)
        for k in range(1, len(attitude)):
            attitude[k] = product(turned_by(angle[k] - angle[k - 1]), attitude[k - 1])
    attitude[:, ~turning] = (1.0, 0.0, 0.0, 0.0)
    # q and -q are the same attitude: the one nearer to the previous sample is taken.
    flips = np.where(np.sum(attitude[1:] * attitude[:-1], axis=-1) < 0, -1.0, 1.0)
    attitude[1:] *= np.cumprod(flips, axis=0)[..., None]
    return attitude


def _summed(t: Array, rate: Array) -> Array:
    """The integral (T, ...) of a rate over time by the trapezoidal rule, 0 at the start."""
    steps = np.diff(t)[:, None, None] * (rate[1:] + rate[:-1]) / 2
    return np.concatenate([np.zeros_like(rate[:1]), np.cumsum(steps, axis=0)])


def _rotation_vector(q: Array) -> Array:
    """The rotation vector (..., 3) [rad], at most pi long, of unit quaternions (..., 4)."""
    # q = (cos(a/2), n sin(a/2)):  a n = (a/sin(a/2)) vec q,  2 vec q for a = 0.
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., :1])
    ratio = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 0)
    vector: Array = ratio * q[..., 1:]
    return vector


def _track(candidate: Candidate, stage: Stage) -> Track:
    """The track of the coarsest run of a method, whose errors are the easiest to see."""
    level = max(candidate.plain)
    run = candidate.plain[level]
    away = run.position - stage.position
    if stage.is_compared:
        turn = _rotation_vector(product(run.attitude, conjugate(stage.attitude)))
    else:
        turn = _summed(run.t, run.omega - stage.anchor.omega)
    turn[:, ~stage.turning] = 0.0
    frames = stage.frames
    shape = (len(frames), -1)
    # Displacements from truth are cut where the body is far outside of the picture.
    place = np.clip(away[frames], -stage.reach, stage.reach).reshape(shape)
    shown = slice(frames[-1] + 1)
    method = candidate.task.method
    return Track(
        engine=candidate.task.engine.name,
        method=method.name,
        control=method.control,
        level=level,
        place=Grid.of(place),
        turn=Grid.of(turn[frames].reshape(shape)),
        largest=_largest(away[shown]),
        largest_turn=_largest(turn[shown]),
        contacts=_contacts(run.events, run.t, frames),
    )


def _largest(vectors: Array) -> float:
    """The largest length of vectors (T, N, 3), with three digits; at most 1e300."""
    with np.errstate(over="ignore"):
        longest = np.max(np.linalg.norm(vectors, axis=-1), initial=0.0)
    return float(f"{min(longest, 1e300):.3g}")


def _contacts(events: tuple[Event, ...], t: Array, frames: Any) -> tuple[tuple[int, int], ...]:
    """(frame, body) of the contacts that a run reports, at the first frame not before each."""
    contacts = [(event.time, event.body) for event in events if event.kind == "contact"]
    numbers = np.searchsorted(t[frames], [time for time, _ in contacts])
    pairs = {
        (int(number), body)
        for number, (_, body) in zip(numbers, contacts, strict=True)
        if number < len(frames)
    }
    return tuple(sorted(pairs)[:MOST_CONTACTS])


def _body(bodies: Bodies, number: int, position: Array, attitude: Array) -> DrawnBody:
    """How a body is drawn, with its place and attitude at the start."""
    shape = bodies.shape[number]
    inertia = bodies.inertia[number]
    is_inertia = False
    if not isinstance(shape, Sphere | Polyhedron) and np.any(inertia > 0):
        # The sides of the equivalent box: a^2 = 6 (I_y + I_z - I_x)/m, and cyclically for b, c.
        squares = 6 * (inertia.sum() - 2 * inertia) / bodies.mass[number]
        shape = box(*np.sqrt(np.maximum(squares, 0.0)).tolist())
        is_inertia = True
    x, y, z = position.tolist()
    w, i, j, k = attitude.tolist()
    drawn = DrawnBody(position=(x, y, z), attitude=(w, i, j, k), is_inertia=is_inertia)
    if isinstance(shape, Sphere):
        drawn = msgspec.structs.replace(drawn, radius=shape.radius)
    elif isinstance(shape, Polyhedron):
        drawn = msgspec.structs.replace(drawn, vertices=shape.vertices, faces=shape.faces)
    return drawn


def _links(scene: Scene) -> Iterable[DrawnLink]:
    """One line for each pair of anchors, however many elements join them."""
    places = set()
    for element in scene.elements:
        if not isinstance(element, Link):
            continue
        ends = (element.a, element.b, element.anchor_a, element.anchor_b)
        if ends not in places:
            places.add(ends)
            a, b, anchor_a, anchor_b = ends
            kind = str(type(element).__struct_config__.tag)
            yield DrawnLink(kind=kind, a=a, b=b, anchor_a=anchor_a, anchor_b=anchor_b)


def view(scene: Scene, position: Array, attitude: Array) -> Any:
    """The unit vectors right, up and towards the viewer, as rows.

    A planar motion is viewed along its normal axis: no body moves along it or rotates about another
    axis. Other motions are viewed obliquely.
    """
    spread = np.ptp(position, axis=(0, 1)) > 0
    # The axes of the bodies, by what each row of R - 1 has.
    turns = np.abs(attitude[..., 1:]).max(axis=(0, 1)) > 1e-9
    x, y, z = np.eye(3)
    for depth, rows in ((2, (x, y, z)), (1, (x, z, -y)), (0, (y, z, x))):
        others = [axis for axis in range(3) if axis != depth]
        if not spread[depth] and not np.any(turns[others]):
            return _rows(rows)
    gravity = sum((np.array(g.g) for g in scene.all(UniformGravity)), np.zeros(3))
    up = z
    if abs(gravity[1]) > abs(gravity[2]):
        up = y
    side = np.roll(up, 1)
    level = np.cos(AZIMUTH) * side + np.sin(AZIMUTH) * np.cross(up, side)
    towards = np.cos(ELEVATION) * level + np.sin(ELEVATION) * up
    right = np.cross(up, towards) / np.linalg.norm(np.cross(up, towards))
    return _rows((right, np.cross(towards, right), towards))


def _rows(vectors: Iterable[Array]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(round(float(value), 6) for value in vector) for vector in vectors)
